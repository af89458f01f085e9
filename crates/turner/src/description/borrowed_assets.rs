//! Hands images, meshes and other data through while a part of a scene is written and read back, without files or
//! copies.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::description::{ModelDesc, SceneAssetWriter, SceneAssets, SceneDesc};
use crate::image::Image;
use crate::schema::value::{FileId, Span};
use crate::schema::{
    Asset, GridData, GridFile, ImageId, LightProfile, MeshData, MeshId, ProfileFile, SceneError,
};

/// The data that the written parts refer to, by name.
#[derive(Default)]
pub(super) struct BorrowedAssets {
    images: BTreeMap<String, Arc<Image>>,
    meshes: BTreeMap<String, Arc<MeshData>>,
    profiles: BTreeMap<String, Arc<LightProfile>>,
    grids: BTreeMap<String, Arc<GridData>>,
}

/// Registers data and returns its name: its URI, with `'` appended while other data has that name.
fn lend<T>(lent: &mut BTreeMap<String, Arc<T>>, uri: &str, data: &Arc<T>) -> String {
    let mut name = uri.to_owned();
    while lent.get(&name).is_some_and(|other| !Arc::ptr_eq(other, data)) {
        name.push('\'');
    }
    lent.insert(name.clone(), Arc::clone(data));
    name
}

impl SceneAssetWriter for BorrowedAssets {
    fn image(&mut self, _: ImageId, image: &Asset<Image>) -> Result<String, SceneError> {
        Ok(lend(&mut self.images, &image.uri, &image.data))
    }
    fn mesh(&mut self, _: MeshId, mesh: &Asset<MeshData>) -> Result<Option<String>, SceneError> {
        Ok(Some(lend(&mut self.meshes, &mesh.uri, &mesh.data)))
    }
    fn light_profile(&mut self, profile: &ProfileFile) -> Result<String, SceneError> {
        Ok(lend(&mut self.profiles, &profile.uri, &profile.data))
    }
    fn grid(&mut self, grid: &GridFile) -> Result<String, SceneError> {
        Ok(lend(&mut self.grids, &grid.uri, &grid.data))
    }
}

/// Assets for reading the parts back. Values without a position refer to borrowed data, all others to files.
pub(super) struct WithBorrowed<'a> {
    pub(super) lent: &'a BorrowedAssets,
    pub(super) files: &'a mut dyn SceneAssets,
}

/// The data borrowed under a name.
fn find<T>(lent: &BTreeMap<String, Arc<T>>, uri: &str, from: FileId) -> Option<Arc<T>> {
    lent.get(uri).filter(|_| from == Span::NONE.file).cloned()
}

impl SceneAssets for WithBorrowed<'_> {
    fn image(&mut self, uri: &str, from: FileId) -> Result<Arc<Image>, SceneError> {
        find(&self.lent.images, uri, from).map_or_else(|| self.files.image(uri, from), Ok)
    }
    fn mesh(&mut self, uri: &str, from: FileId) -> Result<Arc<MeshData>, SceneError> {
        find(&self.lent.meshes, uri, from).map_or_else(|| self.files.mesh(uri, from), Ok)
    }
    fn light_profile(&mut self, uri: &str, from: FileId) -> Result<Arc<LightProfile>, SceneError> {
        find(&self.lent.profiles, uri, from).map_or_else(|| self.files.light_profile(uri, from), Ok)
    }
    fn grid(&mut self, uri: &str, from: FileId) -> Result<Arc<GridData>, SceneError> {
        find(&self.lent.grids, uri, from).map_or_else(|| self.files.grid(uri, from), Ok)
    }
    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        self.files.model(model, from)
    }
}
