//! The files and arrays that values from Python name.
//!
//! A name of an array stands for the array. A file that Python's code names itself may lie anywhere: its author chose it.
//! What such a file names in turn must lie in its folder, as for every file.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use turner::description::{ModelDesc, SceneAssets, SceneDesc};
use turner::image::Image;
use turner::schema::value::FileId;
use turner::schema::{ErrorCode, Font, GridData, LightProfile, MeasuredBrdf, MeshData, SceneError};
use turner_io::assets::{AssetError, AssetSource, FolderAssets};
use turner_io::scene::{LoadOptions, SceneFiles, Sources, open_to};

use crate::arrays::Arrays;
use crate::places::PYTHON;

/// The assets of a scene that is made or edited in Python.
pub(crate) struct Assets<'a> {
    pub(crate) arrays: &'a Arrays,
    /// Files that Python's code names.
    named: SceneFiles<'a>,
    /// Files that the scene's own text names.
    own: SceneFiles<'a>,
    options: &'a LoadOptions,
    folder: &'a Path,
}

/// A folder that is opened when a file of it is read: a scene without files needs none.
struct Folder {
    path: PathBuf,
    options: LoadOptions,
    opened: OnceLock<FolderAssets>,
}

impl Folder {
    fn opened(&self) -> Result<&FolderAssets, AssetError> {
        if let Some(opened) = self.opened.get() {
            return Ok(opened);
        }
        let opened = open_to(FolderAssets::new(&self.path)?, &self.options)?;
        Ok(self.opened.get_or_init(|| opened))
    }
}

impl AssetSource for Folder {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        self.opened()?.read(uri, limit)
    }
    fn open<'a>(&'a self, uri: &str, limit: u64) -> Result<Box<dyn Read + 'a>, AssetError> {
        self.opened()?.open(uri, limit)
    }
    fn describe(&self, uri: &str) -> String {
        self.opened().map_or_else(|_| uri.to_owned(), |folder| folder.describe(uri))
    }
    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        self.opened()?.resolve(from, uri)
    }
}

/// The folder of a scene twice: with access to all files, and to those inside.
pub(crate) struct Folders {
    all: Folder,
    own: Folder,
}

impl Folders {
    /// Of the folder that relative paths start from.
    pub(crate) fn new(path: &Path, options: &LoadOptions) -> Folders {
        let folder = |options| Folder { path: path.to_owned(), options, opened: OnceLock::new() };
        let all = LoadOptions { allow_outside: true, ..options.clone() };
        Folders { all: folder(all), own: folder(options.clone()) }
    }
}

impl<'a> Assets<'a> {
    pub(crate) fn new(
        arrays: &'a Arrays,
        folders: &'a Folders,
        sources: &'a Sources,
        options: &'a LoadOptions,
        folder: &'a Path,
    ) -> Assets<'a> {
        let files = |assets: &'a Folder| {
            let mut files = SceneFiles::new(assets, sources);
            files.set_options(options.clone());
            files
        };
        Assets { arrays, named: files(&folders.all), own: files(&folders.own), options, folder }
    }

    fn files(&mut self, from: FileId) -> &mut SceneFiles<'a> {
        if from == PYTHON { &mut self.named } else { &mut self.own }
    }
}

impl SceneAssets for Assets<'_> {
    fn image(&mut self, uri: &str, from: FileId) -> Result<Arc<Image>, SceneError> {
        match self.arrays.images.get(uri) {
            Some(image) => Ok(image.clone()),
            None => self.files(from).image(uri, from),
        }
    }

    fn mesh(&mut self, uri: &str, from: FileId) -> Result<Arc<MeshData>, SceneError> {
        match self.arrays.meshes.get(uri) {
            Some(mesh) => Ok(mesh.clone()),
            None => self.files(from).mesh(uri, from),
        }
    }

    fn light_profile(&mut self, uri: &str, from: FileId) -> Result<Arc<LightProfile>, SceneError> {
        self.files(from).light_profile(uri, from)
    }

    fn measured_brdf(&mut self, uri: &str, from: FileId) -> Result<Arc<MeasuredBrdf>, SceneError> {
        self.files(from).measured_brdf(uri, from)
    }

    fn grid(&mut self, uri: &str, from: FileId) -> Result<Arc<GridData>, SceneError> {
        match self.arrays.grids.get(uri) {
            Some(grid) => Ok(grid.clone()),
            None => self.files(from).grid(uri, from),
        }
    }

    fn font(&mut self, uri: &str, from: FileId) -> Result<Arc<dyn Font>, SceneError> {
        self.files(from).font(uri, from)
    }

    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        if from != PYTHON {
            return self.own.model(model, from);
        }
        let path = self.folder.join(&model.file);
        let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str()))
        else {
            let message = format!("{}: expected the name of a model file", model.file);
            return Err(SceneError::new(ErrorCode::File, message));
        };
        let folders = Folders::new(folder, self.options);
        let sources = Sources::default();
        let mut files = SceneFiles::new(&folders.own, &sources);
        files.set_options(self.options.clone());
        files.model(&ModelDesc { file: name.to_owned(), ..model.clone() }, from)
    }
}
