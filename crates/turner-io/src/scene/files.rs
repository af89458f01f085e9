//! The files that a scene names. Each is read, hashed and decoded once.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;
use std::sync::{Arc, Mutex};

use turner::description::{ModelDesc, SceneAssets, SceneDesc};
use turner::image::Image;
use turner::schema::value::FileId;
use turner::schema::{ErrorCode, Font, GridData, LightProfile, MeasuredBrdf, MeshData, SceneError, Warning};

use super::error::two_lines;
use super::hash::SceneHash;
use super::sources::Sources;
use super::{LoadOptions, SceneFormat};
use crate::assets::{AssetError, AssetSource, printable};
use crate::font::{self, MAX_FONT};
use crate::grid::{self, MAX_GRID};
use crate::ies::{self, MAX_IES};
use crate::image::{ColorOrData, DecodeLimits, decode, to_fit};
use crate::import::{ImportOptions, import};
use crate::measured::{self, MAX_BSDF};
use crate::mesh;

/// Largest image or mesh file: 4 GiB.
pub(super) const MAX_FILE: u64 = 4 << 30;
/// Most bytes of decoded pixels of all images together: 16 GiB.
const MAX_DECODED: u64 = 16 << 30;

/// The [`SceneAssets`] of files: loads images, meshes, light profiles, measured BRDFs, grids, fonts and models through an [`AssetSource`].
pub struct SceneFiles<'a> {
    assets: &'a dyn AssetSource,
    sources: &'a Sources,
    hash: SceneHash,
    images: HashMap<String, Arc<Image>>,
    meshes: HashMap<String, Arc<MeshData>>,
    profiles: HashMap<String, Arc<LightProfile>>,
    measured: HashMap<String, Arc<MeasuredBrdf>>,
    grids: HashMap<String, Arc<GridData>>,
    fonts: HashMap<String, Arc<dyn Font>>,
    /// By path and import options.
    models: HashMap<(String, String), Arc<SceneDesc>>,
    decoded: u64,
    warnings: Vec<Warning>,
    /// The options that the scene is loaded with.
    pub(super) options: LoadOptions,
    /// The file that the user named, if it is already in memory.
    pub(super) given: Option<Given>,
    /// Length of a frame in seconds, if motion is blurred.
    pub(super) frame: Option<f64>,
}

/// A file that is already in memory.
pub(super) struct Given {
    /// Its path.
    pub(super) path: String,
    /// Its bytes.
    pub(super) bytes: Vec<u8>,
}

/// The import options of a model: the model's own keys, unless the load options replace them.
fn import_options(asked: &LoadOptions, model: Option<&ModelDesc>) -> ImportOptions {
    ImportOptions {
        time: asked.models.time.or(model.map(|m| m.time)).unwrap_or(0.0),
        animation: asked.models.animation.clone().or_else(|| model?.animation.clone()),
        variant: asked.models.variant.clone().or_else(|| model?.variant.clone()),
        scene: model.and_then(|m| m.scene.clone()),
        nodes: model.map_or_else(Vec::new, |m| m.nodes.clone()),
        defines: asked.defines.clone(),
        max_texture_size: asked.max_texture_size,
        threads: asked.threads,
        limits: asked.limits.clone(),
        kept_pictures: asked.kept_pictures.clone(),
    }
}

/// Imports a scene of another renderer, read as a stream. Also returns the names and hashes of all files read.
pub(super) fn import_whole(
    path: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
) -> Result<(SceneDesc, Vec<String>), SceneError> {
    options.limits.memory.begin(format!("{}: reading it", printable(path)));
    let hashed = HashedAssets { inner: assets, read: Mutex::new(Vec::new()) };
    let scene = crate::import::import_file(path, &hashed, &import_options(options, None))?;
    let names = hashed.read.into_inner().unwrap_or_else(|e| e.into_inner());
    Ok((scene, names))
}

impl<'a> SceneFiles<'a> {
    /// Files named in the texts of `sources`.
    pub fn new(assets: &'a dyn AssetSource, sources: &'a Sources) -> Self {
        Self::with_hash(assets, sources, SceneHash::new())
    }

    /// Continues a hash over what was read before.
    pub(super) fn with_hash(assets: &'a dyn AssetSource, sources: &'a Sources, hash: SceneHash) -> Self {
        let (images, meshes) = (HashMap::new(), HashMap::new());
        SceneFiles {
            assets,
            sources,
            hash,
            images,
            meshes,
            profiles: HashMap::new(),
            measured: HashMap::new(),
            grids: HashMap::new(),
            fonts: HashMap::new(),
            models: HashMap::new(),
            decoded: 0,
            warnings: Vec::new(),
            options: LoadOptions::default(),
            given: None,
            frame: None,
        }
    }

