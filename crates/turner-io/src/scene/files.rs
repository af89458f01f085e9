//! The files that a scene names: each is read, hashed and decoded once.

use super::LoadOptions;
use super::error::{asset_error, two_lines};
use super::hash::SceneHash;
use super::sources::Sources;
use crate::assets::{AssetError, AssetSource};
use crate::grid::{self, MAX_GRID};
use crate::ies::{self, MAX_IES};
use crate::image::{DecodeLimits, decode};
use crate::import::{ImportOptions, import};
use crate::mesh;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use turner::image::Image;
use turner::light::LightProfile;
use turner::medium::GridData;
use turner::scene::error::{ErrorCode, SceneError};
use turner::scene::value::FileId;
use turner::scene::{ModelDesc, SceneAssets, SceneDesc, Warning};
use turner::shape::mesh::MeshData;

/// Most bytes of one picture or mesh file: 4 GiB.
pub(super) const MAX_FILE: u64 = 4 << 30;
/// Most bytes of samples of all pictures together: 16 GiB.
const MAX_DECODED: u64 = 16 << 30;

/// Pictures and meshes through an [`AssetSource`]: the [`SceneAssets`] of files.
pub struct SceneFiles<'a> {
    assets: &'a dyn AssetSource,
    sources: &'a Sources,
    hash: SceneHash,
    images: HashMap<String, Arc<Image>>,
    meshes: HashMap<String, Arc<MeshData>>,
    profiles: HashMap<String, Arc<LightProfile>>,
    grids: HashMap<String, Arc<GridData>>,
    /// By path and options.
    models: HashMap<(String, String), Arc<SceneDesc>>,
    decoded: u64,
    warnings: Vec<Warning>,
    /// How the scene is loaded.
    pub(super) options: LoadOptions,
    /// Name and bytes of a file that was read already: the one that the user named.
    pub(super) given: Option<(String, Vec<u8>)>,
}

impl<'a> SceneFiles<'a> {
    /// Files named in the texts of `sources`.
    pub fn new(assets: &'a dyn AssetSource, sources: &'a Sources) -> Self {
        Self::with_hash(assets, sources, SceneHash::new())
    }

    /// With a hash that goes on from what was read before.
    pub(super) fn with_hash(assets: &'a dyn AssetSource, sources: &'a Sources, hash: SceneHash) -> Self {
        let (images, meshes) = (HashMap::new(), HashMap::new());
        SceneFiles {
            assets,
            sources,
            hash,
            images,
            meshes,
            profiles: HashMap::new(),
            grids: HashMap::new(),
            models: HashMap::new(),
            decoded: 0,
            warnings: Vec::new(),
            options: LoadOptions::default(),
            given: None,
        }
    }

    /// What was ignored, and the hash over all that was read.
    pub(super) fn finish(self) -> (Vec<Warning>, SceneHash) {
        (self.warnings, self.hash)
    }

    fn resolve(&self, uri: &str, from: FileId) -> Result<String, SceneError> {
        let from = self.sources.get(from).map_or(".", |file| file.uri.as_str());
        self.assets.resolve(from, uri).map_err(asset_error)
    }

    fn read(&mut self, kind: u8, path: &str) -> Result<Vec<u8>, SceneError> {
        let bytes = match self.given.take() {
            Some((name, bytes)) if name == path => bytes,
            given => {
                self.given = given;
                self.assets.read(path, MAX_FILE).map_err(asset_error)?
            }
        };
        self.hash.add(kind, &bytes);
        Ok(bytes)
    }
}

