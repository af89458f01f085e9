//! The text of a scene that is not on disk.

use std::path::Path;

use turner::description::SceneDesc;
use turner::schema::{ErrorCode, SceneError};

use super::known::reread_from;
use super::opened::Opened;
use super::save::film_for;
use super::sections::spliced;
use super::tree::{Uris, tree};
use crate::assets::AssetSource;
use crate::convert::text;
use crate::scene::{LoadOptions, SceneFormat};

/// The text of a description: that of the opened scene with the changes, or, for a model or a new scene, a short one that
/// names the model. Files keep their names. The text was read again and gave the same scene. A text that cannot be changed
/// in place is written anew, without its comments.
///
/// Errors: a scene of another program, or a change that a text cannot express, such as one inside a model.
pub fn scene_text(
    desc: &SceneDesc,
    opened: Option<&Opened>,
    assets: &dyn AssetSource,
) -> Result<String, SceneError> {
    let here = Path::new("");
    let name =
        opened.map_or_else(|| "scene.toml".to_owned(), |opened| opened.path.to_string_lossy().into_owned());
    let none = |reason: &str| {
        let message = format!("{name}: the scene has no text: {reason}");
        SceneError::new(ErrorCode::Output, message).help("convert it: `turner convert`")
    };
    let load = opened.map(|opened| opened.options.clone()).unwrap_or_default();
    let load = LoadOptions { overrides: Vec::new(), integrator: None, kept_pictures: None, ..load };
    // A model keeps the name of its file; its text has another.
    let own = if name.ends_with(".toml") { name.as_str() } else { "scene.toml" };
    let check = |text: String| -> Result<String, String> {
        let read = reread_from(&text, own, assets, &load, desc).map_err(|e| e.message)?;
        let same = desc.same_apart_from_order(&read);
        same.map(|()| text).map_err(|difference| {
            let part = difference.split(':').next().unwrap_or_default().to_owned();
            format!("a text cannot express a change of its {part}")
        })
    };
    if let Some((opened, text)) = opened.and_then(|opened| Some((opened, opened.text()?))) {
        let before = tree(&opened.desc, true, here, &mut Uris::as_named())?;
        let after = tree(desc, true, here, &mut Uris::as_named())?;
        let film = match opened.desc.integrator.type_name() == desc.integrator.type_name() {
            true => None,
            false => Some(film_for(&opened.desc, desc)?),
        };
        if let Ok(text) = spliced(text, &before, &after, film).and_then(check) {
            return Ok(text);
        }
    }
    let format = opened.and_then(|opened| SceneFormat::of_path(&opened.path));
    if format.is_some_and(SceneFormat::is_whole) {
        return Err(none("it comes from another program's scene"));
    }
    let root = tree(desc, false, here, &mut Uris::as_named())?;
    check(text::scene(&root, &name)).map_err(|reason| none(&reason))
}
