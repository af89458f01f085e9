//! The scene as it comes about: what directives name, and the lists of every import.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};

use turner::description::ObjectContent;
use turner::schema::{ColorSource, MaterialId, MediumId};

use super::frame::Frame;
use super::layers::Layers;
use super::materials::Materials;
use super::report::Fault;
use super::source::Place;
use super::state::State;
use crate::assets::AssetSource;
use crate::import::ImportOptions;
use crate::scene_import::CommonParts;

/// What a named texture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Texture {
    pub(super) source: ColorSource,
}

/// The scene in the making.
pub(super) struct Assembly<'a> {
    /// What it is made of; all of that is at hand here, too.
    pub(super) stock: CommonParts<'a>,
    pub(super) frame: Frame,
    pub(super) materials: Materials,
    pub(super) layers: Layers,
    /// By name.
    pub(super) textures: BTreeMap<String, Texture>,
    pub(super) media: BTreeMap<String, MediumId>,
}

impl<'a> Deref for Assembly<'a> {
    type Target = CommonParts<'a>;
    fn deref(&self) -> &CommonParts<'a> {
        &self.stock
    }
}

impl<'a> DerefMut for Assembly<'a> {
    fn deref_mut(&mut self) -> &mut CommonParts<'a> {
        &mut self.stock
    }
}

impl<'a> Assembly<'a> {
    pub(super) fn new(assets: &'a dyn AssetSource, uri: &str, options: &'a ImportOptions) -> Assembly<'a> {
        Assembly {
            stock: CommonParts::new(assets, uri, options),
            frame: Frame::default(),
            materials: Materials::default(),
            layers: Layers::default(),
            textures: BTreeMap::new(),
            media: BTreeMap::new(),
        }
    }

    /// Adds an object at the state's transform.
    pub(super) fn place(
        &mut self,
        content: ObjectContent,
        material: Option<MaterialId>,
        state: &State,
        place: Place,
    ) -> Result<(), Fault> {
        self.place_at(content, material, state.ctm, place)
    }
}