    /// Sets the options that the scene is loaded with.
    pub fn set_options(&mut self, options: LoadOptions) {
        self.options = options;
    }

    /// The warnings, and the hash over everything read.
    pub(super) fn finish(self) -> (Vec<Warning>, SceneHash) {
        (self.warnings, self.hash)
    }

    /// Adds names and hashes of files that an import read.
    pub(super) fn add_hashes(&mut self, hashes: &[String]) {
        hashes.iter().for_each(|hash| self.hash.add(b'f', hash.as_bytes()));
    }

    fn resolve(&self, uri: &str, from: FileId) -> Result<String, SceneError> {
        let from = self.sources.get(from).map_or(".", |file| file.uri.as_str());
        self.assets.resolve(from, uri).map_err(|e| e.to_scene_error())
    }

    fn read(&mut self, kind: u8, path: &str) -> Result<Vec<u8>, SceneError> {
        let bytes = match self.given.take() {
            Some(given) if given.path == path => given.bytes,
            given => {
                self.given = given;
                self.assets.read(path, MAX_FILE).map_err(|e| e.to_scene_error())?
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
        self.options.limits.memory.begin(format!("{}: reading it", printable(&path)));
        let mut limits = DecodeLimits::of_scene(&self.options.limits, self.options.max_texture_size, 1);
        limits.max_bytes = limits.max_bytes.min(MAX_DECODED.saturating_sub(self.decoded));
        let fit = |image| match self.options.max_texture_size {
            Some(max) => to_fit(image, max, ColorOrData::Color, &path),
            None => Ok(image),
        };
        let image = decode(&bytes, &path, &limits).and_then(fit).map_err(|e| e.to_scene_error())?;
        self.decoded += image.memory() as u64;
        let image = Arc::new(image);
        // A downscaled image no longer has the pixels of its file.
        if let (Some(kept), None) = (&self.options.kept_pictures, self.options.max_texture_size) {
            kept.keep(&image, &path, bytes);
        }
        self.images.insert(path, image.clone());
        Ok(image)
    }

    fn mesh(&mut self, uri: &str, from: FileId) -> Result<Arc<MeshData>, SceneError> {
        let path = self.resolve(uri, from)?;
        if let Some(mesh) = self.meshes.get(&path) {
            return Ok(mesh.clone());
        }
        let bytes = self.read(b'm', &path)?;
        let limits = &self.options.limits;
        limits.memory.begin(format!("{}: reading it", printable(&path)));
        mesh::need::check(&bytes, &path, limits)?;
        let read = mesh::decode_any(&bytes, &path).map_err(|e| two_lines(ErrorCode::Mesh, &e.to_string()))?;
        mesh::need::check_triangles(read.mesh.triangles.len(), &path, limits)?;
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
        let bytes = self.assets.read(&path, MAX_IES).map_err(|e| e.to_scene_error())?;
        self.hash.add(b'l', &bytes);
        let (profile, warnings) =
            ies::decode(&bytes, &path).map_err(|e| two_lines(ErrorCode::Profile, &e.to_string()))?;
        self.warnings.extend(warnings);
        let profile = Arc::new(profile);
        self.profiles.insert(path, profile.clone());
        Ok(profile)
    }

    fn measured_brdf(&mut self, uri: &str, from: FileId) -> Result<Arc<MeasuredBrdf>, SceneError> {
        let path = self.resolve(uri, from)?;
        if let Some(measured) = self.measured.get(&path) {
            return Ok(measured.clone());
        }
        let bytes = self.assets.read(&path, MAX_BSDF).map_err(|e| e.to_scene_error())?;
        self.hash.add(b'b', &bytes);
        let memory = &self.options.limits.memory;
        memory.need(measured::need(&bytes), || format!("{}: reading it", printable(&path)))?;
        let data =
            measured::decode(&bytes, &path).map_err(|e| two_lines(ErrorCode::Measured, &e.to_string()))?;
        let data = Arc::new(data);
        self.measured.insert(path, data.clone());
        Ok(data)
    }

    fn grid(&mut self, uri: &str, from: FileId) -> Result<Arc<GridData>, SceneError> {
        let (file, part) = grid::split_name(uri);
        let file = self.resolve(file, from)?;
        let path = part.map_or(file.clone(), |part| format!("{file}#{part}"));
        if let Some(grid) = self.grids.get(&path) {
            return Ok(grid.clone());
        }
        let bytes = self.assets.read(&file, MAX_GRID).map_err(|e| e.to_scene_error())?;
        self.hash.add(b'v', &bytes);
        let memory = &self.options.limits.memory;
        memory.need(2 * bytes.len() as u64, || format!("{}: reading it", printable(&path)))?;
        let data = grid::decode_within(&bytes, &path, memory.left())
            .map_err(|e| two_lines(ErrorCode::Volume, &e.to_string()))?;
        let grid = Arc::new(data);
        self.grids.insert(path, grid.clone());
        Ok(grid)
    }

    fn font(&mut self, uri: &str, from: FileId) -> Result<Arc<dyn Font>, SceneError> {
        let path = self.resolve(uri, from)?;
        if let Some(font) = self.fonts.get(&path) {
            return Ok(font.clone());
        }
        let bytes = self.assets.read(&path, MAX_FONT).map_err(|e| e.to_scene_error())?;
        self.hash.add(b't', &bytes);
        let memory = &self.options.limits.memory;
        memory.need(bytes.len() as u64, || format!("{}: reading it", printable(&path)))?;
        let font = font::decode(bytes, &path).map_err(|e| two_lines(ErrorCode::Font, &e.to_string()))?;
        self.fonts.insert(path, font.clone());
        Ok(font)
    }

    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        let path = self.resolve(&model.file, from)?;
        let options = import_options(&self.options, Some(model));
        options.limits.memory.begin(format!("{}: reading it", printable(&path)));
        let key = (path.clone(), format!("{options:?}"));
        if let Some(scene) = self.models.get(&key) {
            return Ok(scene.clone());
        }
        if SceneFormat::of_path(Path::new(&path)).is_some_and(SceneFormat::is_whole) {
            let (scene, hashes) = import_whole(&path, self.assets, &self.options)?;
            let scene = Arc::new(scene);
            self.add_hashes(&hashes);
            self.models.insert(key, scene.clone());
            return Ok(scene);
        }
        let bytes = self.read(b'g', &path)?;
        let assets = HashedAssets { inner: self.assets, read: Mutex::new(Vec::new()) };
        let again = self.frame.map(|frame| (frame, bytes.clone()));
        let mut scene = import(bytes, &path, &assets, &options)?;
        if let Some((frame, bytes)) = again.filter(|_| scene.is_animated()) {
            let time = options.time + frame;
            scene.move_to(&import(bytes, &path, self.assets, &ImportOptions { time, ..options })?);
        }
        let scene = Arc::new(scene);
        self.add_hashes(&assets.read.into_inner().unwrap_or_else(|e| e.into_inner()));
        self.models.insert(key, scene.clone());
        Ok(scene)
    }
}

/// An asset source that hashes each file as it is read.
struct HashedAssets<'a> {
    inner: &'a dyn AssetSource,
    /// Names and hashes in reading order.
    read: Mutex<Vec<String>>,
}

