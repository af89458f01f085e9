//! Stanford PLY: ASCII and binary of either byte order, any scalar types, any extra properties and elements.
//!
//! Vertices: `x y z`, `nx ny nz`, `u v`, `s t` or `texture_u texture_v`, and `red green blue`, perhaps `alpha`. Faces: the list `vertex_indices` or
//! `vertex_index`. The layouts that programs write (binary, floats, one list of ints per face) are read straight
//! from the bytes; all others number by number.

mod header;
mod values;

use super::error::reserve;
use super::{MeshError, Place, ReadMesh, bad_index, warning};
use crate::assets::printable;
use crate::scene::SceneFormat;
use header::{Element, Encoding, Scalar};
use turner::color::Transfer;
use turner::scene::WarningKind;
use turner::shape::mesh::MeshData;
use values::{Values, binary};

/// What is wrong, and where.
#[derive(Debug)]
struct Fail {
    place: Place,
    problem: String,
}

/// The names under which (u, v) are found.
const UV_NAMES: [[&str; 2]; 4] =
    [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
const COLOR: [&str; 3] = ["red", "green", "blue"];
const ALPHA: &str = "alpha";
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads a whole file.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let damaged = |f: Fail| MeshError::damaged(name, SceneFormat::Ply, f.place, f.problem);
    let header = header::read(bytes).map_err(damaged)?;
    let mut data = Values::new(bytes, header.len, header.lines + 1, header.encoding);
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut mesh = MeshData::default();
    let mut ignored = 0;
    for element in &header.elements {
        check_count(element, header.encoding, &data).map_err(damaged)?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, header.encoding, &mut data, &mut mesh, name)?,
            "face" => {
                reserve(&mut mesh.triangles, element.count, name)?;
                ignored = read_faces(element, header.encoding, &mut data, &mut mesh.triangles, vertices)
                    .map_err(damaged)?;
            }
            _ => skip(element, &mut data).map_err(damaged)?,
        }
    }
    let mut warnings = Vec::new();
    if ignored > 0 {
        let message = "faces of fewer than three corners are ignored";
        warnings.push(warning(WarningKind::Ignored, name, ignored as u64, message));
    }
    Ok(ReadMesh { mesh, warnings, texture: None })
}

/// Refuses a number of elements that the rest of the file cannot hold.
fn check_count(element: &Element, encoding: Encoding, data: &Values<'_>) -> Result<(), Fail> {
    let least = element.least_bytes(encoding);
    if element.count > 0 && least == 0 && matches!(element.name.as_str(), "vertex" | "face") {
        return Err(data.fail(format!("the element \"{}\" has no properties", element.name)));
    }
    // The last number of a text needs no blank after it.
    let room = (data.rest().len() + 1) / least.max(1);
    if least == 0 || element.count <= room {
        return Ok(());
    }
    let (name, count) = (printable(&element.name), element.count);
    Err(data.fail(format!("{count} elements \"{name}\" announced, but the file has room for {room}")))
}

fn read_vertices(
    element: &Element,
    encoding: Encoding,
    data: &mut Values<'_>,
    mesh: &mut MeshData,
    name: &str,
) -> Result<(), MeshError> {
    let damaged = |f: Fail| MeshError::damaged(name, SceneFormat::Ply, f.place, f.problem);
    let has = |n: &&str| element.properties.iter().any(|p| p.name == *n && p.count.is_none());
    if let Some(missing) = POSITION.iter().find(|n| !has(n)) {
        return Err(damaged(data.fail(format!("vertices have no property \"{missing}\""))));
    }
    let has_normals = NORMAL.iter().all(has);
    let uv_names = UV_NAMES.iter().find(|names| names.iter().all(has));
    let has_colors = COLOR.iter().all(has);
    let n = element.count;
    reserve(&mut mesh.colors, if has_colors { n } else { 0 }, name)?;
    reserve(&mut mesh.positions, n, name)?;
    reserve(&mut mesh.normals, if has_normals { n } else { 0 }, name)?;
    reserve(&mut mesh.uvs, if uv_names.is_some() { n } else { 0 }, name)?;
    if encoding == Encoding::Ascii || element.has_lists() {
        return read_vertices_slowly(element, uv_names, has_normals, has_colors, data, mesh).map_err(damaged);
    }
    let stride: usize = element.properties.iter().map(|p| p.item.size()).sum();
    // `check_count` has seen that they fit.
    let rows = data.rest().get(..stride * n).unwrap_or(&[]);
    let big_endian = encoding == Encoding::BigEndian;
    columns(rows, stride, element, POSITION, big_endian, &mut mesh.positions);
    if has_normals {
        columns(rows, stride, element, NORMAL, big_endian, &mut mesh.normals);
    }
    if let Some(&names) = uv_names {
        columns(rows, stride, element, names, big_endian, &mut mesh.uvs);
    }
    if has_colors {
        let band = Band::all(element);
        mesh.colors.extend(rows.chunks_exact(stride).map(|row| {
            [0, 1, 2, 3].map(|i| match element.column(if i < 3 { COLOR[i] } else { ALPHA }) {
                Some((at, s)) => band[i].value(binary(row.get(at..).unwrap_or(&[]), s, big_endian)),
                None => 1.0,
            })
        }));
    }
    data.advance(stride * n);
    Ok(())
}

