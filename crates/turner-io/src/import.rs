//! What all importers of foreign formats have in common.

use std::path::Path;

use turner::description::SceneDesc;
use turner::schema::{ErrorCode, Limits, SceneError};

use crate::assets::{AssetSource, printable};
use crate::image::KeptPictures;
use crate::scene::SceneFormat;
use crate::{mesh, mitsuba, pbrt};

/// How to import a file of another program.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// Seconds into the animation.
    pub time: f64,
    /// Which animation: its name or number; the first unless given.
    pub animation: Option<String>,
    /// Which of the file's variants of materials: its name or number.
    pub variant: Option<String>,
    /// Which of the file's scenes: its name or number; the file's own choice unless given.
    pub scene: Option<String>,
    /// Names of nodes (or groups) that are wanted, with all that hangs on them; all if empty.
    pub nodes: Vec<String>,
    /// Values for the `$names` of a Mitsuba scene, which go before those that the file gives by `default`.
    pub defines: Vec<(String, String)>,
    /// Pictures with a longer side are halved until they fit.
    pub max_texture_size: Option<u32>,
    /// Threads for decoding; 0 takes all there are. The result is the same for any number.
    pub threads: usize,
    /// What the scene may take.
    pub limits: Limits,
    /// Where pictures are kept as their files have them.
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
    /// Where pictures are kept, if they are and stay what their files hold.
    pub(crate) fn keeps_pictures(&self) -> Option<&KeptPictures> {
        self.kept_pictures.as_ref().filter(|_| self.max_texture_size.is_none())
    }
}

/// Reads a file of another program as a scene of its own: without camera, light or floor of ours, with what it has. Its format is known by its first
/// bytes or its extension. `uri` is its name relative to the root of `assets`.
pub fn import(
    bytes: Vec<u8>,
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let format = if bytes.starts_with(b"glTF") {
        SceneFormat::Gltf
    } else if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        SceneFormat::Ply
    } else {
        SceneFormat::of_path(Path::new(uri)).filter(|f| f.is_model()).ok_or_else(|| {
            let message = format!("{}: is no model by its extension", printable(uri));
            SceneError::new(ErrorCode::File, message)
                .help(format!("models are read from {}", SceneFormat::model_listing()))
        })?
    };
    match format {
        SceneFormat::Gltf => crate::gltf::import(bytes, uri, assets, options),
        SceneFormat::Obj => mesh::import_obj(bytes, uri, assets, options),
        SceneFormat::Ply => mesh::import_ply(bytes, uri, assets, options),
        SceneFormat::Stl => mesh::import_stl(bytes, uri, assets, options),
        SceneFormat::Pbrt => pbrt::import_from(Box::new(std::io::Cursor::new(bytes)), uri, assets, options),
        SceneFormat::Mitsuba => mitsuba::import_from(bytes, uri, assets, options),
        SceneFormat::Toml => {
            let message = format!("{}: is a scene, no model", printable(&assets.describe(uri)));
            Err(SceneError::new(ErrorCode::File, message).help("scenes are included: include = [\"FILE\"]"))
        }
    }
}

/// As [`import`], from a file of `assets` that is read bit by bit where its format allows it: a text of gigabytes takes no more memory than the scene it becomes.
pub fn import_file(
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    match SceneFormat::of_path(Path::new(uri)) {
        Some(SceneFormat::Pbrt) => return pbrt::import(uri, assets, options),
        Some(SceneFormat::Mitsuba) => return mitsuba::import(uri, assets, options),
        Some(
            SceneFormat::Toml | SceneFormat::Gltf | SceneFormat::Obj | SceneFormat::Ply | SceneFormat::Stl,
        )
        | None => {}
    }
    let bytes = assets.read(uri, MAX_FILE).map_err(|e| e.to_scene_error())?;
    import(bytes, uri, assets, options)
}

/// Most bytes of a file that is read whole.
const MAX_FILE: u64 = 4 << 30;
