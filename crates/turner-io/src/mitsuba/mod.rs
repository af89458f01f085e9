//! Mitsuba scenes (Jakob et al., "Mitsuba 3 renderer", 2022; format: mitsuba.readthedocs.io, "Scene XML file format"), and those of Mitsuba 2 and 0.6.
//!
//! [`xml`] reads elements, [`document`] makes a tree of them with included files and `$names` in their places, [`params`] is how a part of it is
//! asked for what it has, and a file per kind of thing maps it onto what there is here, into an [`assembly`]. Colours are those that Mitsuba has where
//! it computes with red, green and blue. What is not known is reported at its place.

mod assembly;
mod document;
mod emitters;
mod environment;
mod frame;
mod leaves;
mod materials;
mod media;
mod meshes;
mod metals;
mod older;
mod params;
mod rough_layer;
mod serialized;
mod shapes;
mod spectra;
#[cfg(test)]
mod tests;
mod textures;
mod transform;
mod xml;

use assembly::Assembly;
use document::Loader;
use params::Object;
use turner::description::{ImportSummary, SceneDesc};
use turner::material::MaterialDesc;
use turner::schema::{Named, SceneError};

use crate::assets::{AssetSource, printable};
use crate::import::ImportOptions;
use crate::scene_import::report::Fault;
use crate::scene_import::{CommonParts, fill_open};

/// Most bytes of the file itself.
const MAX_FILE: u64 = 256 << 20;

/// Reads a scene: with its camera, its film and its integrator. `uri` is its name relative to the root of `assets`.
pub(crate) fn import(
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let bytes = assets.read(uri, MAX_FILE).map_err(|e| e.to_scene_error())?;
    import_from(bytes, uri, assets, options)
}

/// The same with the bytes of the file itself from elsewhere.
pub(crate) fn import_from(
    bytes: Vec<u8>,
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let mut loader = Loader::new(assets, uri, &options.defines);
    let read = loader.read(bytes);
    let files = loader.document.files.clone();
    read.map_err(|fault| fault.into_error(&files))?;
    let mut scene = Assembly::new(assets, uri, options, loader.document);
    let materials = fill(&mut scene).map_err(|fault| fault.into_error(&files))?;
    finish(scene, materials)
}

/// Makes everything that stands in the scene itself.
fn fill(scene: &mut Assembly<'_>) -> Result<Vec<Named<MaterialDesc>>, Fault> {
    for name in scene.document.unused.clone() {
        let message = format!("\"{}\" is set, but the scene has no such parameter", printable(&name));
        scene.report.ignored_anywhere(message);
    }
    let root = Object::new(&scene.document, 0)?;
    let all = root.all()?;
    // The film's size counts for the camera, the camera's medium for what is around.
    for object in all.iter().filter(|o| o.tag == "integrator") {
        frame::integrator(scene, object)?;
    }
    for object in all.iter().filter(|o| o.tag == "sensor") {
        frame::sensor(scene, object)?;
    }
    for object in &all {
        match object.tag.as_str() {
            "shape" => shapes::add(scene, object)?,
            "emitter" => emitters::add(scene, object)?,
            _ => {}
        }
    }
    scene.finish(&root);
    materials::finish(scene)
}

fn finish(assembly: Assembly<'_>, materials: Vec<Named<MaterialDesc>>) -> Result<SceneDesc, SceneError> {
    let mut scene = SceneDesc::default();
    let count = |n: usize| n as u64;
    let counts = vec![
        ("files", count(assembly.files.len())),
        ("shapes", assembly.shapes),
        ("triangles", assembly.meshes.iter().map(|m| count(m.data.triangles.len())).sum()),
        ("materials", count(materials.len())),
        ("textures", count(assembly.texture_list.len())),
        ("pictures", count(assembly.images.len())),
        ("lights", count(assembly.lights.len())),
        ("groups", count(assembly.groups.len())),
        ("media", count(assembly.medium_list.len())),
    ];
    // What the camera stands in and no shape encloses is everywhere in the open.
    let around = assembly.frame.medium.filter(|id| !assembly.materials.encloses(*id));
    let Assembly { frame, stock, .. } = assembly;
    let CommonParts { mut report, files, uri, objects, .. } = stock;
    if objects.is_empty() {
        report.note("the file contains no geometry");
    }
    frame.apply(&mut scene);
    scene.textures = stock.texture_list;
    scene.materials = materials;
    scene.media = stock.medium_list;
    scene.groups = stock.groups;
    scene.objects = objects;
    scene.lights = stock.lights;
    scene.images = stock.images;
    scene.meshes = stock.meshes;
    fill_open(&mut scene, around);
    scene.imports =
        vec![ImportSummary { file: printable(&uri), format: "Mitsuba", counts, names: Vec::new() }];
    scene.warnings = report.into_warnings(&files);
    Ok(scene)
}
