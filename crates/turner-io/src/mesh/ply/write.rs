//! Writes a mesh as binary little-endian PLY, without loss.
//!
//! In addition to the usual properties it writes `u_1 v_1`, `u_2 v_2`, … (further UV sets), `tx ty tz tw` (tangents),
//! the face property `material`, and a line `comment turner_material NAME` for each material. Colours are linear
//! floats. Values are not rounded.

use std::io::{self, Write};

use turner::schema::{MeshData, fan};

use super::vertices::MORE_UV_NAMES;

/// Records that are buffered before a write.
const ROWS: usize = 1024;
/// Bytes of faces that are buffered before a write.
const BLOCK: usize = 1 << 16;
/// Most corners of a polygon: their number is a byte.
const MOST_CORNERS: usize = 255;
/// Longest header, in bytes; material names could make it longer.
const MAX_NAMES: usize = 512 << 10;

/// Writes a mesh whose lists are consistent ([`MeshData::check`]), block by block.
///
/// Errors: those of `out`; too many UV sets; material names that are too long together.
pub fn write(mesh: &MeshData, out: &mut dyn Write) -> io::Result<()> {
    let refuse = |what: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, what.to_owned()));
    if mesh.more_uvs.len() > MORE_UV_NAMES.len() {
        return refuse("a mesh with more than nine UV sets");
    }
    let mut header = String::from("ply\nformat binary_little_endian 1.0\ncomment written by Turner\n");
    for name in &mesh.material_names {
        header += &format!("comment turner_material {}\n", escaped(name));
    }
    if header.len() > MAX_NAMES {
        return refuse("a mesh whose material names have more than half a megabyte");
    }
    header += &format!("element vertex {}\n", mesh.positions.len());
    let mut lists: Vec<(&[&str], &[f32])> = vec![
        (&["x", "y", "z"], mesh.positions.as_flattened()),
        (&["nx", "ny", "nz"], mesh.normals.as_flattened()),
        (&["u", "v"], mesh.uvs.as_flattened()),
    ];
    lists.extend(MORE_UV_NAMES.iter().zip(&mesh.more_uvs).map(|(n, set)| (&n[..], set.as_flattened())));
    lists.push((&["tx", "ty", "tz", "tw"], mesh.tangents.as_flattened()));
    lists.push((&["red", "green", "blue", "alpha"], mesh.colors.as_flattened()));
    lists.retain(|(names, values)| !values.is_empty() && values.len() == names.len() * mesh.positions.len());
    for name in lists.iter().flat_map(|(names, _)| *names) {
        header += &format!("property float {name}\n");
    }
    if mesh.positions.is_empty() {
        header += "property float x\nproperty float y\nproperty float z\n";
    }
    let has_materials = !mesh.face_materials.is_empty();
    if !mesh.triangles.is_empty() {
        let faces = faces(mesh).count();
        header += &format!("element face {faces}\nproperty list uchar uint vertex_indices\n");
        if has_materials {
            header += "property ushort material\n";
        }
    }
    header += "end_header\n";
    out.write_all(header.as_bytes())?;
    let mut block = Vec::with_capacity(ROWS * 4 * lists.iter().map(|(names, _)| names.len()).sum::<usize>());
    for first in (0..mesh.positions.len()).step_by(ROWS) {
        block.clear();
        for row in first..mesh.positions.len().min(first + ROWS) {
            for (names, values) in &lists {
                let values = values.get(row * names.len()..(row + 1) * names.len()).unwrap_or_default();
                block.extend(values.iter().flat_map(|v| v.to_le_bytes()));
            }
        }
        out.write_all(&block)?;
    }
    block.clear();
    for (first, corners) in faces(mesh) {
        block.push(corners.len() as u8);
        block.extend(corners.iter().flat_map(|v| v.to_le_bytes()));
        if has_materials {
            let material = mesh.face_materials.get(first).copied().unwrap_or_default();
            block.extend(material.to_le_bytes());
        }
        if block.len() > BLOCK {
            out.write_all(&block)?;
            block.clear();
        }
    }
    out.write_all(&block)?;
    Ok(())
}

/// The corners of each face, and its first triangle: polygons whose triangles are fans, as readers make them of convex
/// ones, and the triangles of others.
fn faces(mesh: &MeshData) -> impl Iterator<Item = (usize, Vec<u32>)> {
    let mut first = 0;
    mesh.polygon_triangles().flat_map(move |triangles| {
        let start = first;
        first += triangles.len();
        match fan(triangles).filter(|corners| corners.len() <= MOST_CORNERS) {
            Some(corners) => vec![(start, corners)],
            None => triangles.iter().enumerate().map(|(i, t)| (start + i, t.to_vec())).collect(),
        }
    })
}

/// A name as part of a line: control characters, `%`, and spaces at either end become `%` and two hex digits per
/// byte.
fn escaped(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        let edge = c == ' ' && (out.is_empty() || name.ends_with(' '));
        if c.is_control() || c == '%' || edge {
            let mut bytes = [0; 4];
            c.encode_utf8(&mut bytes).bytes().for_each(|b| out += &format!("%{b:02x}"));
        } else {
            out.push(c);
        }
    }
    out
}

/// The inverse of [`escaped`].
pub(super) fn unescaped(text: &str) -> String {
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let code = tail.get(..2).and_then(|d| std::str::from_utf8(d).ok());
        let code = code.and_then(|d| u8::from_str_radix(d, 16).ok()).filter(|_| first == b'%');
        out.push(code.unwrap_or(first));
        rest = tail.get(if code.is_some() { 2 } else { 0 }..).unwrap_or_default();
    }
    String::from_utf8_lossy(&out).into_owned()
}
