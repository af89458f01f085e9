//! Loads scenes and models from files, in one call.

use std::path::Path;

use turner::description::SceneDesc;

use crate::scene::{LoadError, LoadOptions, Loaded};

/// Reads a scene (.toml, .pbrt, Mitsuba's .xml) or a model (.glb, .gltf, .usdz, .usd, .usda, .usdc,
/// .obj, .ply, .stl). A model gets the default
/// studio: camera, lights and floor. Files that it names must lie in its folder and have at most 4 GiB each. The
/// scene's `warnings` say what was ignored, approximated or is doubtful.
///
/// Errors are displayed as `error[CODE]: FILE:LINE:COLUMN: problem`, with the remedy on a second line.
pub fn load(path: impl AsRef<Path>) -> Result<SceneDesc, LoadError> {
    load_with(path, &LoadOptions::default()).map(|loaded| loaded.desc)
}

/// Like [`load`], with overrides of the file's values, additional folders to read from and memory limits. The result
/// also holds the source texts, so that later errors can show an excerpt.
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
