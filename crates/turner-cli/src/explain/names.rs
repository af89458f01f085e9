//! Names of objects, materials and lights, and the selection of `--path-of`.

use std::collections::BTreeSet;

use turner::description::{Labels, SceneDesc};
use turner::integrator::Prepared;
use turner::scene::Scene;
use turner::schema::error::{escape, suggestion};
use turner::schema::{ErrorCode, MaterialId, SceneError};

/// Names in a scene, as the file has them: not yet escaped for a terminal or a page.
#[derive(Clone, Copy)]
pub(super) struct Names<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) scene: &'a Scene,
    pub(super) desc: &'a SceneDesc,
    /// The name given with `--path-of`.
    pub(super) path_of: Option<&'a str>,
}

impl<'a> Names<'a> {
    fn labels(&self) -> Labels<'_> {
        Labels { scene: self.scene, desc: self.desc }
    }

    /// `ball`, `tree / leaf`, or `sphere #4` for an object without a name.
    pub(super) fn object(&self, primitive: u32, shape: &str) -> String {
        self.labels().object(primitive, shape)
    }

    /// The name of a material, if it has one.
    pub(super) fn material_name(&self, id: MaterialId) -> Option<&'a str> {
        self.desc.materials.get(id.index())?.name.as_deref()
    }

    /// The type of a material; `None` for the default material.
    pub(super) fn material_kind(&self, id: MaterialId) -> Option<&'static str> {
        Some(self.desc.materials.get(id.index())?.value.type_name())
    }

    /// The name of a light, by its index in the prepared scene.
    pub(super) fn light(&self, light: u32) -> String {
        self.labels().light(light)
    }

    /// Whether an object or its material has the name given with `--path-of`.
    pub(super) fn touches(&self, primitive: u32, shape: &str, material: MaterialId) -> bool {
        let Some(wanted) = self.path_of else { return false };
        self.scene.object_name(primitive).is(wanted)
            || self.material_name(material) == Some(wanted)
            || wanted.contains('#') && self.object(primitive, shape) == wanted
    }

    /// An error if neither an object nor a material has this name.
    pub(super) fn check(&self, wanted: &str) -> Result<(), SceneError> {
        let materials = self.desc.materials.iter().filter_map(|m| m.name.as_deref());
        let objects = self.scene.object_names().iter().map(String::as_str);
        let valid: BTreeSet<&str> = materials.chain(objects).collect();
        // `sphere #4` stands for an object without a name.
        let number = wanted.rsplit_once('#').and_then(|(_, n)| n.parse::<u64>().ok());
        if valid.contains(wanted) || number.is_some_and(|n| n < self.scene.stats.primitives) {
            return Ok(());
        }
        let message = format!("--path-of: there is no object and no material \"{}\"", escape(wanted));
        let valid: Vec<&str> = valid.into_iter().collect();
        let help = suggestion(wanted, &valid).unwrap_or_else(|| {
            "no object or material of this scene has a name: use the shape and index of an object, e.g. \"sphere #0\"".to_owned()
        });
        Err(SceneError::new(ErrorCode::UnknownName, message).help(help))
    }
}
