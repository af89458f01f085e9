//! The files that a scene names: meshes and pictures.

use turner::image::Image;
use turner::schema::{MeshData, Warning};

/// A file that a scene names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum SceneFile {
    /// A mesh by its name and its format: obj or ply.
    Mesh(String, &'static str),
    Picture(String),
}

/// A file that was read and decoded.
pub(crate) enum LoadedFile {
    Mesh(Box<LoadedMesh>),
    Image(Box<LoadedImage>),
}

/// A decoded mesh with its path.
pub(crate) struct LoadedMesh {
    pub(crate) path: String,
    pub(crate) mesh: MeshData,
    pub(crate) warnings: Vec<Warning>,
    /// For [`AssetSource::used`](crate::assets::AssetSource::used), if it was read ahead.
    pub(crate) mark: Option<String>,
}

/// A decoded image with its path and its encoded form.
pub(crate) struct LoadedImage {
    pub(crate) image: Image,
    pub(crate) path: String,
    pub(crate) bytes: Vec<u8>,
    /// As that of a mesh.
    pub(crate) mark: Option<String>,
}

impl LoadedFile {
    /// Its mark.
    pub(crate) fn mark(&mut self) -> Option<String> {
        match self {
            LoadedFile::Mesh(mesh) => mesh.mark.take(),
            LoadedFile::Image(image) => image.mark.take(),
        }
    }
}

/// Files that other threads read.
pub(crate) type FilesAhead<'a> = super::ahead::Ahead<'a, SceneFile, LoadedFile>;
