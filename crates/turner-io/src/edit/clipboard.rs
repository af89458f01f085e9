//! Parts of a scene as text: copy and paste.

use turner::description::{SceneAssets, SceneDesc, read_scene};
use turner::schema::SceneError;
use turner::schema::value::{Data, FileId, Span, Table, Value};

use super::tree::{Uris, tree};
use crate::convert::text::{key_text, keys};
use crate::scene::{SourceFile, Sources, parse};
use std::path::Path;

/// The text of parts of a scene, by their key paths, with the materials, textures, media and groups that they refer to.
/// It is a scene file without settings: [`paste`] reads it, and so does a person.
///
/// Errors: a path that names no object, light, view, texture, material, medium or group.
pub fn copy(desc: &SceneDesc, paths: &[String]) -> Result<String, SceneError> {
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    let part = desc.extract(&paths)?;
    let root = tree(&part, false, Path::new(""), &mut Uris::as_named())?;
    let mut out = String::new();
    let Data::Table(top) = &root.data else { return Ok(out) };
    let mut block = |head: String, value: &Value| {
        out += if out.is_empty() { "" } else { "\n" };
        out += &format!("{head}\n{}", keys(value));
    };
    for kind in ["texture", "medium", "material"] {
        if let Some(Value { data: Data::Table(section), .. }) = top.get(kind) {
            section.entries.iter().for_each(|e| block(format!("[{kind}.{}]", key_text(&e.key)), &e.value));
        }
    }
    let items = |section: Option<&Value>| match section.map(|v| &v.data) {
        Some(Data::Array(items)) => items.clone(),
        _ => Vec::new(),
    };
    if let Some(Value { data: Data::Table(groups), .. }) = top.get("group") {
        for group in &groups.entries {
            let Data::Table(table) = &group.value.data else { continue };
            let head = format!("[[group.{}.object]]", key_text(&group.key));
            items(table.get("object")).iter().for_each(|item| block(head.clone(), item));
        }
    }
    for list in ["view", "light", "object"] {
        items(top.get(list)).iter().for_each(|item| block(format!("[[{list}]]"), item));
    }
    Ok(out)
}

/// Adds the parts in a text to a scene and returns their key paths. Names that are taken get a number, and references in
/// the text follow. Materials, textures, media and groups that the scene has already, with the same name and values, are
/// used instead of copies. Camera, film and other settings in the text are ignored.
///
/// Errors: those of reading a scene, with line and column in the text. The description then stays the same.
pub fn paste(
    desc: &mut SceneDesc,
    text: &str,
    assets: &mut dyn SceneAssets,
) -> Result<Vec<String>, SceneError> {
    let mut root = parse(text, FileId(0)).map_err(|error| placed(error, text))?;
    if let Data::Table(top) = &mut root.data {
        // Colours such as "#ff8000" are read as in this scene.
        let mut film = Table::default();
        film.push("transfer", desc.value_at("film.transfer")?.map(|value| value.data));
        top.set("film", Span::NONE, Value::new(Data::Table(film)));
        top.entries.retain(|entry| entry.key != "include");
    }
    let mut part = read_scene(&root, assets).map_err(|error| placed(error, text))?;
    part.warnings.clear();
    desc.merge(part)
}

/// The error with line and column.
fn placed(error: SceneError, text: &str) -> SceneError {
    let mut sources = Sources::default();
    let (name, uri) = ("pasted text".to_owned(), String::new());
    sources.add(SourceFile { name, uri, text: text.to_owned(), is_argument: false });
    let at = error.span.and_then(|span| sources.locate(span)).map(|at| (at.line, at.column));
    match at {
        Some((line, column)) => {
            SceneError { message: format!("line {line}, column {column}: {}", error.message), ..error }
        }
        None => error,
    }
}
