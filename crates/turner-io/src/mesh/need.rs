//! Estimates the memory for reading a mesh file before it is read.

use std::path::Path;

use turner::schema::{Limits, SceneError};

use super::{hair, ply};
use crate::assets::printable;
use crate::scene::SceneFormat;

/// Peak memory per byte of the file, measured on files with millions of triangles.
const OBJ: u64 = 2;
const STL_BINARY: u64 = 2;
const STL_TEXT: u64 = 1;
const HAIR: u64 = 2;

/// Checks the memory limit for reading a file, and the triangle limit if the file announces its count.
pub(crate) fn check(bytes: &[u8], name: &str, limits: &Limits) -> Result<(), SceneError> {
    let size = bytes.len() as u64;
    let of_file = |factor: u64| size.saturating_mul(factor);
    let called = || printable(name);
    let need = if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        let (bytes, triangles) = ply::need(bytes);
        limits.check_triangles(triangles, called)?;
        bytes
    } else if bytes.starts_with(hair::MAGIC) {
        of_file(HAIR)
    } else {
        match SceneFormat::of_path(Path::new(name)) {
            Some(SceneFormat::Obj) => of_file(OBJ),
            Some(SceneFormat::Stl) if bytes.trim_ascii_start().starts_with(b"solid") => of_file(STL_TEXT),
            Some(SceneFormat::Stl) => of_file(STL_BINARY),
            // PLY is recognised by its first bytes, above.
            Some(SceneFormat::Ply) => 0,
            Some(
                SceneFormat::Toml
                | SceneFormat::Gltf
                | SceneFormat::Usd
                | SceneFormat::Pbrt
                | SceneFormat::Mitsuba,
            )
            | None => 0,
        }
    };
    limits.memory.need(need, || format!("{}: reading it", called()))
}

/// Checks the triangle limit.
pub(crate) fn check_triangles(count: usize, name: &str, limits: &Limits) -> Result<(), SceneError> {
    limits.check_triangles(count as u64, || printable(name))
}