impl AssetSource for HashedAssets<'_> {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        let (bytes, mark) = self.read_ahead(uri, limit)?;
        self.used(mark);
        Ok(bytes)
    }

    fn read_ahead(&self, uri: &str, limit: u64) -> Result<(Vec<u8>, String), AssetError> {
        let bytes = self.inner.read(uri, limit)?;
        let mut hash = SceneHash::new();
        hash.add(b'f', &bytes);
        Ok((bytes, format!("{uri}:{}", hash.hex())))
    }

    fn used(&self, mark: String) {
        self.read.lock().unwrap_or_else(|e| e.into_inner()).push(mark);
    }

    fn open<'a>(&'a self, uri: &str, limit: u64) -> Result<Box<dyn Read + 'a>, AssetError> {
        let inner = self.inner.open(uri, limit)?;
        Ok(Box::new(HashedReader {
            inner,
            uri: uri.to_owned(),
            hash: SceneHash::new(),
            block: Vec::new(),
            names: &self.read,
        }))
    }

    fn describe(&self, uri: &str) -> String {
        self.inner.describe(uri)
    }

    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        self.inner.resolve(from, uri)
    }
}

/// Bytes hashed at a time. Blocks of a fixed size make the hash independent of the sizes of the reads.
const HASH_BLOCK: usize = 1 << 16;

/// A file that is hashed as it is read.
struct HashedReader<'a> {
    inner: Box<dyn Read + 'a>,
    uri: String,
    hash: SceneHash,
    block: Vec<u8>,
    names: &'a Mutex<Vec<String>>,
}

impl Read for HashedReader<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.inner.read(into)?;
        let mut new = into.get(..count).unwrap_or_default();
        while !new.is_empty() {
            let (now, later) = new.split_at(new.len().min(HASH_BLOCK - self.block.len()));
            self.block.extend_from_slice(now);
            new = later;
            if self.block.len() == HASH_BLOCK {
                self.hash.add(b'f', &self.block);
                self.block.clear();
            }
        }
        Ok(count)
    }
}

impl Drop for HashedReader<'_> {
    fn drop(&mut self) {
        self.hash.add(b'f', &self.block);
        let mut names = self.names.lock().unwrap_or_else(|e| e.into_inner());
        names.push(format!("{}:{}", self.uri, self.hash.hex()));
    }
}
