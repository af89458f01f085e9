//! One picture of a scene: for programs that want pixels and no session.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde_json::{Value as Json, json};
use turner::schema::{Limits, PrepareOptions};
use turner::{PassOptions, Picture, Renderer};
use turner_io::assets::MemoryAssets;
use turner_io::image::{ImageFormat, Transfer};
use turner_io::scene::{LoadOptions, Override, load_from};
use turner_io::{SaveOptions, to_bytes};

use crate::session::{CallError, Reply};

/// What is wanted.
#[derive(Clone, Debug, Default)]
pub struct PictureRequest {
    /// The scene or model among the files.
    pub main: String,
    /// Values of the scene by key path, as in `-D film.samples=64`.
    pub overrides: Vec<(String, String)>,
    /// Threads; 0 uses all.
    pub threads: usize,
    /// Limits of memory and size.
    pub limits: Limits,
}

/// Renders a picture with all its samples.
///
/// Errors: those of reading and preparing the scene.
pub fn picture(files: Vec<(String, Vec<u8>)>, wanted: &PictureRequest) -> Result<Picture, CallError> {
    let overrides = wanted.overrides.iter();
    let overrides = overrides.map(|(path, value)| Override { path: path.clone(), value: value.clone() });
    let options = LoadOptions {
        threads: wanted.threads,
        overrides: overrides.collect(),
        limits: wanted.limits.clone(),
        ..LoadOptions::default()
    };
    let assets = Arc::new(MemoryAssets { files: files.into_iter().collect() });
    let loaded = load_from(&wanted.main, &*assets, &options)?;
    let prepare =
        PrepareOptions { threads: wanted.threads, limits: wanted.limits.clone(), ..Default::default() };
    let bad = |error| CallError::of_scene(&error, &loaded.sources);
    let prepared = loaded.desc.prepare(&prepare).map_err(bad)?;
    let mut renderer = Renderer::new(prepared).map_err(bad)?;
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: wanted.threads, cancel: &never, progress: None };
    renderer.pass(u32::MAX, &options).map_err(bad)?;
    Ok(renderer.develop_with(wanted.threads))
}

/// The call `picture`: `main`, `overrides` as pairs of texts, `format` of the bytes: `rgba` or that of a file.
pub(crate) fn of_call(
    limits: Limits,
    threads: usize,
    args: &Json,
    files: Vec<(String, Vec<u8>)>,
) -> Result<Reply, CallError> {
    let text = |json: &Json| json.as_str().map(str::to_owned);
    let main = args.get("main").and_then(text);
    let main = main.or_else(|| files.first().map(|(name, _)| name.clone())).unwrap_or_default();
    let mut overrides = Vec::new();
    for pair in args.get("overrides").and_then(Json::as_array).into_iter().flatten() {
        let pair = pair.get(0).and_then(text).zip(pair.get(1).and_then(text));
        overrides.push(
            pair.ok_or_else(|| CallError::new("an override is a pair of a key path and a value, as text"))?,
        );
    }
    let format = args.get("format").and_then(Json::as_str).unwrap_or("rgba");
    let picture = picture(files, &PictureRequest { main, overrides, threads, limits })?;
    let (width, height, missing) = (picture.width, picture.height, picture.missing);
    let bytes = match format {
        "rgba" => picture.display.as_flattened().to_vec(),
        "linear" => picture.linear.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect(),
        name => {
            let format = ImageFormat::of_path(std::path::Path::new(&format!("picture.{name}")))
                .map_err(|e| CallError::new(e.to_string()))?;
            let options = SaveOptions { threads, transfer: Transfer::Srgb, ..SaveOptions::default() };
            to_bytes(&picture, format, &options).map_err(|e| CallError::new(e.to_string()))?
        }
    };
    Ok(Reply { json: json!({ "width": width, "height": height, "non_finite": missing }), bytes })
}
