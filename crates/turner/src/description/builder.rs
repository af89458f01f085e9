//! Conversions for building scenes in a program.

use crate::description::{ObjectContent, ObjectDesc, SceneLight};
use crate::light::LightDesc;
use crate::schema::Named;
use crate::shape::ShapeDesc;

impl ObjectDesc {
    /// A shape with the default material and no transform.
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
    /// Without a name or light group.
    fn from(value: LightDesc) -> SceneLight {
        SceneLight { value, ..SceneLight::default() }
    }
}