impl SceneAssets for SceneFiles<'_> {
    fn image(&mut self, uri: &str, from: FileId) -> Result<Arc<Image>, SceneError> {
        let path = self.resolve(uri, from)?;
        if let Some(image) = self.images.get(&path) {
            return Ok(image.clone());
        }
        let bytes = self.read(b'i', &path)?;
        let mut limits = DecodeLimits::default();
        limits.max_bytes = limits.max_bytes.min(MAX_DECODED - self.decoded);
        let image =
            decode(&bytes, &path, &limits).map_err(|e| two_lines(ErrorCode::Image, &e.to_string()))?;
        self.decoded += image.memory() as u64;
        let image = Arc::new(image);
        self.images.insert(path, image.clone());
        Ok(image)
    }

    fn mesh(&mut self, uri: &str, from: FileId) -> Result<Arc<MeshData>, SceneError> {
        let path = self.resolve(uri, from)?;
        if let Some(mesh) = self.meshes.get(&path) {
            return Ok(mesh.clone());
        }
        let bytes = self.read(b'm', &path)?;
        let read = mesh::decode_any(&bytes, &path).map_err(|e| two_lines(ErrorCode::Mesh, &e.to_string()))?;
        self.warnings.extend(read.warnings);
        let mesh = Arc::new(read.mesh);
        self.meshes.insert(path, mesh.clone());
        Ok(mesh)
    }

    fn light_profile(&mut self, uri: &str, from: FileId) -> Result<Arc<LightProfile>, SceneError> {
        let path = self.resolve(uri, from)?;
        if let Some(profile) = self.profiles.get(&path) {
            return Ok(profile.clone());
        }
        let bytes = self.assets.read(&path, MAX_IES).map_err(asset_error)?;
        self.hash.add(b'l', &bytes);
        let (profile, warnings) =
            ies::decode(&bytes, &path).map_err(|e| two_lines(ErrorCode::Profile, &e.to_string()))?;
        self.warnings.extend(warnings);
        let profile = Arc::new(profile);
        self.profiles.insert(path, profile.clone());
        Ok(profile)
    }

    fn grid(&mut self, uri: &str, from: FileId) -> Result<Arc<GridData>, SceneError> {
        let path = self.resolve(uri, from)?;
        if let Some(grid) = self.grids.get(&path) {
            return Ok(grid.clone());
        }
        let bytes = self.assets.read(&path, MAX_GRID).map_err(asset_error)?;
        self.hash.add(b'v', &bytes);
        let data = grid::decode(&bytes, &path).map_err(|e| two_lines(ErrorCode::Volume, &e.to_string()))?;
        let grid = Arc::new(data);
        self.grids.insert(path, grid.clone());
        Ok(grid)
    }

    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        let path = self.resolve(&model.file, from)?;
        let asked = &self.options.models;
        let options = ImportOptions {
            time: asked.time.unwrap_or(model.time),
            animation: asked.animation.clone().or_else(|| model.animation.clone()),
            variant: asked.variant.clone().or_else(|| model.variant.clone()),
            scene: model.scene.clone(),
            nodes: model.nodes.clone(),
            max_texture_size: self.options.max_texture_size,
            threads: self.options.threads,
        };
        let key = (path.clone(), format!("{options:?}"));
        if let Some(scene) = self.models.get(&key) {
            return Ok(scene.clone());
        }
        let bytes = self.read(b'g', &path)?;
        let assets = HashedAssets { inner: self.assets, read: Mutex::new(Vec::new()) };
        let scene = Arc::new(import(bytes, &path, &assets, &options)?);
        for hash in assets.read.into_inner().unwrap_or_else(|e| e.into_inner()) {
            self.hash.add(b'f', hash.as_bytes());
        }
        self.models.insert(key, scene.clone());
        Ok(scene)
    }
}

/// Files that a model names: each is hashed as it is read.
struct HashedAssets<'a> {
    inner: &'a dyn AssetSource,
    /// Names and hashes, in the order of reading.
    read: Mutex<Vec<String>>,
}

impl AssetSource for HashedAssets<'_> {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        let bytes = self.inner.read(uri, limit)?;
        let mut hash = SceneHash::new();
        hash.add(b'f', &bytes);
        let mut read = self.read.lock().unwrap_or_else(|e| e.into_inner());
        read.push(format!("{uri}:{}", hash.hex()));
        Ok(bytes)
    }

    fn describe(&self, uri: &str) -> String {
        self.inner.describe(uri)
    }

    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        self.inner.resolve(from, uri)
    }
}
