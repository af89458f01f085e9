//! What objects, materials and lights are called, and which of them `--path-of` means.

use std::collections::BTreeSet;

use turner::scene::error::{ErrorCode, SceneError, escape, suggestion};
use turner::scene::{Labels, MaterialId, Scene, SceneDesc};

/// Names of things in a scene, as the file has them: not yet fit for a terminal or a page.
#[derive(Clone, Copy)]
pub(super) struct Names<'a> {
    pub(super) scene: &'a Scene,
    pub(super) desc: &'a SceneDesc,
}

impl<'a> Names<'a> {
    fn labels(&self) -> Labels<'_> {
        Labels { scene: self.scene, desc: self.desc }
    }

    /// `ball`, `tree / leaf`, or `sphere #4` for what has no name.
    pub(super) fn object(&self, primitive: u32, shape: &str) -> String {
        self.labels().object(primitive, shape)
    }

    /// The name of a material, if it has one.
    pub(super) fn material_name(&self, id: MaterialId) -> Option<&'a str> {
        self.desc.materials.get(id.index())?.name.as_deref()
    }

    /// Its name, or what kind it is.
    pub(super) fn material(&self, id: MaterialId) -> String {
        self.labels().material(id)
    }

    /// A light by its number in the prepared scene.
    pub(super) fn light(&self, light: u32) -> String {
        self.labels().light(light)
    }

    /// Whether an object or a material has the name.
    pub(super) fn is(&self, wanted: &str, primitive: u32, shape: &str, material: MaterialId) -> bool {
        self.scene.object_name(primitive).is(wanted)
            || self.material_name(material) == Some(wanted)
            || wanted.contains('#') && self.object(primitive, shape) == wanted
    }

    /// Refuses names that neither an object nor a material has.
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
            "nothing in this scene has a name: call an object without one by its shape and number, e.g. \"sphere #0\"".to_owned()
        });
        Err(SceneError::new(ErrorCode::UnknownName, message).help(help))
    }
}
