//! What reading a value needs from the rest of the scene.

use std::sync::Arc;

use super::data::{Font, GridData, LightProfile, MeasuredBrdf, MeshData};
use super::value::{Span, Value};
use super::{ImageId, MaterialId, MediumId, MeshId, SceneError, TextureId, Warning, WarningKind};
use crate::color::Transfer;

/// Names defined elsewhere in the scene, the files it refers to, and the transfer curve of colours. The reader of
/// complete scenes implements it.
pub trait ReadContext {
    /// The film's transfer curve, which `#rrggbb` and colour names follow.
    fn transfer(&self) -> Transfer;
    /// The texture called `name`.
    fn texture_named(&self, name: &str) -> Option<TextureId>;
    /// The names of all textures, sorted.
    fn texture_names(&self) -> Vec<&str>;
    /// Reads a texture written in place and adds it to the scene.
    ///
    /// Errors: those of the texture; nesting that is too deep.
    fn inline_texture(&mut self, value: &Value) -> Result<TextureId, SceneError>;
    /// A material, by its name or written in place.
    ///
    /// Errors: an unknown name; those of the material.
    fn material(&mut self, value: &Value) -> Result<MaterialId, SceneError>;
    /// A medium, by its name or written in place.
    ///
    /// Errors: an unknown name; those of the medium.
    fn medium(&mut self, value: &Value) -> Result<MediumId, SceneError>;
    /// Reads an image file.
    ///
    /// Errors, as for all files: a file that cannot be read or decoded.
    fn image(&mut self, uri: &str, span: Span) -> Result<ImageId, SceneError>;
    /// Reads an IES file.
    fn light_profile(&mut self, uri: &str, span: Span) -> Result<Arc<LightProfile>, SceneError>;
    /// Reads a file of a measured BRDF.
    fn measured_brdf(&mut self, uri: &str, span: Span) -> Result<Arc<MeasuredBrdf>, SceneError>;
    /// Reads a density grid.
    fn grid(&mut self, uri: &str, span: Span) -> Result<Arc<GridData>, SceneError>;
    /// Reads a font file.
    fn font(&mut self, uri: &str, span: Span) -> Result<Arc<dyn Font>, SceneError>;
    /// Reads a mesh file.
    fn mesh_file(&mut self, uri: &str, span: Span) -> Result<MeshId, SceneError>;
    /// Adds a mesh written in place.
    fn inline_mesh(&mut self, mesh: MeshData) -> MeshId;
    /// The data of a mesh of this scene.
    fn mesh_data(&self, mesh: MeshId) -> Arc<MeshData>;
    /// Records a warning.
    fn remark(&mut self, warning: Warning);
    /// Records an error, so that reading can continue with a placeholder and find further errors.
    ///
    /// Errors: the error itself, if reading stops at the first one.
    fn fault(&mut self, error: SceneError) -> Result<(), SceneError> {
        Err(error)
    }
    /// The number of errors recorded so far.
    fn faults(&self) -> usize {
        0
    }
}

impl dyn ReadContext + '_ {
    /// The value that was read; `None` if reading it failed and the error was recorded.
    ///
    /// Errors: the error itself, if reading stops at the first one.
    pub fn noted<T>(&mut self, read: Result<T, SceneError>) -> Result<Option<T>, SceneError> {
        match read {
            Ok(value) => Ok(Some(value)),
            Err(error) => self.fault(error).map(|()| None),
        }
    }

    /// The same for a check that builds on earlier ones. Its error may be a consequence of theirs, so it is dropped if
    /// more than `before` errors were recorded.
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

    /// Records a warning of the kind [`WarningKind::Ignored`].
    pub fn warn(&mut self, span: Option<Span>, message: impl Into<String>) {
        self.remark(Warning { span, ..Warning::new(WarningKind::Ignored, message) });
    }
}
