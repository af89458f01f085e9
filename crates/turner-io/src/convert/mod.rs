//! Conversion of scenes to files of another format. [`to_toml`] writes a complete scene for editing, with meshes as
//! PLY and images in their original encoding or as PNG, in folders next to it. [`to_glb`] writes what glTF can
//! represent as one file.
//!
//! ```text
//! SceneDesc ── turner::description::write_scene ──> Value ── text ──> scene.toml
//!      └ meshes, images, IES profiles, grids ── files ──> scene-meshes/*.ply, scene-pictures/*.png, scene-data/*
//! ```
//!
//! Loading the TOML scene again gives the same scene ([`SceneDesc::same_scene`]). Each file is written under a
//! temporary name and renamed; the scene itself is written last.

mod comments;
mod file_names;
mod files;
mod glb;
mod settings;
pub(crate) mod text;

pub(crate) use files::Files;

use crate::assets::printable;
use crate::image::{KeptPictures, OutputError, OutputFile};
pub use glb::to_glb;
pub use settings::settings_text;
use std::path::{Path, PathBuf};
use turner::description::{SceneDesc, write_scene};
use turner::schema::Warning;
use turner::schema::{ErrorCode, Remedy, SceneError};

/// Options of a conversion.
#[derive(Clone, Debug, Default)]
pub struct ConvertOptions {
    /// The name of the source, for the comment at the top of the scene.
    pub source: String,
    /// Whether existing files may be replaced.
    pub overwrite: bool,
    /// Whether omissions are errors.
    pub strict: bool,
    /// Encoded images; those found here are copied byte for byte.
    pub pictures: KeptPictures,
}

/// The result of a conversion.
#[derive(Clone, Debug, Default)]
pub struct Converted {
    /// The files written; the scene itself is last.
    pub files: Vec<WrittenFile>,
    /// What was omitted or approximated.
    pub warnings: Vec<Warning>,
}

/// A written file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenFile {
    /// Its path.
    pub path: PathBuf,
    /// Its size in bytes.
    pub bytes: u64,
}

/// Writes a scene as TOML to `out`, and its data to folders next to it: `NAME-meshes`, `NAME-pictures`, `NAME-data`.
///
/// Errors: existing files, unless they may be replaced; any failure to write. After an error, the files already
/// written are removed.
pub fn to_toml(desc: &SceneDesc, out: &Path, options: &ConvertOptions) -> Result<Converted, SceneError> {
    let main = create(out, options.overwrite)?;
    let mut files = Files::new(desc, out, options)?;
    let written = write_scene(desc, &mut files).and_then(|root| {
        let text = text::scene(&root, &options.source);
        main.commit(text.as_bytes()).map_err(output_error)?;
        Ok(WrittenFile { path: out.to_owned(), bytes: text.len() as u64 })
    });
    match written {
        Ok(main) => Ok(files.finish(main)),
        Err(error) => {
            files.remove();
            Err(error)
        }
    }
}

/// Creates an output file, unless one exists that may not be replaced.
fn create(path: &Path, overwrite: bool) -> Result<OutputFile, SceneError> {
    if !overwrite && path.symlink_metadata().is_ok_and(|m| m.is_file() || m.is_symlink()) {
        return Err(exists(path, "the file already exists"));
    }
    OutputFile::create(path).map_err(output_error)
}

fn exists(path: &Path, what: &str) -> SceneError {
    let message = format!("{}: {what}", printable(&path.to_string_lossy()));
    SceneError::new(ErrorCode::Output, message)
        .help("choose another name, or allow it to be replaced")
        .remedy(Remedy::Replace)
}

pub(crate) fn output_error(error: OutputError) -> SceneError {
    crate::scene::two_lines(ErrorCode::Output, &error.to_string())
}
