//! Opening files and texts.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value as Json, json};
use turner_io::assets::MemoryAssets;
use turner_io::scene::SceneFormat;
use turner_live::document::Document;

use super::calls::{Args, Files};
use super::{CallError, Reply, Session};

/// Most files that belong to a scene.
const MAX_FILES: usize = 10_000;

pub(super) fn open(session: &mut Session, args: &Json, files: Files) -> Result<Reply, CallError> {
    if files.len() > MAX_FILES {
        let message = format!("{} files; expected at most {MAX_FILES}", files.len());
        return Err(CallError {
            help: Some("open the folder of the scene alone".into()),
            ..CallError::new(message)
        });
    }
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let main = match Args(args).optional_text("main")? {
        Some(main) => main.to_owned(),
        None => choose(&names)?.to_owned(),
    };
    // A scene may read what lies in its folder or below: its folder is the root.
    let folder = main.rfind('/').map_or("", |end| &main[..=end]).to_owned();
    let name = main[folder.len()..].to_owned();
    let below =
        files.into_iter().filter_map(|(name, bytes)| Some((name.strip_prefix(&folder)?.to_owned(), bytes)));
    let files = Arc::new(MemoryAssets { files: below.collect() });
    let document = Document::in_memory(&name, files, &session.load_options())?;
    session.show(document);
    Ok(json!({ "name": name }).into())
}

/// The file among several that is the scene: the one of the best format nearest to the top. Models do not count beside
/// scenes.
fn choose<'a>(names: &[&'a str]) -> Result<&'a str, CallError> {
    let rank = |name: &str| {
        let format = SceneFormat::of_path(Path::new(name))?;
        let kind = match format {
            SceneFormat::Toml => 0,
            SceneFormat::Pbrt | SceneFormat::Mitsuba => 1,
            SceneFormat::Gltf | SceneFormat::Usd => 2,
            SceneFormat::Obj => 3,
            SceneFormat::Ply | SceneFormat::Stl => 4,
        };
        Some((kind, name.matches('/').count()))
    };
    let mut ranked: Vec<_> = names.iter().filter_map(|name| Some((rank(name)?, *name))).collect();
    ranked.sort();
    let Some(&(best, first)) = ranked.first() else {
        let formats: Vec<String> = SceneFormat::all()
            .map(|format| format!("{} (.{})", format.name(), format.extensions().join(", .")))
            .collect();
        let what = match names {
            [] => "no file".to_owned(),
            [only] => format!("\"{only}\""),
            [first, ..] => format!("\"{first}\" and {} more files", names.len() - 1),
        };
        return Err(CallError {
            help: Some(format!("open one of: {}", formats.join(", "))),
            ..CallError::new(format!("{what}: none is a scene or a model that Turner reads"))
        });
    };
    let equal: Vec<&str> = ranked.iter().filter(|(own, _)| *own == best).map(|(_, name)| *name).collect();
    // `scene.xml` is the usual name of the main file among its parts.
    let usual = equal.iter().find(|name| {
        let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
        stem.is_some_and(|stem| ["scene", "main", "index"].contains(&stem.as_str()))
    });
    match (equal.as_slice(), usual) {
        ([_], _) => Ok(first),
        (_, Some(usual)) => Ok(usual),
        _ => {
            let listed: Vec<&str> = equal.iter().take(10).copied().collect();
            Err(CallError {
                help: Some(format!("open one of: {}", listed.join(", "))),
                ..CallError::new(format!("{} of the files are scenes", equal.len()))
            })
        }
    }
}

pub(super) fn set_text(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let text = Args(args).text("text")?;
    let options = session.load_options();
    if session.is_open {
        session.document.set_text(text, &options)?;
        session.order();
    } else {
        let name = "scene.toml";
        let files = MemoryAssets { files: [(name.to_owned(), text.as_bytes().to_vec())].into() };
        let document = Document::in_memory(name, Arc::new(files), &options)?;
        session.show(document);
    }
    Ok(Json::Object(Default::default()).into())
}

pub(super) fn text(session: &Session) -> Result<Reply, CallError> {
    Ok(json!({ "text": session.document.text()? }).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_among_files_is_found() {
        assert_eq!(choose(&["a/wood.png", "a/scene.toml", "a/mesh.ply"]).unwrap(), "a/scene.toml");
        assert_eq!(choose(&["part.pbrt", "scene.pbrt"]).unwrap(), "scene.pbrt");
        assert_eq!(choose(&["deep/er/a.glb", "b.glb"]).unwrap(), "b.glb");
        let error = choose(&["a.toml", "b.toml"]).unwrap_err();
        assert!(error.help.unwrap().contains("a.toml, b.toml"));
        let error = choose(&["a.fbx"]).unwrap_err();
        assert!(error.help.unwrap().contains("glTF 2.0 (.glb, .gltf)"));
    }
}
