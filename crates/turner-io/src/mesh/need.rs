//! What it takes to read a mesh file, known before its numbers are read.

use std::path::Path;

use turner::schema::{Limits, SceneError};

use super::ply;
use crate::assets::printable;
use crate::scene::SceneFormat;

/// Bytes of memory at the peak of reading per byte of the file, measured on files of millions of triangles.
const OBJ: u64 = 2;
const STL_BINARY: u64 = 2;
const STL_TEXT: u64 = 1;

/// Asks for what reading a file takes, and refuses one that announces too many triangles.
pub(crate) fn check(bytes: &[u8], name: &str, limits: &Limits) -> Result<(), SceneError> {
    let size = bytes.len() as u64;
    let of_file = |factor: u64| size.saturating_mul(factor);
    let called = || printable(name);
    let need = if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        let (bytes, triangles) = ply::need(bytes);
        limits.check_triangles(triangles, called)?;
        bytes
    } else {
        match SceneFormat::of_path(Path::new(name)) {
            Some(SceneFormat::Obj) => of_file(OBJ),
            Some(SceneFormat::Stl) if bytes.trim_ascii_start().starts_with(b"solid") => of_file(STL_TEXT),
            Some(SceneFormat::Stl) => of_file(STL_BINARY),
            // Known by its first bytes.
            Some(SceneFormat::Ply) => 0,
            Some(SceneFormat::Toml | SceneFormat::Gltf | SceneFormat::Pbrt | SceneFormat::Mitsuba) | None => {
                0
            }
        }
    };
    limits.memory.need(need, || format!("{}: reading it", called()))
}

/// Refuses a mesh of too many triangles.
pub(crate) fn check_triangles(count: usize, name: &str, limits: &Limits) -> Result<(), SceneError> {
    limits.check_triangles(count as u64, || printable(name))
}
