//! Text scenes to [`SceneDesc`]s: files, includes, overrides, the files they name, and errors with their place.
//!
//! ```text
//! scene.toml ── text ──> Value ── include ── overrides ──> Value ── turner::description::read_scene ──> SceneDesc
//! scene.pbrt, scene.xml ── import ──> SceneDesc ── overrides: SceneDesc::edit ──> SceneDesc
//! model.glb, .obj, .ply, .stl ── import, on a stage ──> SceneDesc ── overrides: SceneDesc::edit ──> SceneDesc
//! ```
//!
//! `include = ["parts.toml"]` at the top of a file reads other files first. Tables are merged key by key and the
//! including file wins; the lists `[[object]]`, `[[light]]` and `[[group.NAME.object]]` are appended, included ones
//! first. Paths are relative to the file they stand in and stay inside the folder of the scene. A file that is
//! reached on several ways is read once, where it comes first.

mod error;
mod files;
mod format;
mod hash;
mod include;
pub(crate) mod model;
mod nesting;
mod overrides;
mod sources;
mod text;

pub use error::LoadError;
pub(crate) use error::two_lines;
pub use files::SceneFiles;
pub use format::SceneFormat;
pub(crate) use format::nearest_mesh_extension;
pub use overrides::Override;
pub use sources::{Location, SourceFile, Sources};
pub use text::parse;

use std::io::Read;
use std::path::{Path, PathBuf};

use turner::description::{SceneDesc, read_scene};
use turner::schema::{ErrorCode, Limits, SceneError};

use crate::assets::{AssetError, AssetSource, FolderAssets, printable};
use crate::image::KeptPictures;

/// Most bytes of one text: 1 GiB.
pub const MAX_TEXT: u64 = 1 << 30;

/// Deepest nesting of tables and arrays.
pub const MAX_DEPTH: usize = 64;

/// How to load a scene.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Longest side that pictures may have; larger ones are halved until they fit.
    pub max_texture_size: Option<u32>,
    /// What is asked of all models in it.
    pub models: ModelOverrides,
    /// Threads for decoding; 0 takes all there are. The scene is the same for any number.
    pub threads: usize,
    /// Values for the `$names` of Mitsuba scenes.
    pub defines: Vec<(String, String)>,
    /// The type of integrator that takes the place of the scene's. Keys that it does not know are dropped.
    pub integrator: Option<String>,
    /// Values that replace those of the files, applied in order.
    pub overrides: Vec<Override>,
    /// Whether the scene may name files outside its folder. For scenes that the user trusts.
    pub allow_outside: bool,
    /// Folders beside its own from which the scene may read.
    pub allow_paths: Vec<PathBuf>,
    /// What the scene may take.
    pub limits: Limits,
    /// Where pictures are kept as their files have them, for who writes them again.
    pub kept_pictures: Option<KeptPictures>,
}

/// What takes the place of keys of every model in a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelOverrides {
    /// Seconds into the animation.
    pub time: Option<f64>,
    /// Which animation.
    pub animation: Option<String>,
    /// Which variant of materials.
    pub variant: Option<String>,
}

/// A scene that was read.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub desc: SceneDesc,
    /// The texts, to find the place of later errors.
    pub sources: Sources,
    /// 32 hexadecimal digits over all texts, overrides and bytes of pictures and meshes, in the order of reading.
    pub hash: String,
}

