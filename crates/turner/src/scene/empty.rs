//! A scene to build upon in a program.

use std::sync::Arc;

use super::desc::{Named, ObjectContent, ObjectDesc, SceneDesc, SceneLight};
use super::error::{ErrorCode, SceneError, escape};
use super::model::ModelDesc;
use super::read::{SceneAssets, read_scene};
use super::transform::Transform;
use super::value::{Data, FileId, Span, Table, Value};
use crate::image::Image;
use crate::light::LightDesc;
use crate::shape::ShapeDesc;
use crate::shape::mesh::MeshData;

impl Default for SceneDesc {
    /// Nothing, with everything as a scene file has it that says nothing: 640x480 pixels, the classic integrator, a black background, framed from the front.
    fn default() -> SceneDesc {
        let span = Span { file: FileId(0), start: 0, end: 0 };
        match read_scene(&Value { data: Data::Table(Table::default()), span }, &mut NoFiles) {
            Ok(desc) => SceneDesc { warnings: Vec::new(), ..desc },
            Err(e) => unreachable!("every value has a default: {e}"),
        }
    }
}

impl ObjectDesc {
    /// A shape where it is described, of the default material.
    pub fn new(shape: ShapeDesc) -> ObjectDesc {
        ObjectDesc {
            name: None,
            span: None,
            content: ObjectContent::Shape(shape),
            material: None,
            light_group: None,
            transform: Transform::IDENTITY,
            motion: None,
        }
    }
}

impl<T> From<T> for Named<T> {
    /// Without a name.
    fn from(value: T) -> Named<T> {
        Named { name: None, span: None, value }
    }
}

impl From<LightDesc> for SceneLight {
    /// Without a name or group.
    fn from(value: LightDesc) -> SceneLight {
        SceneLight { name: None, group: None, span: None, value }
    }
}

/// Where there are none.
struct NoFiles;

impl NoFiles {
    fn refuse<T>(name: &str) -> Result<T, SceneError> {
        Err(SceneError::new(ErrorCode::File, format!("{}: there are no files", escape(name))))
    }
}

impl SceneAssets for NoFiles {
    fn image(&mut self, uri: &str, _: FileId) -> Result<Arc<Image>, SceneError> {
        NoFiles::refuse(uri)
    }
    fn mesh(&mut self, uri: &str, _: FileId) -> Result<Arc<MeshData>, SceneError> {
        NoFiles::refuse(uri)
    }
    fn model(&mut self, _: &ModelDesc, _: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        NoFiles::refuse("model")
    }
}
