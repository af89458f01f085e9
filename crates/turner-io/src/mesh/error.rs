//! Errors of mesh files.

use std::path::Path;

use turner::schema::error::suggestion;
use turner::schema::{Warning, WarningKind};

use super::Place;
use crate::assets::printable;
use crate::scene::{SceneFormat, nearest_mesh_extension};

/// Why a mesh could not be read: file, problem and remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// Neither the first bytes nor the extension belong to a supported format.
    #[error(
        "{name}: not a mesh file of a supported format{nearest}; expected {valid}\n  convert it to one of these"
    )]
    Unknown {
        /// The file.
        name: String,
        /// `"; the nearest is .ply"`, or empty.
        nearest: String,
        /// The supported formats.
        valid: String,
    },
    /// The file is not valid.
    #[error("{name}: damaged {format}: {place}: {problem}\n  export or download it again")]
    Damaged {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// The position in the file.
        place: Place,
        /// What was found and what was expected.
        problem: String,
    },
    /// A file without triangles: a point cloud, or empty.
    #[error(
        "{name}: has {vertices} vertices but no faces; expected a mesh of polygons{others}\n  \
         render a point cloud with `type = \"points\"`"
    )]
    Empty {
        /// The file.
        name: String,
        /// Number of vertices.
        vertices: usize,
        /// What the file has instead: `", found 12 × `l` elements (lines)"`, or empty.
        others: String,
    },
    /// No object, group or solid has the requested name.
    #[error("{name}: has no object or group \"{node}\"\n  {help}")]
    Node {
        /// The file.
        name: String,
        /// The requested name.
        node: String,
        /// The existing names.
        help: String,
    },
    /// More materials than a triangle's index can distinguish.
    #[error("{name}: more than 65536 materials\n  use fewer materials, or several files")]
    Materials {
        /// The file.
        name: String,
    },
    /// Out of memory.
    #[error("{name}: not enough memory for {count} vertices or faces\n  use a smaller mesh")]
    OutOfMemory {
        /// The file.
        name: String,
        /// Number of elements requested.
        count: usize,
    },
}

impl MeshError {
    pub(super) fn damaged(name: &str, format: SceneFormat, place: Place, problem: String) -> Self {
        Self::Damaged { name: printable(name), format: format.name(), place, problem: shortened(&problem) }
    }

    /// A file without triangles; `warnings` tell what was ignored.
    pub(super) fn empty(name: &str, vertices: usize, warnings: &[Warning]) -> Self {
        let name = printable(name);
        let elements = warnings.iter().filter(|w| w.kind == WarningKind::Ignored).filter_map(|w| {
            let message = w.message.strip_prefix(&name)?.strip_prefix(": ")?;
            Some(format!("{} × {}", w.count, message.split(" are ignored").next()?))
        });
        let list = elements.collect::<Vec<_>>().join(", ");
        let others = if list.is_empty() { list } else { format!(", found {list}") };
        Self::Empty { name, vertices, others }
    }

    pub(super) fn node(name: &str, node: &str, valid: &[String]) -> Self {
        let names: Vec<&str> = valid.iter().map(String::as_str).collect();
        let help = suggestion(node, &names).unwrap_or_else(|| "nothing in the file has a name".to_owned());
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

/// Reserves exactly `more` elements; an error instead of an abort when memory runs out.
pub(super) fn reserve<T>(v: &mut Vec<T>, more: usize, name: &str) -> Result<(), MeshError> {
    v.try_reserve_exact(more).map_err(|_| MeshError::OutOfMemory { name: printable(name), count: more })
}

/// Reserves at least `more` elements, growing geometrically.
pub(super) fn reserve_some<T>(v: &mut Vec<T>, more: usize, name: &str) -> Result<(), MeshError> {
    v.try_reserve(more).map_err(|_| MeshError::OutOfMemory { name: printable(name), count: more })
}

/// Appends a value; an error instead of an abort when memory runs out.
#[inline]
pub(super) fn push<T>(v: &mut Vec<T>, value: T, name: &str) -> Result<(), MeshError> {
    if v.len() == v.capacity() {
        reserve_some(v, 1, name)?;
    }
    v.push(value);
    Ok(())
}

/// Text that quotes a file, made printable and limited in length.
pub(super) fn shortened(text: &str) -> String {
    const MOST: usize = 240;
    let mut shown = printable(text.get(..text.floor_char_boundary(4 * MOST)).unwrap_or(text));
    if shown.chars().count() > MOST {
        shown = shown.chars().take(MOST).chain(['…']).collect();
    }
    shown
}
