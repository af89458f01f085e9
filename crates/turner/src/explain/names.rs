//! Names of objects, materials and lights, and the name that selects rays.

use super::model::RayNode;
use crate::description::{Labels, SceneDesc};
use crate::integrator::Prepared;
use crate::schema::MaterialId;

/// Names in a scene, not escaped for a terminal or a page.
#[derive(Clone, Copy)]
pub struct Names<'a> {
    /// The prepared scene.
    pub prepared: &'a Prepared,
    /// The description that it was prepared from.
    pub desc: &'a SceneDesc,
    /// Rays that hit an object or a material of this name are marked: [`RayNode::touches`].
    pub path_of: Option<&'a str>,
}

impl<'a> Names<'a> {
    fn labels(&self) -> Labels<'_> {
        Labels { scene: &self.prepared.scene, desc: self.desc }
    }

    /// `ball`, `tree / leaf`, or `sphere #4` for an object without a name.
    pub fn object(&self, primitive: u32, shape: &str) -> String {
        self.labels().object(primitive, shape)
    }

    /// The name of a material or, without one, its type.
    pub fn material(&self, id: MaterialId) -> String {
        self.labels().material(id)
    }

    /// The name of a material, if it has one.
    pub fn material_name(&self, id: MaterialId) -> Option<&'a str> {
        self.desc.materials.get(id.index())?.name.as_deref()
    }

    /// The name of a light, by its index in the prepared scene.
    pub fn light(&self, light: u32) -> String {
        self.labels().light(light)
    }

    /// Whether an object or its material has the name of `path_of`.
    pub fn touches(&self, primitive: u32, shape: &str, material: MaterialId) -> bool {
        let Some(wanted) = self.path_of else { return false };
        self.prepared.scene.object_name(primitive).is(wanted)
            || self.material_name(material) == Some(wanted)
            || wanted.contains('#') && self.object(primitive, shape) == wanted
    }

    /// Says what a ray hits.
    pub(super) fn hit(&self, node: &mut RayNode, primitive: u32, shape: &'static str, material: MaterialId) {
        node.target = self.object(primitive, shape);
        node.material = Some(self.material(material));
        node.material_id = Some(material);
        (node.primitive, node.shape) = (Some(primitive), shape);
        node.touches = self.touches(primitive, shape, material);
    }
}
