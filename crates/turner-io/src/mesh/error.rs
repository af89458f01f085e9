//! What can be wrong with a mesh file.

use std::path::Path;

use turner::schema::error::suggestion;

use super::Place;
use crate::assets::printable;
use crate::scene::{SceneFormat, nearest_mesh_extension};

/// Why a mesh could not be read: the file, what was found, what was expected, the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// Neither first bytes nor extension belong to a format that is read.
    #[error("{name}: not a mesh that can be read{nearest}; expected {valid}\n  convert it to one of these")]
    Unknown {
        /// The file.
        name: String,
        /// `"; the nearest is .ply"`, or empty.
        nearest: String,
        /// The formats that are read.
        valid: String,
    },
    /// The file breaks the rules of its format.
    #[error("{name}: damaged {format}: {place}: {problem}\n  export or download it again")]
    Damaged {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// Where.
        place: Place,
        /// What was found and what was expected.
        problem: String,
    },
    /// A file without a triangle: a cloud of points, or nothing at all.
    #[error(
        "{name}: has {vertices} vertices but no faces; expected a mesh of polygons\n  \
         show a cloud of points as `type = \"points\"`"
    )]
    Empty {
        /// The file.
        name: String,
        /// How many vertices it has.
        vertices: usize,
    },
    /// An object, group or solid that was asked for by name is not there.
    #[error("{name}: has no object or group \"{node}\"\n  {help}")]
    Node {
        /// The file.
        name: String,
        /// The name asked for.
        node: String,
        /// The names there are.
        help: String,
    },
    /// More materials than triangles can tell apart.
    #[error("{name}: more than 65536 materials\n  use fewer materials, or several files")]
    Materials {
        /// The file.
        name: String,
    },
    /// There was not enough memory.
    #[error("{name}: not enough memory for {count} vertices or faces\n  use a smaller mesh")]
    OutOfMemory {
        /// The file.
        name: String,
        /// How many elements there was no room for.
        count: usize,
    },
}

impl MeshError {
    pub(super) fn damaged(name: &str, format: SceneFormat, place: Place, problem: String) -> Self {
        Self::Damaged { name: printable(name), format: format.name(), place, problem: shortened(&problem) }
    }

    pub(super) fn node(name: &str, node: &str, valid: &[String]) -> Self {
        let names: Vec<&str> = valid.iter().map(String::as_str).collect();
        let help = suggestion(node, &names).unwrap_or_else(|| "it has no names at all".to_owned());
        Self::Node { name: printable(name), node: shortened(node), help: shortened(&help) }
    }

    pub(super) fn materials(name: &str) -> Self {
        Self::Materials { name: printable(name) }
    }

    pub(super) fn unknown(name: &str) -> Self {
        let extension = Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase());
        let nearest = nearest_mesh_extension(&extension.unwrap_or_default());
        Self::Unknown { name: printable(name), nearest, valid: SceneFormat::mesh_listing() }
    }
}

/// Room for `more` values, or an error instead of an abort where memory is short.
pub(super) fn reserve<T>(v: &mut Vec<T>, more: usize, name: &str) -> Result<(), MeshError> {
    v.try_reserve_exact(more).map_err(|_| MeshError::OutOfMemory { name: printable(name), count: more })
}

/// Room for at least `more` values, and for more to come.
pub(super) fn reserve_some<T>(v: &mut Vec<T>, more: usize, name: &str) -> Result<(), MeshError> {
    v.try_reserve(more).map_err(|_| MeshError::OutOfMemory { name: printable(name), count: more })
}

/// One more value, or an error instead of an abort where memory is short.
#[inline]
pub(super) fn push<T>(v: &mut Vec<T>, value: T, name: &str) -> Result<(), MeshError> {
    if v.len() == v.capacity() {
        reserve_some(v, 1, name)?;
    }
    v.push(value);
    Ok(())
}

/// Text with parts of a file in it, safe for a terminal and not longer than a few lines.
pub(super) fn shortened(text: &str) -> String {
    const MOST: usize = 240;
    let mut shown = printable(text.get(..text.floor_char_boundary(4 * MOST)).unwrap_or(text));
    if shown.chars().count() > MOST {
        shown = shown.chars().take(MOST).chain(['…']).collect();
    }
    shown
}