/// How a number becomes one of red, green, blue and opacity.
#[derive(Clone, Copy)]
struct Band {
    /// What stands for 1.
    full: f64,
    display: bool,
}

impl Band {
    /// Those of all four properties.
    fn all(element: &Element) -> [Band; 4] {
        [COLOR[0], COLOR[1], COLOR[2], ALPHA].map(|name| {
            let item = element.properties.iter().find(|p| p.name == name).map(|p| p.item);
            let full = match item {
                None | Some(Scalar::F32 | Scalar::F64) => 1.0,
                Some(Scalar::U16 | Scalar::I16) => 65535.0,
                Some(_) => 255.0,
            };
            Band { full, display: full > 1.0 && name != ALPHA }
        })
    }

    /// Whole numbers are display values, opacity apart; floating-point numbers are taken as they are.
    fn value(self, v: f64) -> f32 {
        let v = (v / self.full) as f32;
        if self.display { Transfer::Srgb.decode(v) } else { v }
    }
}

/// `N` properties of every row.
fn columns<const N: usize>(
    rows: &[u8],
    stride: usize,
    element: &Element,
    names: [&str; N],
    big_endian: bool,
    out: &mut Vec<[f32; N]>,
) {
    let found = names.map(|n| element.column(n).unwrap_or((0, Scalar::U8)));
    let rows = rows.chunks_exact(stride);
    if found.iter().all(|(_, s)| *s == Scalar::F32) {
        let word =
            |row: &[u8], at: usize| row.get(at..at + 4).and_then(|b| b.try_into().ok()).unwrap_or([0; 4]);
        if big_endian {
            out.extend(rows.map(|row| found.map(|(at, _)| f32::from_be_bytes(word(row, at)))));
        } else {
            out.extend(rows.map(|row| found.map(|(at, _)| f32::from_le_bytes(word(row, at)))));
        }
    } else {
        out.extend(
            rows.map(|row| found.map(|(at, s)| binary(row.get(at..).unwrap_or(&[]), s, big_endian) as f32)),
        );
    }
}

fn read_vertices_slowly(
    element: &Element,
    uv_names: Option<&[&str; 2]>,
    has_normals: bool,
    has_colors: bool,
    data: &mut Values<'_>,
    mesh: &mut MeshData,
) -> Result<(), Fail> {
    // Where each property goes: 0 to 2 the position, 3 to 5 the normal, 6 and 7 (u, v), 8 to 11 the colour, 12 nowhere.
    let uv_names = uv_names.copied().unwrap_or_default();
    let names: Vec<&str> =
        POSITION.into_iter().chain(NORMAL).chain(uv_names).chain(COLOR).chain([ALPHA]).collect();
    let target = |p: &header::Property| match p.count {
        None => names.iter().position(|n| *n == p.name).unwrap_or(12),
        Some(_) => 12,
    };
    let targets: Vec<usize> = element.properties.iter().map(target).collect();
    let bands = Band::all(element);
    let mut row = [0.0_f64; 13];
    row[11] = 1.0;
    for _ in 0..element.count {
        for (property, &target) in element.properties.iter().zip(&targets) {
            match property.count {
                None => row[target] = data.next(property.item)?,
                Some(count) => skip_list(count, property.item, data)?,
            }
        }
        if has_colors {
            mesh.colors.push([0, 1, 2, 3].map(|i| bands[i].value(row[8 + i])));
        }
        let [x, y, z, nx, ny, nz, u, v, ..] = row.map(|v| v as f32);
        mesh.positions.push([x, y, z]);
        if has_normals {
            mesh.normals.push([nx, ny, nz]);
        }
        if !uv_names[0].is_empty() {
            mesh.uvs.push([u, v]);
        }
    }
    Ok(())
}

