//! The scene under construction: named definitions, and the lists that every importer fills.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};

use turner::description::ObjectContent;
use turner::schema::{ColorSource, MaterialId, MediumId};

use super::frame::Frame;
use super::layers::Layers;
use super::materials::Materials;
use super::report::Fault;
use super::shapes::OpenCurves;
use super::source::Place;
use super::state::State;
use crate::assets::AssetSource;
use crate::import::ImportOptions;
use crate::scene_import::CommonParts;

/// A named texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Texture {
    pub(super) source: ColorSource,
}

/// The scene under construction.
pub(super) struct Assembly<'a> {
    /// The lists that every importer fills; `Deref` gives access to them.
    pub(super) stock: CommonParts<'a>,
    pub(super) frame: Frame,
    pub(super) materials: Materials,
    pub(super) layers: Layers,
    /// By name.
    pub(super) textures: BTreeMap<String, Texture>,
    pub(super) media: BTreeMap<String, MediumId>,
    /// The last object, if it has curves to which others may be added.
    pub(super) open_curves: Option<OpenCurves>,
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
            open_curves: None,
        }
    }

    /// Adds an object with the state's transforms.
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
