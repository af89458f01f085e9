//! ASCII STL: `solid NAME`, then for each facet `facet normal`, `outer loop`, three `vertex`, `endloop`, `endfacet`.

use std::collections::HashMap;

use turner::schema::WarningKind;

use super::{StlFile, Welder, is_against, shown_name};
use crate::mesh::error::push;
use crate::mesh::number::{parse_f32, quick_f32};
use crate::mesh::polygon::Triangulator;
use crate::mesh::{MeshError, Place, warning};
use crate::scene::SceneFormat;

/// Splits a text into words and counts lines.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl<'a> Words<'a> {
    #[inline]
    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or(&[])
    }

    /// The next word; empty at the end of the text.
    #[inline]
    fn word(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let rest = self.rest();
        let len = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += len;
        &rest[..len]
    }

    #[inline]
    fn skip_blanks(&mut self) {
        while let Some(byte) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += u64::from(*byte == b'\n');
            self.at += 1;
        }
    }

    /// The rest of the line.
    fn line_rest(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let len = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += len;
        rest[..len].trim_ascii()
    }

    /// Three numbers; the error is the word that is not a number.
    #[inline]
    fn vector(&mut self) -> Result<[f32; 3], &'a [u8]> {
        let mut out = [0.0; 3];
        for slot in &mut out {
            self.skip_blanks();
            if let Some((value, len)) = quick_f32(self.rest())
                && self.rest().get(len).is_none_or(u8::is_ascii_whitespace)
            {
                self.at += len;
                *slot = value;
                continue;
            }
            let word = self.word();
            *slot = match parse_f32(word) {
                Some(value) => value,
                None if is_nan(word) => f32::NAN,
                None => return Err(word),
            };
        }
        Ok(out)
    }
}

/// Whether a word is one of C's spellings of NaN.
fn is_nan(word: &[u8]) -> bool {
    let bare = word.strip_prefix(b"-").unwrap_or(word);
    bare.get(..3).is_some_and(|w| w.eq_ignore_ascii_case(b"nan") || w == b"1.#")
}

/// The mesh so far, and the state for the following facets.
struct Reader<'a> {
    name: &'a str,
    file: StlFile,
    welder: Welder,
    cutter: Triangulator,
    normal: [f32; 3],
    corners: Vec<[f32; 3]>,
    names: Vec<String>,
    ids: HashMap<String, u16>,
    material: u16,
    shown: bool,
    against: u64,
    thin: u64,
}

pub(super) fn read(bytes: &[u8], name: &str, nodes: &[String]) -> Result<StlFile, MeshError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut words = Words { bytes, at: 0, line: 1 };
    let mut reader = Reader {
        name,
        file: StlFile::default(),
        welder: Welder::new(),
        cutter: Triangulator::new(),
        normal: [0.0; 3],
        corners: Vec::new(),
        names: Vec::new(),
        ids: HashMap::new(),
        material: 0,
        shown: nodes.is_empty(),
        against: 0,
        thin: 0,
    };
    loop {
        let word = words.word();
        if word.is_empty() {
            break;
        }
        let is = |keyword: &[u8]| word.eq_ignore_ascii_case(keyword);
        let result = if is(b"vertex") {
            words.vector().map(|v| reader.corners.push(v)).map_err(|w| ("`vertex x y z`", w))
        } else if is(b"facet") {
            match words.word() {
                w if w.eq_ignore_ascii_case(b"normal") => {
                    let normal = words.vector().map_err(|w| ("`facet normal x y z`", w));
                    normal.map(|n| reader.normal = n)
                }
                w => Err(("`facet normal x y z`", w)),
            }
        } else if is(b"outer") {
            reader.corners.clear();
            match words.word() {
                w if w.eq_ignore_ascii_case(b"loop") => Ok(()),
                w => Err(("`outer loop`", w)),
            }
        } else if is(b"endloop") {
            reader.polygon()?;
            Ok(())
        } else if is(b"solid") {
            let called = shown_name(words.line_rest());
            reader.shown = nodes.is_empty() || nodes.contains(&called);
            reader.solid(called)?;
            Ok(())
        } else if is(b"endsolid") {
            words.line_rest();
            Ok(())
        } else if is(b"endfacet") {
            Ok(())
        } else {
            Err(("`facet`, `outer loop`, `vertex`, `endloop`, `endfacet` or `endsolid`", word))
        };
        if let Err((expected, found)) = result {
            let found = match found {
                [] => "the end of the file".to_owned(),
                found => format!("\"{}\"", shown_name(&found[..found.len().min(40)])),
            };
            let problem = format!("expected {expected}, found {found}");
            return Err(MeshError::damaged(name, SceneFormat::Stl, Place::Line(words.line), problem));
        }
    }
    if let Some(node) = nodes.iter().find(|node| !reader.ids.contains_key(*node)) {
        return Err(MeshError::node(name, node, &reader.names));
    }
    Ok(reader.finish())
}

impl Reader<'_> {
    /// Begins a solid; a repeated name continues the earlier solid.
    fn solid(&mut self, called: String) -> Result<(), MeshError> {
        self.file.solids += 1;
        self.material = match self.ids.get(&called) {
            Some(&id) => id,
            None => {
                let id = u16::try_from(self.names.len()).map_err(|_| MeshError::materials(self.name))?;
                self.names.push(called.clone());
                self.ids.insert(called, id);
                id
            }
        };
        Ok(())
    }

    /// Adds the triangles of a loop.
    fn polygon(&mut self) -> Result<(), MeshError> {
        let corners = std::mem::take(&mut self.corners);
        let mut result = Ok(());
        if self.shown {
            self.thin += u64::from(corners.len() < 3);
            if let [a, b, c, ..] = corners[..] {
                self.against += u64::from(is_against(self.normal, [a, b, c]));
            }
            let (file, welder, name, material) = (&mut self.file, &mut self.welder, self.name, self.material);
            let mut add = |t: [usize; 3]| -> Result<(), MeshError> {
                let mut triangle = [0; 3];
                for (slot, i) in triangle.iter_mut().zip(t) {
                    *slot = welder.vertex(corners[i], name)?;
                }
                push(&mut file.mesh.triangles, triangle, name)?;
                push(&mut file.mesh.face_materials, material, name)
            };
            self.cutter.cut(corners.len(), |i| corners[i], &mut |t| {
                if result.is_ok() {
                    result = add(t);
                }
            });
        }
        // Reuse the allocation.
        self.corners = corners;
        self.corners.clear();
        result
    }

    fn finish(self) -> StlFile {
        let Reader { mut file, name, .. } = self;
        file.mesh.positions = self.welder.into_positions();
        if self.names.len() > 1 {
            file.mesh.material_names = self.names;
        } else {
            file.mesh.face_materials = Vec::new();
        }
        if self.thin > 0 {
            let message = "loops with fewer than three vertices are ignored";
            file.warnings.push(warning(WarningKind::Ignored, name, self.thin, message));
        }
        if self.against > 0 {
            let message = "facets whose normal opposes the order of their vertices: the order is used";
            file.warnings.push(warning(WarningKind::Doubtful, name, self.against, message));
        }
        file
    }
}
