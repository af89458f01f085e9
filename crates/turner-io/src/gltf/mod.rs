//! Import of glTF 2.0 and its binary container GLB.
//!
//! ```text
//! bytes ── glb ──> JSON ── json ──> Document ┐
//!              └─> chunk ── buffers ─────────┤ ── nodes, animations ──> transforms
//!                                            ├ ── accessors, draco, primitives ──> meshes ── objects ──> objects
//!                                            └ ── images, textures, materials, lights, cameras
//! ```
//!
//! Hostile files are safe to open: indices are checked, sizes are compared with the available bytes before anything
//! is allocated, and memory is bounded in proportion to the file's size. A damaged file is rejected with a JSON
//! pointer to the problem. The scene's warnings say what was approximated or ignored.

mod accessors;
mod animations;
mod base64;
mod budget;
mod buffers;
mod cameras;
mod check;
mod draco;
mod environment;
mod fault;
mod glb;
mod images;
mod instances;
mod json;
mod lights;
mod materials;
mod meshopt;
mod nodes;
mod objects;
mod pointers;
mod primitives;
mod report;
mod skins;
mod tangents;
mod textures;
mod topology;
mod tubes;
mod variants;

use std::collections::{BTreeMap, BTreeSet};

use animations::Pose;
use budget::Budget;
use buffers::Buffers;
use fault::{Fault, Outcome};
use images::Images;
use json::{Document, Index};
use materials::Converter;
use nodes::Tree;
use objects::{Objects, Wanted};
use report::Report;
use textures::Textures;
use turner::description::{ImportSummary, SceneDesc};
use turner::material::MaterialDesc;
use turner::schema::{Named, SceneError, WarningKind};

use crate::assets::{AssetSource, printable};
use crate::import::ImportOptions;

