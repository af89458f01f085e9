//! The files of a scene that are read ahead: meshes and pictures.

use super::document::{Document, read_file};
use super::meshes;
use crate::assets::AssetSource;
use crate::import::ImportOptions;
use crate::scene_import::{LoadedFile, SceneFile, load_image};

/// The files of a scene, in the order of the document.
pub(super) fn files(document: &Document) -> Vec<SceneFile> {
    let mut all = Vec::new();
    for node in document.nodes() {
        let Some(kind) = node.attribute("type") else { continue };
        let strings = node.children.iter().filter_map(|child| document.node(*child));
        let mut named = strings.filter(|n| n.tag == "string" && n.attribute("name") == Some("filename"));
        let Some(name) = named.next().and_then(|n| n.attribute("value")) else { continue };
        match (node.tag.as_str(), kind) {
            ("shape", "obj") => all.push(SceneFile::Mesh(name.to_owned(), "obj")),
            ("shape", "ply") => all.push(SceneFile::Mesh(name.to_owned(), "ply")),
            // Pictures in search paths are found by the importer.
            ("texture", "bitmap") | ("emitter", "envmap") if document.paths.is_empty() => {
                all.push(SceneFile::Picture(name.replace('\\', "/")));
            }
            _ => {}
        }
    }
    all
}

/// Reads a file; `None` if that fails. Also its bytes in memory.
pub(super) fn read(
    file: &SceneFile,
    assets: &dyn AssetSource,
    uri: &str,
    paths: &[String],
    options: &ImportOptions,
) -> Option<(LoadedFile, u64)> {
    match file {
        SceneFile::Mesh(name, kind) => {
            let (path, bytes, mark) = read_file(assets, uri, paths, name, meshes::MAX_FILE, true).ok()?;
            let size = 2 * bytes.len() as u64;
            let mut read = meshes::decode(&bytes, path, kind, options).ok()?;
            read.mark = mark;
            Some((LoadedFile::Mesh(Box::new(read)), size))
        }
        SceneFile::Picture(name) => {
            let loaded = load_image(assets, uri, name, options, 0, true).ok()?;
            let size = (loaded.image.memory() + loaded.bytes.len()) as u64;
            Some((LoadedFile::Image(Box::new(loaded)), size))
        }
    }
}
