//! Materials: how a surface answers light. One file each; [`MaterialDesc`] is the table of their names in a scene.

mod classic;

pub use classic::{ClassicMaterial, Fresnel, ShadowKind};

use crate::scene::schema::family;

family! {
    /// Materials: in `[material.NAME]`, or in place as `material = { … }`. The `type` is "classic" unless given.
    pub enum MaterialDesc as "material", "materials" {
        Classic(ClassicMaterial),
    }
}

impl Default for MaterialDesc {
    fn default() -> MaterialDesc {
        MaterialDesc::Classic(ClassicMaterial::default())
    }
}
