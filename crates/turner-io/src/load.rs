//! Scenes and models from files, in one call.

use std::path::Path;

use turner::description::SceneDesc;

use crate::scene::{LoadError, LoadOptions, Loaded};

/// Reads a scene (.toml, .pbrt, Mitsuba's .xml) or a model (.glb, .gltf, .obj, .ply, .stl); a model stands on a stage that lights it. Files that it names must
/// lie in its folder; each has at most 4 GiB. What was ignored or is doubtful is in the scene's `warnings`.
///
/// Errors are displayed as `error[CODE]: FILE:LINE:COLUMN: what is wrong`, with a remedy in a second line.
pub fn load(path: impl AsRef<Path>) -> Result<SceneDesc, LoadError> {
    load_with(path, &LoadOptions::default()).map(|loaded| loaded.desc)
}

/// As [`load`], with values that replace those of the file, more folders to read from and limits of memory. The texts that the scene was read from come with it,
/// so that later errors can be shown at their places.
pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, LoadError> {
    crate::scene::load(path.as_ref(), options)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_readme_has_the_example_that_is_run() {
        let readme = include_str!("../../../README.md");
        let block = format!("```rust\n{}```\n", include_str!("../tests/data/readme_example.rs"));
        assert!(readme.contains(&block));
    }
}