/// The supported extensions.
const KNOWN: &[&str] = &[
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Extensions that are not reported: they do not affect the picture, or are reported elsewhere.
const SILENT: &[&str] = &["KHR_xmp_json_ld", "KHR_xmp"];

/// Memory for each byte of JSON text, in bytes, for typical exporters.
const JSON_PER_BYTE: u64 = 4;

/// Reads a glTF file, binary or JSON, as a scene with exactly what the file contains: objects, materials, lights and
/// cameras. `uri` is its name relative to the root of `assets`, from which buffers and images are read.
pub fn import(
    bytes: Vec<u8>,
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    read(bytes, uri, assets, options).map_err(|fault| fault.in_file(uri))
}

fn read(bytes: Vec<u8>, uri: &str, assets: &dyn AssetSource, options: &ImportOptions) -> Outcome<SceneDesc> {
    let mut report = Report::default();
    let parts = glb::split(&bytes)?;
    parts.faults.iter().for_each(|doubt| report.doubtful(*doubt));
    let text = bytes.get(parts.json.clone()).unwrap_or_default();
    let needed = JSON_PER_BYTE.saturating_mul(text.len() as u64);
    options.limits.memory.need(needed, || "its JSON text".to_owned()).map_err(Fault::of_scene)?;
    let document = json::parse(text)?;
    check_extensions(&document, &mut report)?;

    let mut buffers = Buffers::read(&document, bytes, parts.bin, uri, assets)?;
    let budget = Budget::of_file(buffers.size()).within(&options.limits.memory);
    buffers.open_views(&document, &budget)?;
    buffers.report(&mut report);
    objects::check_accessors(&document, &buffers, &budget)?;

    let tree = Tree::new(&document)?;
    let text = buffers.file(parts.json);
    check::check(text, &document, (&buffers, &tree), (uri, assets), &mut report);
    let (document, Pose { locals, weights }) =
        animate(document, text, (&buffers, &budget), options, &mut report)?;
    let world = tree.world(locals);
    let shown = tree.shown(&document, options.scene.as_deref(), &options.nodes, &mut report)?;

    let variant = variants::chosen(&document, options.variant.as_deref())?;
    let mut objects = Objects::new(&document, (&buffers, &budget), (&weights, &world), variant);
    let (mut lights, mut cameras) = (Vec::new(), Vec::new());
    for &number in &shown {
        objects.add_node(number, &mut report)?;
        let node = &document.nodes[Index(number)];
        let (pointer, name) = (format!("/nodes/{number}"), node.name.as_deref());
        let place = &world[number as usize];
        if let Some(light) = node.extensions.as_deref().and_then(|e| e.light.as_ref()) {
            lights.extend(lights::light(&document, light.light, place, name, &mut report, &pointer)?);
        }
        if let Some(camera) = node.camera {
            cameras.extend(cameras::camera(&document, camera, place, name, &mut report, &pointer)?);
        }
    }

    let Objects { meshes, objects, wanted, instances, .. } = objects;
    let scene = nodes::choose_scene(&document, options.scene.as_deref())?;
    let sky = environment::of_scene(&document, scene)?;
    let faces = sky.as_ref().map_or(&[][..], |sky| &sky.faces);
    let images = decode_images(&document, &buffers, (&wanted, faces), (uri, assets), options, &mut report)?;
    let mut textures = Textures::default();
    let mut converter =
        Converter { document: &document, images: &images, textures: &mut textures, report: &mut report };
    let materials = wanted
        .iter()
        .map(|(material, has_colors)| {
            let name = material.and_then(|m| document.materials[m].name.clone());
            let value = MaterialDesc::Principled(converter.convert(*material, *has_colors));
            Named { name, span: None, value }
        })
        .collect();

    let count = |n: usize| n as u64;
    let triangles = meshes.iter().map(|m| count(m.data.triangles.len())).sum();
    options.limits.check_triangles(triangles, || "the file".to_owned()).map_err(Fault::of_scene)?;
    let mut pictures = images.assets.clone();
    if let Some(sky) = &sky {
        lights.extend(environment::light(sky, &images, &mut pictures, options, &mut report)?);
    }
    let lights_in_file = document.extensions.lights.as_ref().map_or(0, |l| l.lights.len())
        + document.extensions.environments.as_ref().map_or(0, |e| e.lights.len());
    let counts = vec![
        ("nodes", count(document.nodes.len())),
        ("meshes", count(document.meshes.len())),
        ("primitives", document.meshes.iter().map(|m| count(m.primitives.len())).sum()),
        ("triangles", triangles),
        ("materials", count(document.materials.len())),
        ("textures", count(document.textures.len())),
        ("images", count(document.images.len())),
        ("lights", count(lights_in_file)),
        ("cameras", count(document.cameras.len())),
        ("skins", count(document.skins.len())),
        ("animations", count(document.animations.len())),
        ("instances", instances),
    ];
    if objects.is_empty() {
        report.doubtful("the file contains no geometry");
    }
    let empty = SceneDesc::default();
    let animations = document.animations.iter().filter_map(|a| a.name.clone()).collect();
    let variants = document.extensions.variants.iter().flat_map(|v| &v.variants).map(|v| v.name.clone());
    let names = vec![("animations", animations), ("variants", variants.collect())];
    let summary = ImportSummary { file: printable(uri), format: "glTF 2.0", counts, names };
    Ok(SceneDesc {
        camera: cameras.first().cloned(),
        textures: textures.list,
        materials,
        objects,
        lights,
        images: pictures,
        meshes,
        cameras,
        imports: vec![summary],
        warnings: report.into_warnings(),
        ..empty
    })
}

/// The document and its pose at the chosen time of the chosen animation.
fn animate(
    document: Document,
    text: &[u8],
    data: (&Buffers, &Budget),
    options: &ImportOptions,
    report: &mut Report,
) -> Outcome<(Document, Pose)> {
    let Some(chosen) = animations::chosen(&document, options.animation.as_deref(), report)? else {
        let pose = Pose::rest(&document);
        return Ok((document, pose));
    };
    let of = (&document, &document.animations[chosen], chosen.0);
    let changed = pointers::animated(text, of, data, &options.limits.memory, options.time, report)?;
    let document = changed.unwrap_or(document);
    let mut pose = Pose::rest(&document);
    pose.apply(&document, data, chosen, options.time, report)?;
    Ok((document, pose))
}

/// Rejects unsupported required extensions and reports other unknown ones.
fn check_extensions(document: &Document, report: &mut Report) -> Outcome<()> {
    for (i, name) in document.extensions_required.iter().enumerate() {
        if KNOWN.contains(&name.as_str()) {
            continue;
        }
        let fault = Fault::at(
            format!("/extensionsRequired/{i}"),
            format!("the file requires {name}, which is not supported"),
        );
        return Err(fault.help(format!("supported are {}", KNOWN.join(", "))));
    }
    for name in &document.extensions_used {
        if !KNOWN.contains(&name.as_str()) && !SILENT.contains(&name.as_str()) {
            report.add(WarningKind::Ignored, format!("the extension {}", printable(name)));
        }
    }
    Ok(())
}

/// Decodes the images that the materials of visible objects use, and those of the environment.
fn decode_images(
    document: &Document,
    buffers: &Buffers,
    (wanted, faces): (&[Wanted], &[Index]),
    source: (&str, &dyn AssetSource),
    options: &ImportOptions,
    report: &mut Report,
) -> Outcome<Images> {
    let mut textures = Vec::new();
    for material in wanted.iter().filter_map(|(material, _)| *material) {
        for (info, is_color) in materials::textures_of(&document.materials[material]) {
            let pointer = format!("/materials/{}", material.0);
            let Some(texture) = document.textures.get(info.index.index()) else {
                return Err(Fault::dangling(pointer, "texture", info.index.0, document.textures.len()));
            };
            let pointer = format!("/textures/{}", info.index.0);
            if let Some(sampler) = texture.sampler.filter(|s| s.index() >= document.samplers.len()) {
                return Err(Fault::dangling(pointer, "sampler", sampler.0, document.samplers.len()));
            }
            for image in textures::candidates(texture) {
                if image.index() >= document.images.len() {
                    return Err(Fault::dangling(pointer, "image", image.0, document.images.len()));
                }
            }
            if textures::candidates(texture).next().is_none() {
                report.ignored("textures without an image");
            }
            textures.push((texture, is_color));
        }
    }
    let mut images = Images::default();
    let mut tried = BTreeSet::new();
    // A texture's next image is decoded only where those before it could not be.
    for preference in 0..textures::MOST_CANDIDATES {
        let mut used: BTreeMap<Index, bool> = BTreeMap::new();
        for &(texture, is_color) in &textures {
            let is_done = textures::candidates(texture).any(|image| images.id(image).is_some());
            let image = textures::candidates(texture).nth(preference);
            if let Some(image) = image.filter(|image| !is_done && !tried.contains(image)) {
                // An image used as both colour and data is downscaled as colour.
                *used.entry(image).or_default() |= is_color;
            }
        }
        if preference == 0 {
            used.extend(faces.iter().map(|face| (*face, true)));
        }
        tried.extend(used.keys().copied());
        images.decode(document, buffers, &used, source, options, report);
    }
    Ok(images)
}

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
