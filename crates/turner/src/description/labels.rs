//! What things are called in messages.

use crate::description::SceneDesc;
use crate::scene::Scene;
use crate::schema::MaterialId;

/// Names of things of a scene, as its description has them: not yet fit for a terminal or a page.
#[derive(Clone, Copy)]
pub struct Labels<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What it was made from.
    pub desc: &'a SceneDesc,
}

impl Labels<'_> {
    /// `ball`, `tree / leaf`, or `sphere #4` for a primitive without a name, which is of the shape `shape`.
    pub fn object(&self, primitive: u32, shape: &str) -> String {
        let name = self.scene.object_name(primitive);
        let own = name.own.map_or_else(|| format!("{shape} #{primitive}"), str::to_owned);
        match name.instance {
            Some(instance) => format!("{instance} / {own}"),
            None => own,
        }
    }

    /// Its name, or what kind it is.
    pub fn material(&self, id: MaterialId) -> String {
        match self.desc.materials.get(id.index()) {
            Some(m) => m.name.clone().unwrap_or_else(|| format!("{} material", m.value.type_name())),
            None => "default material".to_owned(),
        }
    }

    /// A light by its number in the prepared scene.
    pub fn light(&self, light: u32) -> String {
        let source = self.scene.light_sources.get(light as usize).copied().flatten();
        match source.and_then(|i| self.desc.lights.get(i as usize).map(|l| (i, l))) {
            Some((i, l)) => l.name.clone().unwrap_or_else(|| format!("{} light #{i}", l.value.type_name())),
            None => format!("light #{light}"),
        }
    }
}
