//! A scene to build upon in a program.

use crate::description::{ObjectContent, ObjectDesc, SceneLight};
use crate::light::LightDesc;
use crate::schema::Named;
use crate::shape::ShapeDesc;

impl ObjectDesc {
    /// A shape where it is described, of the default material.
    pub fn new(shape: ShapeDesc) -> ObjectDesc {
        ObjectDesc { content: ObjectContent::Shape(shape), ..ObjectDesc::default() }
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
        SceneLight { value, ..SceneLight::default() }
    }
}
