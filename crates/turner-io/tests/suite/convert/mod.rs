//! Scenes written as TOML and as glTF are the same when loaded again.

mod every_asset;
mod every_kind;
mod glb;
mod names;

use std::path::Path;

use turner::description::SceneDesc;
use turner_io::convert::{ConvertOptions, Converted, to_toml};
use turner_io::image::KeptPictures;
use turner_io::scene::{LoadOptions, load};

/// Loads a scene as the command `turner convert` does.
fn loaded(path: &Path) -> Result<(SceneDesc, ConvertOptions), String> {
    let pictures = KeptPictures::default();
    let options = LoadOptions { kept_pictures: Some(pictures.clone()), ..LoadOptions::default() };
    let loaded = load(path, &options).map_err(|e| e.error.message)?;
    let source = path.file_name().unwrap().to_string_lossy().into_owned();
    Ok((loaded.desc, ConvertOptions { source, pictures, ..ConvertOptions::default() }))
}

/// Writes a scene, loads the result and compares; returns the text.
fn round_trip(desc: &SceneDesc, options: &ConvertOptions, what: &str) -> (String, Converted) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.toml");
    let converted = to_toml(desc, &out, options).unwrap_or_else(|e| panic!("{what}: {e}"));
    let text = std::fs::read_to_string(&out).unwrap();
    let again = load(&out, &LoadOptions::default()).unwrap_or_else(|e| panic!("{what}: {}\n{text}", e.error));
    if let Err(difference) = desc.same_scene(&again.desc) {
        let difference: String = difference.chars().take(4000).collect();
        let text: String = text.chars().take(4000).collect();
        panic!("{what}: {difference}\n{text}");
    }
    for file in &converted.files {
        assert!(file.path.starts_with(folder.path()), "{what}: {}", file.path.display());
    }
    (text, converted)
}