/// Reads a scene file, or standard input for `-`. The files it names are relative to its folder (the current one
/// for standard input).
pub fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let bare = |error| LoadError { error, sources: Sources::default() };
    if path == Path::new("-") {
        let assets = folder(Path::new(""), options).map_err(bare)?;
        let mut bytes = Vec::new();
        std::io::stdin().lock().take(MAX_TEXT + 1).read_to_end(&mut bytes).map_err(|e| {
            bare(SceneError::new(ErrorCode::File, format!("standard input cannot be read: {e}")))
        })?;
        let text = text::utf8(bytes, "standard input").map_err(bare)?;
        return load_text(text, "-", &assets, options);
    }
    let format = format::check_scene(path).map_err(bare)?;
    let assets = folder(path.parent().unwrap_or(Path::new("")), options).map_err(bare)?;
    let name = path.to_string_lossy();
    let Some(file) = path.file_name().and_then(|n| n.to_str()) else {
        let message = format!("{}: expected the name of a file in UTF-8", printable(&name));
        return Err(bare(SceneError::new(ErrorCode::File, message).help("rename it or name a file")));
    };
    // The user named this file: a link may lead anywhere. Its clone shares the budget.
    let named = assets.clone().allow_outside(true);
    if format.is_whole() {
        return model::load_whole(&name, file, (&named, &assets), options);
    }
    if format.is_model() {
        let bytes = named.read(file, files::MAX_FILE).map_err(|e| bare(e.to_scene_error()))?;
        return model::load(bytes, format, &name, file, &assets, options);
    }
    let bytes = named.read(file, MAX_TEXT).map_err(|e| bare(e.to_scene_error()))?;
    let text = text::utf8(bytes, &name).map_err(bare)?;
    load_named(text, &name, file, &assets, options)
}

/// The hash of a scene to which something was added that its files do not name.
pub fn hash_with(hash: &str, bytes: &[u8]) -> String {
    let mut sum = hash::SceneHash::new();
    sum.add(b'h', hash.as_bytes());
    sum.add(b'a', bytes);
    sum.hex()
}

/// Reads a scene from text. `name` is for messages and, as a path relative to the root of `assets`, what the paths
/// in it are relative to.
pub fn load_text(
    text: String,
    name: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    load_named(text, name, name, assets, options)
}

fn folder(path: &Path, options: &LoadOptions) -> Result<FolderAssets, SceneError> {
    let assets = FolderAssets::new(path).map_err(|e| e.to_scene_error())?;
    open_to(assets, options).map_err(|e| e.to_scene_error())
}

/// The assets of a folder with what `options` allow and limit.
pub fn open_to(assets: FolderAssets, options: &LoadOptions) -> Result<FolderAssets, AssetError> {
    let assets = assets.allow_outside(options.allow_outside).with_limits(options.limits.clone());
    assets.allow_paths(&options.allow_paths)
}

fn load_named(
    text: String,
    name: &str,
    uri: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let mut sources = Sources::default();
    match read(text, (name, uri), assets, options, &mut sources) {
        Ok((desc, hash)) => Ok(Loaded { desc, sources, hash }),
        Err(error) => Err(LoadError { error, sources }),
    }
}

fn read(
    text: String,
    (name, uri): (&str, &str),
    assets: &dyn AssetSource,
    options: &LoadOptions,
    sources: &mut Sources,
) -> Result<(SceneDesc, String), SceneError> {
    let folder = name.strip_suffix(uri).unwrap_or_default().to_owned();
    let source = SourceFile { name: printable(name), uri: uri.to_owned(), text, is_argument: false };
    let mut root = include::read(source, &folder, assets, sources, &options.limits)?;
    let mut hash = hash::SceneHash::new();
    sources.files().iter().for_each(|file| hash.add(b't', file.text.as_bytes()));
    hash_defines(options, &mut hash);
    let edits = overrides::edits(options, uri, sources, &mut hash)?;
    overrides::apply(edits, options.integrator.is_some(), &mut root)?;
    let mut files = SceneFiles::with_hash(assets, sources, hash);
    files.options = options.clone();
    let mut desc = read_scene(&root, &mut files)?;
    let (warnings, hash) = files.finish();
    desc.warnings.extend(warnings);
    Ok((desc, hash.hex()))
}

fn hash_defines(options: &LoadOptions, hash: &mut hash::SceneHash) {
    for (name, value) in &options.defines {
        hash.add(b'd', name.as_bytes());
        hash.add(b'd', value.as_bytes());
    }
}
