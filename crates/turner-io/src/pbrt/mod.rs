//! Scenes of pbrt-v4 (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 2023; format:
//! pbrt.org/fileformat-v4), and of pbrt-v3 ([`version3`]).
//!
//! [`source`] is a window over the bytes of a file, [`lexer`] splits them into tokens, and [`reader`] executes
//! the directives. One module per kind of object (camera, lights, materials, shapes, …) translates it to
//! Turner's descriptions, which an [`assembly`] collects. Lists of numbers go directly from the text into the
//! arrays of the scene. Unknown parameters are reported with their position.

mod assembly;
mod camera;
#[cfg(test)]
mod camera_tests;
mod directives;
mod environment;
mod float_pictures;
mod frame;
#[cfg(test)]
mod frame_tests;
mod goniometric;
mod hair;
mod layer_colors;
mod layers;
mod lens;
mod lexer;
#[cfg(test)]
mod light_tests;
mod lights;
mod materials;
mod media;
#[cfg(test)]
mod medium_tests;
mod params;
mod projection;
mod reader;
mod shapes;
mod source;
mod spectra;
mod state;
mod subsurface;
mod surfaces;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod texture_tests;
mod textures;
mod transform;
mod version3;

use std::io::Read;

use assembly::Assembly;
use reader::Reader;
use report::Fault;
use turner::description::{ImportSummary, SceneDesc};
use turner::schema::{ErrorCode, SceneError};

use crate::assets::{AssetSource, printable};
use crate::gzip;
use crate::import::ImportOptions;
use crate::scene_import::{CommonParts, fill_open, report};

/// Largest scene file, bytes.
const MAX_FILE: u64 = 64 << 30;
/// Most bytes of decompressed text.
const MAX_TEXT: usize = 4 << 30;

/// Imports a scene with its camera, film and integrator. `uri` is its path from the root of `assets`.
pub(crate) fn import(
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let bytes = assets.open(uri, MAX_FILE).map_err(|e| e.to_scene_error())?;
    import_from(bytes, uri, assets, options)
}

/// The same from an open file.
pub(crate) fn import_from<'a>(
    bytes: Box<dyn Read + 'a>,
    uri: &str,
    assets: &'a dyn AssetSource,
    options: &'a ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let named = |f: Fault| f.into_error(&[uri.to_owned()]);
    let bytes = opened(bytes, uri, options.limits.memory.left()).map_err(named)?;
    let mut reader = Reader::new(assets, uri, bytes, Assembly::new(assets, uri, options));
    let read = reader.read();
    let mut scene = reader.scene;
    let made = read.and_then(|()| materials::finish(&mut scene));
    let materials = made.map_err(|fault| fault.into_error(&scene.files))?;
    finish(scene, materials)
}

/// The text of a file that may be compressed.
fn opened<'a>(mut bytes: Box<dyn Read + 'a>, name: &str, left: u64) -> Result<Box<dyn Read + 'a>, Fault> {
    let fault = |problem: String| Fault::new(ErrorCode::File, format!("{}: {problem}", printable(name)));
    let mut head = Vec::new();
    bytes.by_ref().take(2).read_to_end(&mut head).map_err(|e| fault(format!("cannot be read: {e}")))?;
    if !gzip::is_gzip(&head) {
        return Ok(Box::new(std::io::Cursor::new(head).chain(bytes)));
    }
    bytes.take(MAX_TEXT as u64).read_to_end(&mut head).map_err(|e| fault(format!("cannot be read: {e}")))?;
    // Half: a growing buffer exists twice while it moves.
    let left = usize::try_from(left / 2).unwrap_or(usize::MAX);
    let limit = head.len().saturating_mul(64).saturating_add(1 << 20).min(MAX_TEXT).min(left);
    let text = gzip::decompress(&head, limit).map_err(fault)?;
    Ok(Box::new(std::io::Cursor::new(text)))
}

fn finish(
    assembly: Assembly<'_>,
    materials: Vec<turner::schema::Named<turner::material::MaterialDesc>>,
) -> Result<SceneDesc, SceneError> {
    let mut scene = SceneDesc::default();
    let count = |n: usize| n as u64;
    let counts = vec![
        ("files", count(assembly.files.len())),
        ("shapes", assembly.shapes),
        ("triangles", assembly.meshes.iter().map(|m| count(m.data.triangles.len())).sum()),
        ("materials", count(materials.len())),
        ("textures", count(assembly.textures.len())),
        ("pictures", count(assembly.images.len())),
        ("lights", count(assembly.lights.len())),
        ("objects", count(assembly.groups.len())),
        ("media", count(assembly.medium_list.len())),
    ];
    // A medium around the camera that no shape encloses fills the open space.
    let around = assembly.media.get(&assembly.frame.medium).filter(|_| assembly.frame.shows_media).copied();
    let around = around.filter(|id| !assembly.materials.encloses(*id));
    let Assembly { frame, stock, .. } = assembly;
    let CommonParts { mut report, files, uri, objects, medium_list: mut media, .. } = stock;
    media::expose(&mut media, &frame);
    if objects.is_empty() {
        report.note("the file contains no geometry");
    }
    let format = if frame.is_version3 { "pbrt-v3" } else { "pbrt-v4" };
    frame.apply(&mut scene);
    scene.textures = stock.texture_list;
    scene.materials = materials;
    scene.media = media;
    scene.groups = stock.groups;
    scene.objects = objects;
    scene.lights = stock.lights;
    scene.images = stock.images;
    scene.meshes = stock.meshes;
    fill_open(&mut scene, around);
    scene.imports = vec![ImportSummary { file: printable(&uri), format, counts, names: Vec::new() }];
    scene.warnings = report.into_warnings(&files);
    Ok(scene)
}
