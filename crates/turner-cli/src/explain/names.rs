//! What objects, materials and lights are called, and which of them `--path-of` means.

use std::collections::BTreeSet;

use turner::description::{Labels, SceneDesc};
use turner::integrator::Prepared;
use turner::scene::Scene;
use turner::schema::error::{escape, suggestion};
use turner::schema::{ErrorCode, MaterialId, SceneError};

/// Names of things in a scene, as the file has them: not yet fit for a terminal or a page.
#[derive(Clone, Copy)]
pub(super) struct Names<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) scene: &'a Scene,
    pub(super) desc: &'a SceneDesc,
    /// What `--path-of` asks for.
    pub(super) path_of: Option<&'a str>,
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

    /// What kind a material is of; `None` for the one of objects that have none.
    pub(super) fn material_kind(&self, id: MaterialId) -> Option<&'static str> {
        Some(self.desc.materials.get(id.index())?.value.type_name())
    }

    /// A light by its number in the prepared scene.
    pub(super) fn light(&self, light: u32) -> String {
        self.labels().light(light)
    }

    /// Whether an object or its material has the name that `--path-of` asks for.
    pub(super) fn touches(&self, primitive: u32, shape: &str, material: MaterialId) -> bool {
        let Some(wanted) = self.path_of else { return false };
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
            "nothing in this scene has a name: refer to an object by its shape and index, e.g. \"sphere #0\"".to_owned()
        });
        Err(SceneError::new(ErrorCode::UnknownName, message).help(help))
    }
}
