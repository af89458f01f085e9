//! Triangle meshes and point clouds from OBJ, PLY and STL files, curves from HAIR files.
//!
//! All indices are checked, and memory is reserved only for as many elements as the file's bytes can hold. Convex
//! polygons become triangle fans, other polygons are triangulated by ear clipping. [`decode`] returns only the mesh;
//! [`import_obj`], [`import_ply`] and [`import_stl`] return a complete scene with materials.

mod corners;
mod error;
pub(crate) mod hair;
mod import;
pub(crate) mod mitsuba_hair;
mod mtl;
pub(crate) mod need;
mod number;
mod obj;
mod pictures;
pub mod ply;
pub(crate) mod polygon;
mod stl;
mod weld;

pub use error::MeshError;
use error::shortened;
pub use import::{import_obj, import_ply, import_stl};
pub(crate) use number::{parse_f64 as parse_number, quick_f64 as quick_number, quick_int as quick_whole};

use crate::assets::printable;
use crate::scene::SceneFormat;
use std::path::Path;
use turner::schema::MeshData;
use turner::schema::{Warning, WarningKind};

/// A mesh and the warnings of reading it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadMesh {
    /// The mesh: all indices valid, all positions finite. Without triangles it is a point cloud.
    pub mesh: MeshData,
    /// An image that the file names for its (u, v).
    pub texture: Option<String>,
    /// What was ignored or substituted, with the file name.
    pub warnings: Vec<Warning>,
}

/// Reads a mesh with at least one triangle. PLY is recognised by its first bytes, other formats by the extension of
/// `name`.
pub fn decode(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let read = decode_any(bytes, name)?;
    if read.mesh.triangles.is_empty() {
        return Err(MeshError::empty(name, read.mesh.positions.len(), &read.warnings));
    }
    Ok(read)
}

/// Reads a mesh, or a point cloud or curves, which have vertices but no triangles.
pub fn decode_any(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    if bytes.starts_with(hair::MAGIC) {
        return hair::read(bytes, name);
    }
    let mut read = if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        ply::read(bytes, name)?
    } else {
        match SceneFormat::of_path(Path::new(name)) {
            Some(SceneFormat::Obj) => obj::read(bytes, name)?,
            Some(SceneFormat::Stl) => stl::read(bytes, name)?,
            Some(SceneFormat::Ply) => {
                let problem = "the first line is not `ply`".to_owned();
                return Err(MeshError::damaged(name, SceneFormat::Ply, Place::Line(1), problem));
            }
            Some(
                SceneFormat::Toml
                | SceneFormat::Gltf
                | SceneFormat::Usd
                | SceneFormat::Pbrt
                | SceneFormat::Mitsuba,
            )
            | None => {
                return Err(MeshError::unknown(name));
            }
        }
    };
    drop_not_finite(&mut read, name);
    Ok(read)
}

/// A warning about a file.
fn warning(kind: WarningKind, name: &str, count: u64, message: &str) -> Warning {
    Warning { count, ..Warning::new(kind, format!("{}: {}", printable(name), shortened(message))) }
}

/// A position in a mesh file.
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

/// Drops triangles, or points of a point cloud, with non-finite positions. Replaces non-finite values of normals, (u,
/// v) and colours by zero.
fn drop_not_finite(read: &mut ReadMesh, name: &str) {
    let mesh = &mut read.mesh;
    let finite = |p: &[f32; 3]| p.iter().all(|v| v.is_finite());
    if !mesh.positions.iter().all(finite) {
        let positions = &mesh.positions;
        let (dropped, message) = if mesh.triangles.is_empty() {
            let kept = positions.iter().filter(|p| finite(p)).count();
            let mut points = mesh.positions.iter();
            mesh.colors.retain(|_| points.next().is_some_and(finite));
            let dropped = positions.len() - kept;
            // The other attributes of points are not used.
            (mesh.normals, mesh.uvs) = (Vec::new(), Vec::new());
            (mesh.tangents, mesh.more_uvs) = (Vec::new(), Vec::new());
            mesh.positions.retain(finite);
            (dropped, "points with NaN or infinite coordinates: removed")
        } else {
            let before = mesh.triangles.len();
            let shown = |t: &[u32; 3]| t.iter().all(|&i| positions.get(i as usize).is_some_and(finite));
            // What is left of a polygon are triangles.
            mesh.polygons = Vec::new();
            let mut triangles = mesh.triangles.iter();
            mesh.face_materials.retain(|_| triangles.next().is_some_and(shown));
            mesh.triangles.retain(shown);
            // Vertices that are now unused must not affect the bounds.
            let dropped = before - mesh.triangles.len();
            mesh.positions.iter_mut().filter(|p| !finite(p)).for_each(|p| *p = [0.0; 3]);
            if mesh.triangles.is_empty() {
                // It must not become a point cloud.
                *mesh = MeshData::default();
            }
            (dropped, "triangles with a NaN or infinite vertex: removed")
        };
        if dropped > 0 {
            read.warnings.push(warning(WarningKind::Doubtful, name, dropped as u64, message));
        }
    }
    let mut replaced = 0_u64;
    let flat = mesh.normals.as_flattened_mut().iter_mut().chain(mesh.uvs.as_flattened_mut());
    let flat = flat.chain(mesh.tangents.as_flattened_mut());
    let flat = flat.chain(mesh.more_uvs.iter_mut().flat_map(|set| set.as_flattened_mut()));
    for value in flat.chain(mesh.colors.as_flattened_mut()) {
        if !value.is_finite() {
            *value = 0.0;
            replaced += 1;
        }
    }
    if replaced > 0 {
        let message = "NaN or infinite values in normals, (u, v) and colours: read as 0";
        read.warnings.push(warning(WarningKind::Doubtful, name, replaced, message));
    }
}

/// The message for an invalid index: `face` counts from 1, `index` is as written in the file, `count` is the number
/// of elements and `first` the first valid index.
fn bad_index(kind: &str, face: u64, index: i64, count: usize, first: i64) -> String {
    let valid = match count {
        0 => "there are none".to_owned(),
        _ => format!("there are {count} ({first} to {})", count as i64 - 1 + first),
    };
    format!("face {face} refers to {kind} {index}, but {valid}")
}
