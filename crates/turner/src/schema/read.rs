//! What reading a value may need of the scene around it.

use std::sync::Arc;

use super::data::{GridData, LightProfile, MeshData};
use super::value::{Span, Value};
use super::{ImageId, MaterialId, MediumId, MeshId, SceneError, TextureId, Warning, WarningKind};
use crate::color::Transfer;

/// Names defined elsewhere in the scene, files, the meaning of hex colours. Who reads a whole scene implements it.
pub trait ReadContext {
    /// The film's transfer curve, which `#rrggbb` and colour names follow.
    fn transfer(&self) -> Transfer;
    /// The texture of that name.
    fn texture_named(&self, name: &str) -> Option<TextureId>;
    /// The names of all textures, sorted.
    fn texture_names(&self) -> Vec<&str>;
    /// A texture written in place.
    ///
    /// Errors: those of the texture; too deep a nesting.
    fn inline_texture(&mut self, value: &Value) -> Result<TextureId, SceneError>;
    /// A material by its name or written in place.
    ///
    /// Errors: an unknown name; those of the material.
    fn material(&mut self, value: &Value) -> Result<MaterialId, SceneError>;
    /// A medium by its name or written in place.
    ///
    /// Errors: an unknown name; those of the medium.
    fn medium(&mut self, value: &Value) -> Result<MediumId, SceneError>;
    /// A picture file.
    ///
    /// Errors: a file that cannot be read or decoded; so for all files.
    fn image(&mut self, uri: &str, span: Span) -> Result<ImageId, SceneError>;
    /// A file of a light's measurements.
    fn light_profile(&mut self, uri: &str, span: Span) -> Result<Arc<LightProfile>, SceneError>;
    /// A file of a medium's grid.
    fn grid(&mut self, uri: &str, span: Span) -> Result<Arc<GridData>, SceneError>;
    /// A mesh file.
    fn mesh_file(&mut self, uri: &str, span: Span) -> Result<MeshId, SceneError>;
    /// A mesh written in place.
    fn inline_mesh(&mut self, mesh: MeshData) -> MeshId;
    /// What a mesh of this scene holds.
    fn mesh_data(&self, mesh: MeshId) -> Arc<MeshData>;
    /// Notes a remark.
    fn remark(&mut self, warning: Warning);
    /// Notes an error, so that reading continues with a placeholder and finds further errors.
    ///
    /// Errors: the error itself, where reading stops at the first one.
    fn fault(&mut self, error: SceneError) -> Result<(), SceneError> {
        Err(error)
    }
    /// How many errors were noted.
    fn faults(&self) -> usize {
        0
    }
}

impl dyn ReadContext + '_ {
    /// The value that was read; `None` if it could not be read and the error was noted.
    ///
    /// Errors: the error itself, where reading stops at the first one.
    pub fn noted<T>(&mut self, read: Result<T, SceneError>) -> Result<Option<T>, SceneError> {
        match read {
            Ok(value) => Ok(Some(value)),
            Err(error) => self.fault(error).map(|()| None),
        }
    }

    /// The same for a check that follows others: its error may result from theirs and is dropped if any was noted
    /// after the first `before`.
    pub fn noted_after<T>(
        &mut self,
        before: usize,
        read: Result<T, SceneError>,
    ) -> Result<Option<T>, SceneError> {
        match read {
            Err(_) if self.faults() > before => Ok(None),
            read => self.noted(read),
        }
    }

    /// Notes something ignored or doubtful.
    pub fn warn(&mut self, span: Option<Span>, message: impl Into<String>) {
        self.remark(Warning { span, ..Warning::new(WarningKind::Ignored, message) });
    }
}
