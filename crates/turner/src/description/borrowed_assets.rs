//! Hands images, meshes and other data through while a part of a scene is written and read back, without files or
//! copies.

use std::collections::HashMap;
use std::sync::Arc;

use crate::description::{ModelDesc, SceneAssetWriter, SceneAssets, SceneDesc};
use crate::image::Image;
use crate::schema::value::{FileId, Span};
use crate::schema::{
    Asset, Font, FontFile, GridData, GridFile, ImageId, LightProfile, MeasuredBrdf, MeasuredFile, MeshData,
    MeshId, ProfileFile, SceneError,
};

/// Most vertices and triangles of a mesh without a file that a value contains itself.
const FEW: usize = 12;

/// The data that the written parts refer to, by name.
#[derive(Default)]
pub(crate) struct BorrowedAssets {
    /// By image.
    image_names: Vec<String>,
    /// By mesh.
    mesh_names: Vec<String>,
    images: HashMap<String, Arc<Image>>,
    meshes: HashMap<String, Arc<MeshData>>,
    profiles: HashMap<String, Arc<LightProfile>>,
    measured: HashMap<String, Arc<MeasuredBrdf>>,
    grids: HashMap<String, Arc<GridData>>,
    fonts: HashMap<String, Arc<dyn Font>>,
    /// Whether small meshes without a file are written in place.
    inline: bool,
}

/// Registers data and returns its name: its URI, or, if it has none or other data has that name, the URI with `'` and a
/// number.
fn lend<T: ?Sized>(lent: &mut HashMap<String, Arc<T>>, uri: &str, data: &Arc<T>, number: usize) -> String {
    let is_taken = |name: &str, lent: &HashMap<String, Arc<T>>| {
        name.is_empty() || lent.get(name).is_some_and(|other| !Arc::ptr_eq(other, data))
    };
    let (mut name, mut next) = (uri.to_owned(), number);
    while is_taken(&name, lent) {
        name = format!("{uri}'{next}");
        next += 1;
    }
    lent.insert(name.clone(), Arc::clone(data));
    name
}

impl BorrowedAssets {
    /// All images and meshes of a description. Their names depend on the description alone, so values that
    /// [`SceneDesc::value_at`] returned still refer to the same data in a later edit.
    pub(crate) fn of(desc: &SceneDesc) -> BorrowedAssets {
        let mut lent = BorrowedAssets::default();
        let images = desc.images.iter().enumerate();
        lent.image_names = images.map(|(i, a)| lend(&mut lent.images, &a.uri, &a.data, i)).collect();
        let meshes = desc.meshes.iter().enumerate();
        lent.mesh_names = meshes.map(|(i, a)| lend(&mut lent.meshes, &a.uri, &a.data, i)).collect();
        lent
    }

    /// The same; small meshes without a file are written in place.
    pub(super) fn with_small_meshes_in_place(desc: &SceneDesc) -> BorrowedAssets {
        BorrowedAssets { inline: true, ..BorrowedAssets::of(desc) }
    }
}

impl SceneAssetWriter for BorrowedAssets {
    fn image(&mut self, id: ImageId, image: &Asset<Image>) -> Result<String, SceneError> {
        Ok(self.image_names.get(id.index()).unwrap_or(&image.uri).clone())
    }
    fn mesh(&mut self, id: MeshId, mesh: &Asset<MeshData>) -> Result<Option<String>, SceneError> {
        let is_small = mesh.data.positions.len().max(mesh.data.triangles.len()) <= FEW;
        if self.inline && mesh.uri.is_empty() && is_small {
            return Ok(None);
        }
        Ok(Some(self.mesh_names.get(id.index()).unwrap_or(&mesh.uri).clone()))
    }
    fn light_profile(&mut self, profile: &ProfileFile) -> Result<String, SceneError> {
        let next = self.profiles.len();
        Ok(lend(&mut self.profiles, &profile.uri, &profile.data, next))
    }
    fn measured_brdf(&mut self, measured: &MeasuredFile) -> Result<String, SceneError> {
        let next = self.measured.len();
        Ok(lend(&mut self.measured, &measured.uri, &measured.data, next))
    }
    fn grid(&mut self, grid: &GridFile) -> Result<String, SceneError> {
        let next = self.grids.len();
        Ok(lend(&mut self.grids, &grid.uri, &grid.data, next))
    }
    fn font(&mut self, font: &FontFile) -> Result<String, SceneError> {
        let next = self.fonts.len();
        Ok(lend(&mut self.fonts, &font.uri, &font.font, next))
    }
}

/// Assets for reading the parts back. Values without a position refer to borrowed data, all others to files.
pub(super) struct WithBorrowed<'a> {
    pub(super) lent: &'a BorrowedAssets,
    pub(super) files: &'a mut dyn SceneAssets,
}

/// The data borrowed under a name.
fn find<T: ?Sized>(lent: &HashMap<String, Arc<T>>, uri: &str, from: FileId) -> Option<Arc<T>> {
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
    fn measured_brdf(&mut self, uri: &str, from: FileId) -> Result<Arc<MeasuredBrdf>, SceneError> {
        find(&self.lent.measured, uri, from).map_or_else(|| self.files.measured_brdf(uri, from), Ok)
    }
    fn grid(&mut self, uri: &str, from: FileId) -> Result<Arc<GridData>, SceneError> {
        find(&self.lent.grids, uri, from).map_or_else(|| self.files.grid(uri, from), Ok)
    }
    fn font(&mut self, uri: &str, from: FileId) -> Result<Arc<dyn Font>, SceneError> {
        find(&self.lent.fonts, uri, from).map_or_else(|| self.files.font(uri, from), Ok)
    }
    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        self.files.model(model, from)
    }
}
