//! Converts every scene and model of the repository.

use std::path::{Path, PathBuf};

use super::{loaded, round_trip};

fn files(folder: &Path, extensions: &[&str], out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, extensions, out);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e == *x)) {
            out.push(path);
        }
    }
}

/// Converts all files of a folder; returns how many could be loaded.
fn all(folder: &str, extensions: &[&str]) -> usize {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let mut found = Vec::new();
    files(&root, extensions, &mut found);
    let mut converted = 0;
    for path in found {
        // Some files are damaged on purpose; some refer to files outside their folder.
        let Ok((desc, options)) = loaded(&path) else { continue };
        round_trip(&desc, &options, &path.display().to_string());
        converted += 1;
    }
    converted
}

#[test]
fn scenes_come_back_the_same() {
    let count = all("scenes", &["toml"]);
    assert!(count >= 50, "{count}");
}

#[test]
fn models_come_back_the_same() {
    let count = all("crates/turner-io/tests", &["gltf", "glb", "obj", "ply", "stl", "pbrt"]);
    assert!(count >= 30, "{count}");
}