/// Reads faces into triangles; returns how many had fewer than three corners.
fn read_faces(
    element: &Element,
    encoding: Encoding,
    data: &mut Values<'_>,
    triangles: &mut Vec<[u32; 3]>,
    vertices: usize,
) -> Result<usize, Fail> {
    let is_indices = |p: &header::Property| p.count.is_some() && INDICES.contains(&p.name.as_str());
    let Some(at) = element.properties.iter().position(is_indices) else {
        if element.count == 0 {
            return Ok(0);
        }
        return Err(data.fail("faces have no list \"vertex_indices\"".into()));
    };
    let mut ignored = 0;
    let mut face = 0;
    if let Some(layout) = FastFaces::of(element, at, encoding) {
        face = match encoding {
            Encoding::BigEndian => layout.read::<true>(element.count, data, triangles, vertices),
            _ => layout.read::<false>(element.count, data, triangles, vertices),
        };
    }
    let mut polygon = Vec::new();
    for face in face..element.count {
        for (i, property) in element.properties.iter().enumerate() {
            let Some(count) = property.count else {
                data.next(property.item)?;
                continue;
            };
            if i != at {
                skip_list(count, property.item, data)?;
                continue;
            }
            polygon.clear();
            for _ in 0..data.list_len(count, property.item)? {
                let index = data.next(property.item)?;
                if !(index >= 0.0 && index.fract() == 0.0 && index < vertices as f64) {
                    let face = face as u64 + 1;
                    return Err(data.fail(bad_index("vertex", face, index as i64, vertices, 0)));
                }
                polygon.push(index as u32);
            }
            match polygon.as_slice() {
                [first, rest @ ..] if rest.len() >= 2 => {
                    if triangles.try_reserve(rest.len() - 1).is_err() {
                        return Err(data.fail("not enough memory for the triangles".into()));
                    }
                    triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
                }
                _ => ignored += 1,
            }
        }
    }
    Ok(ignored)
}

/// The layout of nearly all binary files: one list of 32-bit indices after a byte or an int, perhaps between values
/// of fixed size.
struct FastFaces {
    before: usize,
    after: usize,
    count: Scalar,
}

impl FastFaces {
    fn of(element: &Element, at: usize, encoding: Encoding) -> Option<FastFaces> {
        let list = element.properties.get(at)?;
        let lists = element.properties.iter().filter(|p| p.count.is_some()).count();
        let plain = encoding != Encoding::Ascii && lists == 1;
        let ints = matches!(list.item, Scalar::I32 | Scalar::U32);
        let size = |ps: &[header::Property]| ps.iter().map(|p| p.item.size()).sum();
        let (before, after) = (size(&element.properties[..at]), size(&element.properties[at + 1..]));
        let count =
            list.count.filter(|c| matches!(c, Scalar::U8 | Scalar::I8 | Scalar::I32 | Scalar::U32))?;
        (plain && ints).then_some(FastFaces { before, after, count })
    }

    /// Reads triangles and quads up to the first face that is anything else or wrong; returns how many.
    fn read<const BIG: bool>(
        &self,
        faces: usize,
        data: &mut Values<'_>,
        triangles: &mut Vec<[u32; 3]>,
        vertices: usize,
    ) -> usize {
        let bytes = data.rest();
        let word = |b: &[u8], i: usize| {
            let four = b.get(4 * i..4 * i + 4).and_then(|w| w.try_into().ok()).unwrap_or([255; 4]);
            if BIG { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) }
        };
        let count_size = self.count.size();
        let (mut at, mut face) = (0, 0);
        while face < faces {
            let Some(list) = bytes.get(at + self.before..) else { break };
            let n = if count_size == 1 { list.first().copied().map_or(0, u32::from) } else { word(list, 0) };
            let len = count_size + 4 * (n as usize);
            if !(n == 3 || n == 4) || list.len() < len + self.after {
                break;
            }
            let corner = |i: usize| word(&list[count_size..], i);
            let [a, b, c] = [corner(0), corner(1), corner(2)];
            let d = if n == 4 { corner(3) } else { a };
            if [a, b, c, d].iter().any(|&i| i as usize >= vertices) {
                break;
            }
            // Room for one triangle per face has been made; quads may need more.
            if triangles.len() + 2 > triangles.capacity() && triangles.try_reserve(2).is_err() {
                break;
            }
            triangles.push([a, b, c]);
            if n == 4 {
                triangles.push([a, c, d]);
            }
            at += self.before + len + self.after;
            face += 1;
        }
        data.advance(at);
        face
    }
}

fn skip(element: &Element, data: &mut Values<'_>) -> Result<(), Fail> {
    // Without properties there is nothing to walk over, however many there are.
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            match property.count {
                None => data.next(property.item).map(|_| ())?,
                Some(count) => skip_list(count, property.item, data)?,
            }
        }
    }
    Ok(())
}

fn skip_list(count: Scalar, item: Scalar, data: &mut Values<'_>) -> Result<(), Fail> {
    for _ in 0..data.list_len(count, item)? {
        data.next(item)?;
    }
    Ok(())
}
