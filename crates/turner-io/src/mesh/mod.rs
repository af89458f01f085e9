//! Triangle meshes from OBJ and PLY files in memory.
//!
//! Every index is checked against the number of vertices, and no memory is reserved for more elements than the
//! bytes of the file can hold. Polygons become fans of triangles around their first corner.

mod error;
mod obj;
mod ply;

pub use error::MeshError;

use crate::assets::printable;
use crate::scene::SceneFormat;
use std::path::Path;
use turner::shape::mesh::MeshData;

/// A mesh and what was ignored while reading it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadMesh {
    /// The mesh: at least one triangle, every index valid, every position in use finite.
    pub mesh: MeshData,
    /// What was ignored or made up, one sentence each, with the name of the file.
    pub warnings: Vec<String>,
}

/// Reads a mesh. PLY is known by its first bytes, OBJ by the extension of `name`.
pub fn decode(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let mut read = if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        ply::read(bytes, name)?
    } else {
        match SceneFormat::of_path(Path::new(name)) {
            Some(SceneFormat::Obj) => obj::read(bytes, name)?,
            Some(SceneFormat::Ply) => {
                let problem = "the first line is not `ply`".to_owned();
                return Err(MeshError::damaged(name, SceneFormat::Ply, Place::Line(1), problem));
            }
            _ => return Err(MeshError::unknown(name)),
        }
    };
    drop_not_finite(&mut read, name);
    if read.mesh.triangles.is_empty() {
        return Err(MeshError::Empty { name: printable(name), vertices: read.mesh.positions.len() });
    }
    Ok(read)
}

/// A place in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, from 1.
    Line(u64),
    /// A byte of a binary file, from 0.
    Byte(u64),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Place::Line(n) => write!(f, "line {n}"),
            Place::Byte(n) => write!(f, "byte {n}"),
        }
    }
}

/// Drops triangles with a corner that is not finite; makes numbers of normals, (u, v) and colours that are not finite zero.
fn drop_not_finite(read: &mut ReadMesh, name: &str) {
    let mesh = &mut read.mesh;
    let finite = |p: &[f32; 3]| p.iter().all(|v| v.is_finite());
    if !mesh.positions.iter().all(finite) {
        let before = mesh.triangles.len();
        let positions = &mesh.positions;
        let shown = |t: &[u32; 3]| t.iter().all(|&i| positions.get(i as usize).is_some_and(finite));
        let mut triangles = mesh.triangles.iter();
        mesh.face_materials.retain(|_| triangles.next().is_some_and(shown));
        mesh.triangles.retain(shown);
        let dropped = before - mesh.triangles.len();
        // Vertices that nothing uses any more must not spoil the bounds.
        mesh.positions.iter_mut().filter(|p| !finite(p)).for_each(|p| *p = [0.0; 3]);
        if dropped > 0 {
            let name = printable(name);
            read.warnings.push(format!("{name}: {dropped} triangles dropped: a corner is not finite"));
        }
    }
    let mut replaced = 0_usize;
    let flat = mesh.normals.as_flattened_mut().iter_mut().chain(mesh.uvs.as_flattened_mut());
    for value in flat.chain(mesh.colors.as_flattened_mut()) {
        if !value.is_finite() {
            *value = 0.0;
            replaced += 1;
        }
    }
    if replaced > 0 {
        let name = printable(name);
        read.warnings
            .push(format!("{name}: {replaced} numbers in normals, (u, v) and colours not finite, read as 0"));
    }
}

/// What every index must satisfy: `face` from 1, `index` as written in the file, `count` vertices.
fn bad_index(kind: &str, face: u64, index: i64, count: usize, first: i64) -> String {
    let valid = match count {
        0 => "there are none".to_owned(),
        _ => format!("there are {count} ({first} to {})", count as i64 - 1 + first),
    };
    format!("face {face} names {kind} {index}, but {valid}")
}
