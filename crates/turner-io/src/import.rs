//! Import of other programs' formats: the options and entry points that all importers share.

use std::path::Path;

use turner::description::SceneDesc;
use turner::schema::{ErrorCode, Limits, SceneError};

use crate::assets::{AssetSource, printable};
use crate::image::KeptPictures;
use crate::scene::SceneFormat;
use crate::{mesh, mitsuba, pbrt};

/// How to import another program's file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// Time of the animation, in seconds.
    pub time: f64,
    /// Which animation, by name or index; `None` is the first.
    pub animation: Option<String>,
    /// Which material variant of the file, by name or index.
    pub variant: Option<String>,
    /// Which scene of the file, by name or index; `None` is the file's default.
    pub scene: Option<String>,
    /// Names of the nodes (or groups) to import, with all their children; empty imports all.
    pub nodes: Vec<String>,
    /// Values for the `$name` parameters of a Mitsuba scene. They override the file's `default` values.
    pub defines: Vec<(String, String)>,
    /// Images with a longer side than this are halved until they fit. `None`: no limit.
    pub max_texture_size: Option<u32>,
    /// Threads for decoding; 0 uses all. The result is the same for any number.
    pub threads: usize,
    /// Limits of memory and size.
    pub limits: Limits,
    /// Where to keep images in their encoded form.
    pub kept_pictures: Option<KeptPictures>,
}

impl Default for ImportOptions {
    fn default() -> ImportOptions {
        ImportOptions {
            time: 0.0,
            animation: None,
            variant: None,
            scene: None,
            nodes: Vec::new(),
            defines: Vec::new(),
            max_texture_size: None,
            threads: 0,
            limits: Limits::default(),
            kept_pictures: None,
        }
    }
}

impl ImportOptions {
    /// The store for encoded images, if images are kept and not downscaled.
    pub(crate) fn keeps_pictures(&self) -> Option<&KeptPictures> {
        self.kept_pictures.as_ref().filter(|_| self.max_texture_size.is_none())
    }
}

/// Reads another program's file as a scene with exactly what the file contains: no camera, light or floor is added.
/// The format is recognised by the first bytes or the extension. `uri` is the file's name relative to the root of
/// `assets`.
pub fn import(
    bytes: Vec<u8>,
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let format = if bytes.starts_with(b"glTF") {
        SceneFormat::Gltf
    } else if crate::usd::is_usd(&bytes) {
        SceneFormat::Usd
    } else if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        SceneFormat::Ply
    } else {
        SceneFormat::of_path(Path::new(uri)).filter(|f| f.is_model()).ok_or_else(|| {
            let message = format!("{}: does not have the extension of a model", printable(uri));
            SceneError::new(ErrorCode::File, message)
                .help(format!("models are read from {}", SceneFormat::model_listing()))
        })?
    };
    match format {
        SceneFormat::Gltf => crate::gltf::import(bytes, uri, assets, options),
        SceneFormat::Usd => crate::usd::import(bytes, uri, assets, options),
        SceneFormat::Obj => mesh::import_obj(bytes, uri, assets, options),
        SceneFormat::Ply => mesh::import_ply(bytes, uri, assets, options),
        SceneFormat::Stl => mesh::import_stl(bytes, uri, assets, options),
        SceneFormat::Pbrt => pbrt::import_from(Box::new(std::io::Cursor::new(bytes)), uri, assets, options),
        SceneFormat::Mitsuba => mitsuba::import_from(bytes, uri, assets, options),
        SceneFormat::Toml => {
            let message = format!("{}: is a scene, not a model", printable(&assets.describe(uri)));
            Err(SceneError::new(ErrorCode::File, message).help("include a scene with: include = [\"FILE\"]"))
        }
    }
}

/// Like [`import`], from a file of `assets`. Formats that allow it are streamed: a text file of gigabytes takes no
/// more memory than the resulting scene.
pub fn import_file(
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    match SceneFormat::of_path(Path::new(uri)) {
        Some(SceneFormat::Pbrt) => return pbrt::import(uri, assets, options),
        Some(SceneFormat::Mitsuba) => return mitsuba::import(uri, assets, options),
        Some(
            SceneFormat::Toml
            | SceneFormat::Gltf
            | SceneFormat::Usd
            | SceneFormat::Obj
            | SceneFormat::Ply
            | SceneFormat::Stl,
        )
        | None => {}
    }
    let bytes = assets.read(uri, MAX_FILE).map_err(|e| e.to_scene_error())?;
    import(bytes, uri, assets, options)
}

/// Largest file that is read into memory at once, in bytes.
const MAX_FILE: u64 = 4 << 30;
