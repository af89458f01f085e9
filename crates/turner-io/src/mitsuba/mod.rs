//! Mitsuba scenes (Jakob et al., "Mitsuba 3 renderer", 2022; format: mitsuba.readthedocs.io, "Scene XML file
//! format"), also those of Mitsuba 2 and 0.6.
//!
//! [`xml`] reads elements, [`document`] builds a tree in which included files and the values of `$names` are in
//! place, and [`params`] gives access to the contents of an element by name. One module per kind of object
//! translates it to Turner's descriptions, which an [`assembly`] collects. Colours are those of Mitsuba's RGB
//! mode. Unknown elements are reported with their position.

mod ahead;
mod assembly;
mod attributes;
mod disney;
mod distance_grids;
mod document;
mod emitters;
mod environment;
mod frame;
mod hair;
mod leaves;
mod materials;
mod media;
mod meshes;
mod metals;
mod older;
mod params;
mod phase;
mod projected;
mod rough_layer;
mod serialized;
mod shapes;
mod sky;
mod sky_strength;
mod spectra;
mod sun;
#[cfg(test)]
mod tests;
mod textures;
mod transform;
mod volumes;
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
use crate::scene_import::{CommonParts, FilesAhead, SceneFile, fill_open};

/// Largest scene file, bytes.
const MAX_FILE: u64 = 256 << 20;

/// Imports a scene with its camera, film and integrator. `uri` is its path from the root of `assets`.
pub(crate) fn import(
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let bytes = assets.read(uri, MAX_FILE).map_err(|e| e.to_scene_error())?;
    import_from(bytes, uri, assets, options)
}

/// The same from the bytes of the file.
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
    let document = loader.document;
    let paths = document.paths.clone();
    let read = |file: &SceneFile| ahead::read(file, assets, uri, &paths, options);
    let available = || turner_host::thread::available();
    let threads = if options.threads == 0 { available() } else { options.threads };
    FilesAhead::run(ahead::files(&document), threads, &read, |ahead| {
        let mut scene = Assembly::new(assets, uri, options, document);
        scene.stock.ahead = Some(ahead);
        let materials = fill(&mut scene).map_err(|fault| fault.into_error(&files))?;
        finish(scene, materials)
    })
}

/// Imports all objects of the scene.
fn fill(scene: &mut Assembly<'_>) -> Result<Vec<Named<MaterialDesc>>, Fault> {
    for name in scene.document.unused.clone() {
        let message = format!("\"{}\" is set, but the scene has no such parameter", printable(&name));
        scene.report.ignored_anywhere(message);
    }
    let root = Object::new(&scene.document, 0)?;
    let all = root.all()?;
    // First the sensor: the camera needs the size of its film, and the open space the camera's medium.
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
    // A medium around the camera that no shape encloses fills the open space.
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
