//! Loads scenes: files, includes, overrides and imported formats become a [`SceneDesc`]; errors have source
//! positions.
//!
//! ```text
//! scene.toml ── parse ──► Value ── include ──► Value ── overrides ──► Value ── read_scene ──► SceneDesc
//! scene.pbrt, scene.xml ── import ─────────────────────► SceneDesc ── overrides (SceneDesc::edit) ──► SceneDesc
//! model.glb, .obj, .ply, .stl ── import into the default studio ─► SceneDesc ── overrides (edit) ──► SceneDesc
//! ```
//!
//! A TOML scene is parsed to a tree of values in which each key and value has its span (`text`); `nesting`
//! bounds the depth before that. `include = ["parts.toml"]` at the top of a file reads other files first
//! (`include`). Tables are merged key by key and the including file wins; the lists `[[object]]`,
//! `[[light]]`, `[[view]]` and `[[group.NAME.object]]` are appended, included entries first. A file that is
//! included more than once is read once, at its first include.
//!
//! Overrides (`-D key=value`, `overrides`) replace values of the merged tree by key path. Then
//! `turner::description::read_scene` reads the tree and asks [`SceneFiles`] for the images, meshes and models
//! that it names. Each file is read once and enters the hash of the scene.
//!
//! A model is one `[[object]]` in the default studio. A scene of another renderer keeps its own camera, film
//! and integrator (`model`). Overrides edit both by the same key paths.
//!
//! Paths are relative to the file that contains them and must stay inside the folder of the scene.

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
use turner::schema::value::{Data, Value};
use turner::schema::{ErrorCode, Limits, SceneError};

use crate::assets::{AssetError, AssetSource, FolderAssets, printable};
use crate::image::KeptPictures;

/// Most bytes of one text: 1 GiB.
pub const MAX_TEXT: u64 = 1 << 30;

/// Deepest nesting of tables and lists.
pub const MAX_DEPTH: usize = 64;

/// Options of [`load`].
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Longest side of a texture in pixels; larger images are halved until they fit.
    pub max_texture_size: Option<u32>,
    /// Import settings that apply to all models of the scene.
    pub models: ModelOverrides,
    /// Threads for decoding; 0 uses all cores. The scene does not depend on it.
    pub threads: usize,
    /// Values for the `$name` parameters of Mitsuba scenes.
    pub defines: Vec<(String, String)>,
    /// An integrator type that replaces the scene's. Keys that it does not have are dropped.
    pub integrator: Option<String>,
    /// Overrides of single keys, applied in order.
    pub overrides: Vec<Override>,
    /// Whether the scene may read files outside its folder. Only for trusted scenes.
    pub allow_outside: bool,
    /// Further folders that the scene may read from.
    pub allow_paths: Vec<PathBuf>,
    /// Limits of memory and size.
    pub limits: Limits,
    /// Where the bytes of image files are kept, for programs that write them again.
    pub kept_pictures: Option<KeptPictures>,
}

/// Import settings that replace those of every model in a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelOverrides {
    /// Time in the animation, seconds.
    pub time: Option<f64>,
    /// Length of a frame in seconds, for motion blur; 1/24 by default.
    pub frame: Option<f64>,
    /// The animation to apply.
    pub animation: Option<String>,
    /// The material variant.
    pub variant: Option<String>,
}

/// A loaded scene.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub desc: SceneDesc,
    /// The texts, to locate later errors.
    pub sources: Sources,
    /// Hash over all texts, overrides and file contents in reading order: 32 hexadecimal digits.
    pub hash: String,
    /// The same without overrides of `film.samples` and `film.crop`: equal for all parts of a picture.
    pub shared_hash: String,
}

/// Loads a scene file, or standard input for `-`. Paths in it are relative to its folder (for standard input:
/// the current folder).
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
    // The user named this file: a link may lead anywhere. The clone shares the budget of bytes.
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

/// Loads a scene or a model that is not on disk. `name` is its path from the root of `assets`; its extension says the
/// format.
pub fn load_from(name: &str, assets: &dyn AssetSource, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let bare = |error| LoadError { error, sources: Sources::default() };
    let format = format::check_scene(Path::new(name)).map_err(bare)?;
    if format.is_whole() {
        return model::load_whole(name, name, (assets, assets), options);
    }
    let read = |limit| assets.read(name, limit).map_err(|e| bare(e.to_scene_error()));
    if format.is_model() {
        return model::load(read(files::MAX_FILE)?, format, name, name, assets, options);
    }
    let text = text::utf8(read(MAX_TEXT)?, name).map_err(bare)?;
    load_named(text, name, name, assets, options)
}

/// Extends a scene's hash by data that its files do not contain.
pub fn hash_with(hash: &str, bytes: &[u8]) -> String {
    let mut sum = hash::SceneHash::new();
    sum.add(b'h', hash.as_bytes());
    sum.add(b'a', bytes);
    sum.hex()
}

/// Loads a scene from text. `name` appears in messages. Paths in the text are relative to `name`, which is
/// itself a path from the root of `assets`.
pub fn load_text(
    text: String,
    name: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    load_named(text, name, name, assets, options)
}

pub(crate) fn folder(path: &Path, options: &LoadOptions) -> Result<FolderAssets, SceneError> {
    let assets = FolderAssets::new(path).map_err(|e| e.to_scene_error())?;
    open_to(assets, options).map_err(|e| e.to_scene_error())
}

/// Applies the access rules and limits of `options` to the assets of a folder.
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
        Ok((desc, (hash, shared_hash))) => Ok(Loaded { desc, sources, hash, shared_hash }),
        Err(error) => Err(LoadError { error, sources }),
    }
}

fn read(
    text: String,
    (name, uri): (&str, &str),
    assets: &dyn AssetSource,
    options: &LoadOptions,
    sources: &mut Sources,
) -> Result<(SceneDesc, (String, String)), SceneError> {
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
    files.frame = blurs_motion(&root).then(|| options.models.frame.unwrap_or(FRAME));
    let mut desc = read_scene(&root, &mut files)?;
    desc.animate(options.models.time.unwrap_or(0.0), files.frame, &mut files)?;
    let (warnings, hash) = files.finish();
    desc.warnings.extend(warnings);
    Ok((desc, overrides::hashes(hash, options)))
}

/// Length of a frame in seconds.
const FRAME: f64 = 1.0 / 24.0;

/// Whether a scene's film blurs the motion of animations, before it is read.
fn blurs_motion(root: &Value) -> bool {
    let Data::Table(top) = &root.data else { return false };
    let Some(Value { data: Data::Table(film), .. }) = top.get("film") else { return false };
    film.get("motion_blur").is_some_and(|value| value.data == Data::Bool(true))
}

/// The tree of a scene's text with its includes, before anything that it names is read.
pub(crate) fn read_tree(
    text: String,
    name: &str,
    assets: &dyn AssetSource,
    limits: &Limits,
    sources: &mut Sources,
) -> Result<Value, SceneError> {
    let source = SourceFile { name: printable(name), uri: name.to_owned(), text, is_argument: false };
    include::read(source, "", assets, sources, limits)
}

fn hash_defines(options: &LoadOptions, hash: &mut hash::SceneHash) {
    for (name, value) in &options.defines {
        hash.add(b'd', name.as_bytes());
        hash.add(b'd', value.as_bytes());
    }
}
