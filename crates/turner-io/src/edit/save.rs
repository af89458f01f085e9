//! Saves a description in the form of the file that it came from.

use std::path::{Path, PathBuf};

use turner::description::{SceneDesc, write_scene};
use turner::schema::value::{Data, Value};
use turner::schema::{ErrorCode, SceneError};

use super::known::reread;
use super::opened::Opened;
use super::sections::{INCLUDED, spliced};
use super::tree::{Uris, tree};
use crate::convert::{ConvertOptions, WrittenFile, output_error, text, to_toml};
use crate::image::OutputFile;
use crate::scene::{LoadOptions, SceneFormat};

/// What was saved.
#[derive(Clone, Debug, Default)]
pub struct Saved {
    /// The files written; the scene itself is last.
    pub files: Vec<WrittenFile>,
    /// Whether the text kept its comments and its layout: only what changed was written.
    pub kept_text: bool,
    /// What the user should know: files that were copied, and why the text was written anew.
    pub notes: Vec<String>,
}

/// Saves a description as a TOML scene. `opened` is the file that it was loaded from, or `None` for a new scene.
///
/// - A TOML scene is changed only where the description changed; comments, order and the layout of everything else
///   stay. New parts come after the last of their kind. The comment directly above a removed part goes with it.
/// - A model, or a new scene, becomes a short scene that names the model files. The models must lie in the folder of
///   `out` or below it.
/// - Anything that these forms cannot express, such as a change inside a model, is written in full as
///   [`to_toml`] does, and a note says so.
///
/// Textures, meshes and other files outside the scene's folder are copied beside the scene. The file is written under a
/// temporary name and renamed, after the new text was read again and gave the same scene: after an error, the old file
/// is as it was.
///
/// Errors: a changed part that comes from an included file, if the scene is saved under its own name; any failure to
/// write.
pub fn save_scene(desc: &SceneDesc, opened: Option<&Opened>, out: &Path) -> Result<Saved, SceneError> {
    let name = |path: &Path| path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let options = ConvertOptions {
        source: opened.map_or_else(|| "a new scene".to_owned(), |opened| name(&opened.path)),
        overwrite: true,
        strict: false,
        pictures: opened.and_then(|opened| opened.options.kept_pictures.clone()).unwrap_or_default(),
    };
    let tried = match opened {
        Some(opened) if opened.text().is_some() => changed_text(desc, opened, out, &options),
        _ => short_text(desc, opened, out, &options),
    }?;
    let reason = match tried {
        Ok(saved) => return Ok(saved),
        Err(reason) => reason,
    };
    let is_same_file = opened.is_some_and(|opened| is_same(&opened.path, out));
    if reason == INCLUDED && is_same_file {
        let message = format!("{}: {INCLUDED}, which several scenes may share", name(out));
        return Err(SceneError::new(ErrorCode::Conflict, message)
            .help("save the scene under another name: it is then written in one file"));
    }
    let converted = to_toml(desc, out, &options)?;
    let note = format!("the scene was written in full, without the comments of the file: {reason}");
    Ok(Saved { files: converted.files, kept_text: false, notes: vec![note] })
}

/// Whether two paths are the same file.
fn is_same(a: &Path, b: &Path) -> bool {
    a == b || a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b)
}

/// The folder of a file.
fn folder(path: &Path) -> PathBuf {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    parent.canonicalize().unwrap_or_else(|_| parent.to_owned())
}

/// A text, or why there is none.
type Tried = Result<Saved, String>;

/// The text of the opened file with the changes.
fn changed_text(
    desc: &SceneDesc,
    opened: &Opened,
    out: &Path,
    options: &ConvertOptions,
) -> Result<Tried, SceneError> {
    let Some(text) = opened.text() else { return Ok(Err("it has no text".to_owned())) };
    if folder(&opened.path) != folder(out) {
        return Ok(Err("it goes to another folder than its files".to_owned()));
    }
    let here = Path::new("");
    let before = tree(&opened.desc, true, here, &mut Uris::as_named())?;
    let mut uris = Uris::beside(desc, Some(&opened.desc), out, options)?;
    let after = tree(desc, true, here, &mut uris)?;
    let film = match opened.desc.integrator.type_name() == desc.integrator.type_name() {
        true => None,
        false => Some(film_for(&opened.desc, desc)?),
    };
    let new = match spliced(text, &before, &after, film) {
        Ok(new) => new,
        Err(reason) => return Ok(Err(reason)),
    };
    checked(desc, &new, out, &opened.options, uris, true)
}

/// The film of one scene as written with the integrator of another.
pub(super) fn film_for(film: &SceneDesc, integrator: &SceneDesc) -> Result<Value, SceneError> {
    let desc = SceneDesc {
        film: film.film.clone(),
        integrator: integrator.integrator.clone(),
        ..SceneDesc::default()
    };
    let root = write_scene(&desc, &mut Uris::as_named())?;
    let film = match &root.data {
        Data::Table(top) => top.get("film").cloned(),
        _ => None,
    };
    Ok(film.unwrap_or_else(|| Value::new(Data::Table(Default::default()))))
}

/// A new text that names models by their files.
fn short_text(
    desc: &SceneDesc,
    opened: Option<&Opened>,
    out: &Path,
    options: &ConvertOptions,
) -> Result<Tried, SceneError> {
    let format = opened.and_then(|opened| SceneFormat::of_path(&opened.path));
    if format.is_some_and(SceneFormat::is_whole) {
        return Ok(Err("it comes from another program's scene".to_owned()));
    }
    let base = match opened.map(|opened| folder(&opened.path)) {
        None => PathBuf::new(),
        Some(from) => match from.strip_prefix(folder(out)) {
            Ok(below) => below.to_owned(),
            Err(_) => return Ok(Err("the model is not in the folder of the scene".to_owned())),
        },
    };
    let before = opened.filter(|_| base.as_os_str().is_empty()).map(|opened| &opened.desc);
    let mut uris = Uris::beside(desc, before, out, options)?;
    let root = tree(desc, false, &base, &mut uris)?;
    let new = text::scene(&root, &options.source);
    let load = opened.map(|opened| opened.options.clone()).unwrap_or_default();
    checked(desc, &new, out, &LoadOptions { overrides: Vec::new(), integrator: None, ..load }, uris, false)
}

/// Reads the text again and writes it, if it gives the same scene.
fn checked(
    desc: &SceneDesc,
    new: &str,
    out: &Path,
    options: &LoadOptions,
    uris: Uris<'_>,
    kept_text: bool,
) -> Result<Tried, SceneError> {
    let read = LoadOptions { kept_pictures: None, ..options.clone() };
    match reread(new, out, &read, desc) {
        Err(error) => return Ok(Err(format!("the changed text cannot be read: {error}"))),
        Ok(read) => {
            if let Err(difference) = desc.same_apart_from_order(&read) {
                let part = difference.split(':').next().unwrap_or_default().to_owned();
                return Ok(Err(format!("the file cannot express a change of its {part}")));
            }
        }
    }
    let main = OutputFile::create(out).map_err(output_error)?;
    main.commit(new.as_bytes()).map_err(output_error)?;
    let notes = uris.copied.iter().map(|(from, to)| format!("{from} was copied to {to}")).collect();
    let main = WrittenFile { path: out.to_owned(), bytes: new.len() as u64 };
    Ok(Ok(Saved { files: uris.finish(main), kept_text, notes }))
}
