//! STL: triangles, as text or as 50 bytes each.
//!
//! Corners of the same three numbers become one vertex. Which side is outside is told by the order of the corners; the
//! normals that files store are only compared with it. Meshes have no vertex normals: facets, as these files mean them.
//!
//! Colours in the two spare bytes of binary facets become materials of the faces: those of VisCAM and SolidView (15 bits,
//! red in the highest, the top bit set) and those of Materialise Magics (`COLOR=` in the header, red in the lowest bits,
//! the top bit set for the colour of the whole). The solids of a text file become materials, too, by their names.

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

/// A file as it was read.
#[derive(Debug, Default)]
pub(super) struct StlFile {
    pub(super) mesh: MeshData,
    /// Colours of the face materials as display values of 8 bits, for files that have them.
    pub(super) colors: Vec<[u8; 3]>,
    /// Solids of a text file, 1 of a binary one.
    pub(super) solids: u64,
    pub(super) warnings: Vec<Warning>,
}

/// Reads a whole file as a mesh.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let StlFile { mesh, warnings, .. } = parse(bytes, name, &[])?;
    Ok(ReadMesh { mesh, warnings, texture: None })
}

/// Reads a file. Only the solids called one of `nodes` are kept, all if there are none.
pub(super) fn parse(bytes: &[u8], name: &str, nodes: &[String]) -> Result<StlFile, MeshError> {
    if is_text(bytes) {
        return ascii::read(bytes, name, nodes);
    }
    match nodes.first() {
        Some(node) => Err(MeshError::node(name, node, &[])),
        None => binary::read(bytes, name),
    }
}

/// Binary files may begin with "solid", too: their size says what they are, and else whether there are words.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if !start.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) {
        return false;
    }
    let count = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if count.is_some_and(|n| n > 0 && bytes.len() as u64 == HEADER as u64 + u64::from(n) * FACET as u64) {
        return false;
    }
    // The count and the first numbers of a binary file hold bytes that no text does.
    let sample = &start[..start.len().min(512)];
    !sample.iter().any(|&b| b < b' ' && !b.is_ascii_whitespace())
}

/// Whether a stored normal points to the other side than the corners turn; ones that say nothing do not.
fn is_against(normal: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> bool {
    let side = |to: [f32; 3]| [0, 1, 2].map(|i| f64::from(to[i]) - f64::from(a[i]));
    let (u, v) = (side(b), side(c));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let m = normal.map(f64::from);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = dot(n, m);
    // A sliver's normal means nothing.
    along < 0.0 && along * along > 0.01 * dot(n, n) * dot(m, m)
}

fn shown_name(words: &[u8]) -> String {
    printable(&String::from_utf8_lossy(words)).trim().to_owned()
}
