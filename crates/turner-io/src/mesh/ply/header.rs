//! The PLY header: elements, their properties, and the encoding of the data.

use super::Fail;
use super::write::unescaped;
use crate::mesh::Place;

/// Longest header, in bytes. Typical ones have less than 2 KiB; comments may be long.
const MAX_HEADER: usize = 1 << 20;
/// Most elements and properties together.
const MAX_PARTS: usize = 4096;

/// Encoding of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(word: &str) -> Option<Scalar> {
        Some(match word {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Size in a binary file, in bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }
}

/// A named value, or a list of values with its length in front.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) item: Scalar,
    /// The type of a list's length; `None` for a single value.
    pub(super) count: Option<Scalar>,
}

/// An element: `count` records with the same properties.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Least bytes of a record: empty lists in binary files, a digit and a space per number in ASCII.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> usize {
        let least = |p: &Property| match encoding {
            Encoding::Ascii => 2,
            _ => p.count.unwrap_or(p.item).size(),
        };
        self.properties.iter().map(least).sum()
    }

    /// Whether it has a property of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.properties.iter().any(|p| p.name == name)
    }

    /// Whether it has list properties.
    pub(super) fn has_lists(&self) -> bool {
        self.properties.iter().any(|p| p.count.is_some())
    }

    /// The byte offset and type of a property; `None` if a list precedes it.
    pub(super) fn column(&self, name: &str) -> Option<(usize, Scalar)> {
        let mut at = 0;
        for p in &self.properties {
            match p.count {
                None if p.name == name => return Some((at, p.item)),
                None => at += p.item.size(),
                Some(_) => return None,
            }
        }
        None
    }
}

/// A parsed header.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Length in bytes; the data begins there.
    pub(super) len: usize,
    /// Number of lines.
    pub(super) lines: u64,
    /// Images named in comments.
    pub(super) textures: Vec<String>,
    /// Material names.
    pub(super) materials: Vec<String>,
    /// The number of lines that begin with no word of PLY, and the first of them.
    pub(super) unknown: (u64, String),
}

/// Parses the header, including `end_header`.
pub(super) fn read(bytes: &[u8]) -> Result<Header, Fail> {
    let (mut encoding, mut elements, mut parts) = (None, Vec::<Element>::new(), 0);
    let (mut at, mut number, mut textures, mut materials) = (0, 0, Vec::new(), Vec::new());
    let (mut unknown, mut first_unknown) = (0, String::new());
    loop {
        number += 1;
        let fail = |problem: String| Fail { place: Place::Line(number), problem };
        let rest = &bytes[at.min(bytes.len())..bytes.len().min(MAX_HEADER)];
        let Some(end) = rest.iter().position(|&b| b == b'\n' || b == b'\r') else {
            return Err(fail("the header does not end; expected the line `end_header`".into()));
        };
        let line = String::from_utf8_lossy(&rest[..end]);
        // Lines end in \n, \r\n or \r.
        at += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["comment", "TextureFile", ..] => {
                let name = line.split_once("TextureFile").map_or("", |(_, name)| name.trim());
                textures.push(name.to_owned());
            }
            ["comment", "turner_material", ..] => {
                let name = line.split_once("turner_material").map_or("", |(_, name)| name.trim());
                materials.push(unescaped(name));
            }
            [] | ["ply" | "comment" | "obj_info", ..] => {}
            ["format", kind, ..] => {
                encoding = Some(match *kind {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => {
                        let expected = "expected ascii, binary_little_endian or binary_big_endian";
                        return Err(fail(format!("{expected}, found \"{kind}\"")));
                    }
                });
            }
            ["element"] | ["element", _] => {
                return Err(fail(format!("expected `element NAME COUNT`, found \"{line}\"")));
            }
            ["element", name, count, ..] => {
                let count = count.parse::<usize>().ok().filter(|&n| n < u32::MAX as usize);
                let Some(count) = count else {
                    return Err(fail(format!(
                        "expected a number of elements below 4294967295, found \"{line}\""
                    )));
                };
                if elements.iter().any(|e| e.name == *name) {
                    return Err(fail(format!("the element \"{name}\" is defined twice")));
                }
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
                parts += 1;
            }
            ["property", rest @ ..] => {
                let property = property(rest).ok_or_else(|| {
                    fail(format!(
                        "expected `property TYPE NAME` or `property list TYPE TYPE NAME`, found \"{line}\""
                    ))
                })?;
                let Some(element) = elements.last_mut() else {
                    return Err(fail("a property before the first element".into()));
                };
                element.properties.push(property);
                parts += 1;
            }
            ["end_header", ..] => {
                let Some(encoding) = encoding else {
                    return Err(fail("the line `format ascii 1.0` (or binary) is missing".into()));
                };
                let unknown = (unknown, first_unknown);
                return Ok(Header {
                    encoding,
                    elements,
                    len: at,
                    lines: number,
                    textures,
                    materials,
                    unknown,
                });
            }
            _ => {
                unknown += 1;
                if unknown == 1 {
                    first_unknown = line.trim().to_owned();
                }
            }
        }
        if parts > MAX_PARTS {
            return Err(fail(format!("more than {MAX_PARTS} elements and properties")));
        }
    }
}

fn property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", count, item, name] => {
            let count = Scalar::of(count).filter(|c| !matches!(c, Scalar::F32 | Scalar::F64))?;
            Some(Property { name: (*name).to_owned(), item: Scalar::of(item)?, count: Some(count) })
        }
        [item, name] => Some(Property { name: (*name).to_owned(), item: Scalar::of(item)?, count: None }),
        _ => None,
    }
}
