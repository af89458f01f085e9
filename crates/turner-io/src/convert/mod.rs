//! Scenes as files of another format: [`to_toml`] writes all that a description holds as a scene that a person can edit, with meshes as PLY and pictures as
//! PNG or in the encoding they came in, in folders beside it; [`to_glb`] writes what glTF can say as one file.
//!
//! ```text
//! SceneDesc ── turner::description::write_scene ──> Value ── text ──> scene.toml
//!      └ meshes, pictures, lamps, grids ── files ──> scene-meshes/*.ply, scene-pictures/*.png, scene-data/*
//! ```
//!
//! Loaded again, the result is the same scene ([`SceneDesc::same_scene`]). Every file is written under a temporary name and renamed; the scene itself comes last.

mod comments;
mod file_names;
mod files;
mod glb;
mod text;

use files::Files;

use crate::assets::printable;
use crate::image::{KeptPictures, OutputError, OutputFile};
pub use glb::to_glb;
use std::path::{Path, PathBuf};
use turner::description::{SceneDesc, write_scene};
use turner::schema::Warning;
use turner::schema::{ErrorCode, Remedy, SceneError};

/// How to convert.
#[derive(Clone, Debug, Default)]
pub struct ConvertOptions {
    /// What the scene was made from, for the comment at its head.
    pub source: String,
    /// Whether files that are there may be replaced.
    pub overwrite: bool,
    /// Whether what the new format cannot hold is an error.
    pub strict: bool,
    /// Pictures as their files had them: what is found here is copied bit by bit.
    pub pictures: KeptPictures,
}

/// What was written.
#[derive(Clone, Debug, Default)]
pub struct Converted {
    /// The files, the scene itself last.
    pub files: Vec<WrittenFile>,
    /// What the new format cannot hold, or not exactly.
    pub warnings: Vec<Warning>,
}

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenFile {
    /// Its path.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
}

/// Writes a scene in Turner's own language to `out`, the data that it names to folders beside it: `NAME-meshes`, `NAME-pictures`, `NAME-data`.
///
/// Errors: files that are there already, unless they may be replaced; whatever keeps files from being written. What had been written before is removed again.
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

/// A file to be written, if nothing is in its place or that may be replaced.
fn create(path: &Path, overwrite: bool) -> Result<OutputFile, SceneError> {
    if !overwrite && path.symlink_metadata().is_ok_and(|m| m.is_file() || m.is_symlink()) {
        return Err(exists(path, "there is such a file already"));
    }
    OutputFile::create(path).map_err(output_error)
}

fn exists(path: &Path, what: &str) -> SceneError {
    let message = format!("{}: {what}", printable(&path.to_string_lossy()));
    SceneError::new(ErrorCode::Output, message)
        .help("choose another name, or let it be replaced")
        .remedy(Remedy::Replace)
}

fn output_error(error: OutputError) -> SceneError {
    crate::scene::two_lines(ErrorCode::Output, &error.to_string())
}
