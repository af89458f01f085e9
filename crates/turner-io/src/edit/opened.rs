//! A scene file as it was opened.

use std::path::{Path, PathBuf};

use turner::description::SceneDesc;

use crate::scene::{LoadError, LoadOptions, Loaded, SceneFormat, Sources, load};

/// What was read: the file, its text and the scene in it. Saving compares with it.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The file.
    pub path: PathBuf,
    /// The scene as it was loaded.
    pub desc: SceneDesc,
    /// The texts: of the file, and of the files that it includes. Empty for a model.
    pub sources: Sources,
    /// The options that it was loaded with.
    pub options: LoadOptions,
}

impl Opened {
    /// Loads a scene or a model.
    ///
    /// Errors: those of [`crate::load`].
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Opened, LoadError> {
        Ok(Opened::of(path, options, load(path, options)?))
    }

    /// A scene that was loaded already, with the same path and options.
    pub fn of(path: &Path, options: &LoadOptions, loaded: Loaded) -> Opened {
        let Loaded { desc, sources, .. } = loaded;
        Opened { path: path.to_owned(), desc, sources, options: options.clone() }
    }

    /// The text of a TOML scene; `None` for a file of another format.
    pub(super) fn text(&self) -> Option<&str> {
        let is_toml = SceneFormat::of_path(&self.path) == Some(SceneFormat::Toml);
        let has_overrides = !self.options.overrides.is_empty() || self.options.integrator.is_some();
        self.sources.files().first().filter(|_| is_toml && !has_overrides).map(|file| file.text.as_str())
    }
}
