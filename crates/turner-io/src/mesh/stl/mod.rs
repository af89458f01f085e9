//! STL: triangles, as text or binary with 50 bytes per facet.
//!
//! Corners with equal coordinates become one vertex. The order of the corners determines the front side; the stored
//! normals are only compared with it. Meshes have no vertex normals, because STL facets are flat.
//!
//! Colours in the two attribute bytes of binary facets become face materials. Two formats are known: VisCAM and
//! SolidView (15 bits, red in the highest; the top bit set if there is a colour), and Materialise Magics (`COLOR=` in
//! the header; red in the lowest bits; the top bit set for the colour of the object). The solids of a text file
//! become materials too, by name.

mod ascii;
mod binary;

use turner::schema::{MeshData, Warning};

use super::weld::Welder;
use super::{MeshError, ReadMesh};
use crate::assets::printable;

/// Bytes before the first facet of a binary file.
const HEADER: usize = 84;
/// Bytes of a binary facet.
const FACET: usize = 50;

/// A parsed file.
#[derive(Debug, Default)]
pub(super) struct StlFile {
    pub(super) mesh: MeshData,
    /// Display-encoded 8-bit colours of the face materials; empty if the file has none.
    pub(super) colors: Vec<[u8; 3]>,
    /// Number of solids; 1 in a binary file.
    pub(super) solids: u64,
    pub(super) warnings: Vec<Warning>,
}

/// Reads a file as a mesh.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let StlFile { mesh, warnings, .. } = parse(bytes, name, &[])?;
    Ok(ReadMesh { mesh, warnings, texture: None })
}

/// Parses a file. Keeps only the solids named in `nodes`; all if it is empty.
pub(super) fn parse(bytes: &[u8], name: &str, nodes: &[String]) -> Result<StlFile, MeshError> {
    if is_text(bytes) {
        return ascii::read(bytes, name, nodes);
    }
    match nodes.first() {
        Some(node) => Err(MeshError::node(name, node, &[])),
        None => binary::read(bytes, name),
    }
}

/// Whether a file is text. Binary files may also begin with "solid"; their size or control characters reveal them.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if !start.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) {
        return false;
    }
    let count = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if count.is_some_and(|n| n > 0 && bytes.len() as u64 == HEADER as u64 + u64::from(n) * FACET as u64) {
        return false;
    }
    // The count and the first numbers of a binary file contain control characters.
    let sample = &start[..start.len().min(512)];
    !sample.iter().any(|&b| b < b' ' && !b.is_ascii_whitespace())
}

/// Whether a stored normal points away from the front side; false for meaningless normals.
fn is_against(normal: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> bool {
    let side = |to: [f32; 3]| [0, 1, 2].map(|i| f64::from(to[i]) - f64::from(a[i]));
    let (u, v) = (side(b), side(c));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let m = normal.map(f64::from);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = dot(n, m);
    // The normal of a sliver is unreliable, so nearly perpendicular normals are accepted.
    along < 0.0 && along * along > 0.01 * dot(n, n) * dot(m, m)
}

fn shown_name(words: &[u8]) -> String {
    printable(&String::from_utf8_lossy(words)).trim().to_owned()
}
