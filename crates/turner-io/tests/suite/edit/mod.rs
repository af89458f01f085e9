//! Editing descriptions as a window program does: values by key path, parts, copy and paste, saving.

mod clipboard;
mod hidden;
mod parts;
mod rename;
mod save;
mod save_random;
mod values;

use std::path::{Path, PathBuf};

use turner::description::SceneDesc;
use turner_io::assets::FolderAssets;
use turner_io::scene::{LoadOptions, SceneFiles, Sources, load_text};

/// A scene from text; files are those of the tests.
fn scene(text: &str) -> SceneDesc {
    let assets = FolderAssets::new(assets_folder()).unwrap();
    let loaded = load_text(text.to_owned(), "scene.toml", &assets, &LoadOptions::default());
    loaded.unwrap_or_else(|e| panic!("{e}\n{text}")).desc
}

fn assets_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/gltf")
}

/// Calls `with` with the files of the tests.
fn with_files<T>(with: impl FnOnce(&mut SceneFiles<'_>) -> T) -> T {
    with_files_in(&assets_folder(), with)
}

/// Calls `with` with the files of a folder.
fn with_files_in<T>(folder: &Path, with: impl FnOnce(&mut SceneFiles<'_>) -> T) -> T {
    let assets = FolderAssets::new(folder).unwrap();
    let sources = Sources::default();
    with(&mut SceneFiles::new(&assets, &sources))
}

fn scenes_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// All TOML scenes of the repository whose files are there.
fn all_scenes() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![scenes_folder()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                found.push(path);
            }
        }
    }
    found.retain(|path| turner_io::load(path).is_ok());
    found.sort();
    assert!(found.len() > 30);
    found
}
