//! Reads a text again with the images and meshes that are already in memory.

use std::path::Path;
use std::sync::Arc;

use turner::description::{ModelDesc, SceneAssets, SceneDesc, read_scene};
use turner::image::Image;
use turner::schema::value::FileId;
use turner::schema::{Asset, Font, GridData, LightProfile, MeasuredBrdf, MeshData, SceneError};

use crate::assets::AssetSource;
use crate::scene::{LoadOptions, SceneFiles, Sources, read_tree};

/// The scene in a text that is to become the file `out`. Images and meshes that `known` has under the same name are not
/// read again.
///
/// Errors: those of reading a scene.
pub(super) fn reread(
    text: &str,
    out: &Path,
    options: &LoadOptions,
    known: &SceneDesc,
) -> Result<SceneDesc, SceneError> {
    let assets = crate::scene::folder(out.parent().unwrap_or(Path::new("")), options)?;
    let name = out.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    reread_from(text, &name, &assets, options, known)
}

/// The same for files that are not on disk.
pub(super) fn reread_from(
    text: &str,
    name: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
    known: &SceneDesc,
) -> Result<SceneDesc, SceneError> {
    let mut sources = Sources::default();
    let root = read_tree(text.to_owned(), name, assets, &options.limits, &mut sources)?;
    let mut files = SceneFiles::new(assets, &sources);
    files.set_options(options.clone());
    let mut desc = read_scene(&root, &mut Known { known, files })?;
    desc.warnings.clear();
    Ok(desc)
}

struct Known<'a> {
    known: &'a SceneDesc,
    files: SceneFiles<'a>,
}

fn find<T>(list: &[Asset<T>], uri: &str, from: FileId) -> Option<Arc<T>> {
    let own = list.iter().find(|asset| asset.uri == uri && !uri.is_empty());
    own.filter(|_| from == FileId(0)).map(|asset| Arc::clone(&asset.data))
}

impl SceneAssets for Known<'_> {
    fn image(&mut self, uri: &str, from: FileId) -> Result<Arc<Image>, SceneError> {
        find(&self.known.images, uri, from).map_or_else(|| self.files.image(uri, from), Ok)
    }
    fn mesh(&mut self, uri: &str, from: FileId) -> Result<Arc<MeshData>, SceneError> {
        find(&self.known.meshes, uri, from).map_or_else(|| self.files.mesh(uri, from), Ok)
    }
    fn light_profile(&mut self, uri: &str, from: FileId) -> Result<Arc<LightProfile>, SceneError> {
        self.files.light_profile(uri, from)
    }
    fn measured_brdf(&mut self, uri: &str, from: FileId) -> Result<Arc<MeasuredBrdf>, SceneError> {
        self.files.measured_brdf(uri, from)
    }
    fn grid(&mut self, uri: &str, from: FileId) -> Result<Arc<GridData>, SceneError> {
        self.files.grid(uri, from)
    }
    fn font(&mut self, uri: &str, from: FileId) -> Result<Arc<dyn Font>, SceneError> {
        self.files.font(uri, from)
    }
    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        self.files.model(model, from)
    }
}
