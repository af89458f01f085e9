//! The scene under construction: its elements, what was made of them, and the lists that every importer fills.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

use turner::schema::{ColorSource, GroupId, MediumId};

use super::document::{Document, candidates, read_file};
use super::frame::Frame;
use super::materials::Materials;
use super::textures::TextureKey;
use crate::assets::AssetSource;
use crate::import::ImportOptions;
use crate::scene_import::report::Fault;
use crate::scene_import::{CommonParts, Place};

/// The scene under construction.
pub(super) struct Assembly<'a> {
    /// The lists that every importer fills; `Deref` gives access to them.
    pub(super) stock: CommonParts<'a>,
    pub(super) document: Rc<Document>,
    pub(super) frame: Frame,
    pub(super) materials: Materials,
    /// By element and use.
    pub(super) textures: BTreeMap<TextureKey, ColorSource>,
    /// By element.
    pub(super) media: BTreeMap<usize, Option<MediumId>>,
    /// Shape groups by element; `None` while one is under construction.
    pub(super) shape_groups: BTreeMap<usize, Option<GroupId>>,
    /// Elements whose unknown parts were reported.
    reported: BTreeSet<usize>,
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
    pub(super) fn new(
        assets: &'a dyn AssetSource,
        uri: &str,
        options: &'a ImportOptions,
        document: Document,
    ) -> Assembly<'a> {
        let mut stock = CommonParts::new(assets, uri, options);
        stock.files.clone_from(&document.files);
        Assembly {
            stock,
            document: Rc::new(document),
            frame: Frame::default(),
            materials: Materials::default(),
            textures: BTreeMap::new(),
            media: BTreeMap::new(),
            shape_groups: BTreeMap::new(),
            reported: BTreeSet::new(),
        }
    }

    /// Reports the parts of an object that nobody asked for, once.
    pub(super) fn finish(&mut self, object: &super::params::Object) {
        if self.reported.insert(object.node) {
            object.finish(&mut self.stock.report);
        }
    }

    /// Reads a file that the scene names; returns its path and bytes.
    pub(super) fn read(&self, name: &str, limit: u64, place: Place) -> Result<(String, Vec<u8>), Fault> {
        let (assets, paths) = (self.stock.assets, &self.document.paths);
        let (path, bytes, _) =
            read_file(assets, &self.stock.uri, paths, name, limit, false).map_err(|f| f.or_at(place))?;
        Ok((path, bytes))
    }

    /// The name under which an image is found, in the scene's folder or in one of its search paths.
    pub(super) fn picture_name(&self, name: &str) -> String {
        let name = name.replace('\\', "/");
        if self.document.paths.is_empty() {
            return name;
        }
        let all = candidates(&name, &self.document.paths);
        let is_there = |n: &String| {
            let path = self.stock.assets.resolve(&self.stock.uri, n);
            path.is_ok_and(|path| self.stock.assets.open(&path, u64::MAX).is_ok())
        };
        all.into_iter().find(is_there).unwrap_or(name)
    }
}
