//! Scenes written as glTF follow the rules of the format and are the same scene when read back.
//!
//! The rules are those that Khronos's validator reports as errors and warnings, as far as our writer could violate
//! them.

use std::path::{Path, PathBuf};

use serde_json::Value;
use turner::description::SceneDesc;
use turner::material::MaterialDesc;
use turner::schema::PrepareOptions;
use turner_io::convert::{ConvertOptions, to_glb};
use turner_io::scene::{LoadOptions, load};

use super::loaded;

fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// The JSON and the binary chunk of a GLB file, with its headers checked.
fn split(bytes: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json = word(12);
    assert_eq!((&bytes[16..20], json % 4), (&b"JSON"[..], 0));
    let text = &bytes[20..20 + json];
    if 20 + json == bytes.len() {
        return (serde_json::from_slice(text).unwrap(), Vec::new());
    }
    let binary = word(20 + json);
    assert_eq!((&bytes[24 + json..28 + json], binary % 4), (&b"BIN\0"[..], 0));
    assert_eq!(28 + json + binary, bytes.len());
    (serde_json::from_slice(text).unwrap(), bytes[28 + json..].to_vec())
}

fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json.get(key).map_or(&[], |v| v.as_array().unwrap())
}

fn number(v: &Value) -> usize {
    v.as_u64().unwrap_or_else(|| panic!("{v}")) as usize
}

/// Checks all rules that could be violated.
fn check(bytes: &[u8], what: &str) {
    let (json, binary) = split(bytes);
    // No list is empty.
    for key in [
        "nodes",
        "meshes",
        "materials",
        "textures",
        "images",
        "samplers",
        "cameras",
        "accessors",
        "bufferViews",
    ] {
        assert!(json.get(key).is_none_or(|v| !v.as_array().unwrap().is_empty()), "{what}: {key}");
    }
    let views = check_views(&json, &binary, what);
    let mut file = File { what, binary: &binary, views, used_views: vec![false; views.len()] };
    let used_accessors = file.accessors(&json);
    file.meshes(&json, used_accessors);
    file.images(&json);
    assert!(file.used_views.iter().all(|u| *u), "{what}: an unused buffer view");
    check_materials(&json, what);
    check_nodes(&json, what);
    for camera in list(&json, "cameras").iter().filter_map(|c| c.get("perspective")) {
        assert!(camera["znear"].as_f64().unwrap() > 0.0 && camera["yfov"].as_f64().unwrap() > 0.0);
    }
    // Used extensions are declared, and declared ones are used.
    let mut found = std::collections::BTreeSet::new();
    collect_extensions(&json, &mut found);
    let declared: std::collections::BTreeSet<String> =
        list(&json, "extensionsUsed").iter().map(|v| v.as_str().unwrap().to_owned()).collect();
    assert_eq!(found, declared, "{what}");
}

/// Buffer views are consecutive, aligned, and within the buffer.
fn check_views<'a>(json: &'a Value, binary: &[u8], what: &str) -> &'a [Value] {
    let views = list(json, "bufferViews");
    let mut end = 0;
    for view in views {
        let (offset, length) = range(view);
        assert!(
            offset % 4 == 0 && offset >= end && length > 0 && offset + length <= binary.len(),
            "{what}: {view}"
        );
        end = offset + length;
    }
    views
}

/// Offset and length of a buffer view.
fn range(view: &Value) -> (usize, usize) {
    (number(&view["byteOffset"]), number(&view["byteLength"]))
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

/// The file being checked, and which parts are used.
struct File<'a> {
    what: &'a str,
    binary: &'a [u8],
    views: &'a [Value],
    used_views: Vec<bool>,
}

impl<'a> File<'a> {
    fn bytes(&self, view: &Value) -> &'a [u8] {
        let (offset, length) = range(view);
        &self.binary[offset..offset + length]
    }

    /// Checks sizes, finite values and bounds; returns a flag per accessor for whether it is used.
    fn accessors(&mut self, json: &Value) -> Vec<bool> {
        let what = self.what;
        let accessors = list(json, "accessors");
        for accessor in accessors {
            let view = number(&accessor["bufferView"]);
            self.used_views[view] = true;
            let bytes = self.bytes(&self.views[view]);
            let count = number(&accessor["count"]);
            let width = match accessor["type"].as_str().unwrap() {
                "SCALAR" => 1,
                "VEC2" => 2,
                "VEC3" => 3,
                _ => 4,
            };
            assert!(count > 0 && count * width * 4 == bytes.len(), "{what}: {accessor}");
            if accessor["componentType"] != 5126 {
                continue;
            }
            let floats = floats(bytes);
            assert!(floats.iter().all(|v| v.is_finite()), "{what}: {accessor}");
            for k in 0..width {
                let column = || floats.iter().skip(k).step_by(width).copied();
                if let Some(min) = accessor.get("min") {
                    let (min, max) =
                        (min[k].as_f64().unwrap() as f32, accessor["max"][k].as_f64().unwrap() as f32);
                    assert_eq!(
                        (min, max),
                        (column().fold(f32::INFINITY, f32::min), column().fold(f32::NEG_INFINITY, f32::max))
                    );
                }
            }
        }
        vec![false; accessors.len()]
    }

    /// All accessors and materials are used, by meshes that have the required attributes.
    fn meshes(&self, json: &Value, mut used_accessors: Vec<bool>) {
        let (accessors, materials) = (list(json, "accessors"), list(json, "materials"));
        let mut used_materials = vec![false; materials.len()];
        for primitive in list(json, "meshes").iter().flat_map(|mesh| list(mesh, "primitives")) {
            let vertices = self.attributes(primitive, accessors, &mut used_accessors);
            if let Some(indices) = primitive.get("indices") {
                used_accessors[number(indices)] = true;
                let view = &self.views[number(&accessors[number(indices)]["bufferView"])];
                assert_eq!(view["target"], 34963);
                let mut corners =
                    self.bytes(view).chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap()));
                assert!(corners.all(|i| (i as usize) < vertices));
            }
            let material = number(&primitive["material"]);
            used_materials[material] = true;
            // Every texture has its UV set.
            let text = materials[material].to_string();
            for set in 0..9 {
                let asked = if set == 0 {
                    text.contains("\"index\"") && !text.contains("\"texCoord\"")
                } else {
                    text.contains(&format!("\"texCoord\":{set}"))
                };
                let there = primitive["attributes"].get(format!("TEXCOORD_{set}")).is_some();
                assert!(!asked || there, "{}: {text}", self.what);
            }
        }
        let all = used_materials.iter().chain(&used_accessors).all(|used| *used);
        assert!(all, "{}: something is unused", self.what);
    }

    /// Checks attributes for equal lengths and unit normals; returns the number of vertices.
    fn attributes(&self, primitive: &Value, accessors: &[Value], used: &mut [bool]) -> usize {
        let what = self.what;
        let attributes = primitive["attributes"].as_object().unwrap();
        let count = |i: usize| number(&accessors[i]["count"]);
        let positions = number(&attributes["POSITION"]);
        let vertices = count(positions);
        assert!(accessors[positions].get("min").is_some(), "{what}: bounds of positions");
        for (name, index) in attributes {
            used[number(index)] = true;
            let view = &self.views[number(&accessors[number(index)]["bufferView"])];
            assert_eq!(
                (count(number(index)), &view["target"]),
                (vertices, &Value::from(34962)),
                "{what}: {name}"
            );
            if name == "NORMAL" || name == "TANGENT" {
                let width = if name == "NORMAL" { 3 } else { 4 };
                for v in floats(self.bytes(view)).chunks(width) {
                    let size = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
                    let unit = (size - 1.0).abs() < 5e-4 && (width == 3 || v[3].abs() == 1.0);
                    assert!(unit, "{what}: {name} {v:?}");
                }
            }
        }
        vertices
    }

    fn images(&mut self, json: &Value) {
        for image in list(json, "images") {
            let view = number(&image["bufferView"]);
            self.used_views[view] = true;
            let is_png = self.bytes(&self.views[view]).starts_with(b"\x89PNG");
            assert_eq!(image["mimeType"], if is_png { "image/png" } else { "image/jpeg" }, "{}", self.what);
        }
    }
}

/// Checks the ranges of values.
fn check_materials(json: &Value, what: &str) {
    for material in list(json, "materials") {
        let pbr = &material["pbrMetallicRoughness"];
        let factors = ["metallicFactor", "roughnessFactor"].map(|k| pbr[k].as_f64().unwrap());
        let lists = [&pbr["baseColorFactor"], &material["emissiveFactor"]]
            .map(|l| l.as_array().cloned().unwrap_or_default());
        let colors = lists.iter().flatten().map(|v| v.as_f64().unwrap());
        assert!(factors.into_iter().chain(colors).all(|v| (0.0..=1.0).contains(&v)), "{what}: {material}");
    }
}

/// Every node has one parent or is a root; rotations have unit length.
fn check_nodes(json: &Value, what: &str) {
    let nodes = list(json, "nodes");
    let mut parents = vec![0; nodes.len()];
    let roots = json["scenes"][0].get("nodes").map_or(&[][..], |n| n.as_array().unwrap());
    nodes.iter().flat_map(|n| list(n, "children")).chain(roots).for_each(|n| parents[number(n)] += 1);
    assert!(parents.iter().all(|n| *n == 1), "{what}: nodes and their parents");
    for node in nodes {
        if let Some(q) = node.get("rotation") {
            let size: f64 = q.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).map(|v| v * v).sum();
            assert!((size - 1.0).abs() < 1e-9, "{what}: {q}");
        }
        if let Some(scale) = node.get("scale") {
            assert!(scale.as_array().unwrap().iter().all(|v| v.as_f64().unwrap() != 0.0), "{what}");
        }
    }
}

fn collect_extensions(json: &Value, found: &mut std::collections::BTreeSet<String>) {
    match json {
        Value::Object(map) => {
            if let Some(Value::Object(extensions)) = map.get("extensions") {
                found.extend(extensions.keys().cloned());
            }
            map.values().for_each(|v| collect_extensions(v, found));
        }
        Value::Array(items) => items.iter().for_each(|v| collect_extensions(v, found)),
        _ => {}
    }
}

/// Writes a scene and reads it back.
fn there_and_back(desc: &SceneDesc, options: &ConvertOptions, what: &str) -> SceneDesc {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.glb");
    to_glb(desc, &out, options).unwrap_or_else(|e| panic!("{what}: {e}"));
    check(&std::fs::read(&out).unwrap(), what);
    load(&out, &LoadOptions::default()).unwrap_or_else(|e| panic!("{what}: {}", e.error)).desc
}

#[test]
fn scenes_and_models_keep_the_rules_and_their_sizes() {
    let mut checked = 0;
    for path in [
        "scenes/showcase/material-balls.toml",
        "scenes/showcase/cornell-box.toml",
        "scenes/showcase/glass-still-life.toml",
        "scenes/showcase/product.toml",
        "scenes/showcase/smoke.toml",
        "scenes/textures/mappings.toml",
        "scenes/temple.toml",
        "scenes/still-life.toml",
        "scenes/classic/002-13-thirty-spheres.toml",
        "scenes/peers/interior.toml",
        "crates/turner-io/tests/assets/gltf/Fox.glb",
    ] {
        let (desc, options) = loaded(&root(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
        let again = there_and_back(&desc, &options, path);
        let bounds = |desc: &SceneDesc| {
            let mut desc = desc.clone();
            // Infinite planes become squares, which have bounds; nothing else is added.
            desc.studio = None;
            let is_plane = |o: &turner::description::ObjectDesc| {
                matches!(
                    &o.content,
                    turner::description::ObjectContent::Shape(turner::shape::ShapeDesc::Plane(_))
                )
            };
            if desc.objects.iter().any(is_plane) {
                return None;
            }
            desc.prepare(&PrepareOptions::default()).unwrap().scene.stats.bounds
        };
        let [before, after] = [bounds(&desc), bounds(&again)];
        if let (Some(a), Some(b)) = (before, after) {
            let size = a.size().max_element();
            let off = (a.min - b.min).abs().max_element().max((a.max - b.max).abs().max_element());
            assert!(off < 2e-3 * size, "{path}: {a:?} is not {b:?}");
            checked += 1;
        }
    }
    assert!(checked >= 3, "{checked}");
}

#[test]
fn every_gltf_asset_is_written_within_the_rules() {
    let folder = root("crates/turner-io/tests/assets/gltf");
    let mut count = 0;
    let mut stack = vec![folder];
    while let Some(folder) = stack.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if path.is_dir() {
                stack.push(path);
            } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
                let Ok((desc, options)) = loaded(&path) else { continue };
                let what = path.display().to_string();
                let again = there_and_back(&desc, &options, &what);
                // Scenes imported from glTF lose nothing of their materials and lights.
                assert_eq!(again.lights.len(), desc.lights.len(), "{what}");
                count += 1;
            }
        }
    }
    assert!(count >= 3, "{count}");
}

#[test]
fn what_cannot_be_held_is_said_and_refused_if_asked() {
    let (desc, options) = loaded(&root("scenes/showcase/smoke.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.glb");
    let converted = to_glb(&desc, &out, &options).unwrap();
    assert!(converted.warnings.iter().any(|w| w.message.contains("media")), "{:?}", converted.warnings);
    assert_eq!(to_glb(&desc, &out, &options).unwrap_err().code.as_str(), "E0401");
    let strict = ConvertOptions { strict: true, overwrite: true, ..options };
    assert_eq!(to_glb(&desc, &out, &strict).unwrap_err().code.as_str(), "E0501");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// Angles are in degrees in scenes and in radians in glTF.
#[test]
fn directions_of_anisotropy_keep_their_unit() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (folder.path().join("s.toml"), folder.path().join("s.glb"));
    let text = "[material.m]\ntype = \"principled\"\nspecular_roughness_anisotropy = 0.5\nanisotropy_rotation = 30\n\
                [[object]]\ntype = \"sphere\"\nmaterial = \"m\"\n";
    std::fs::write(&scene, text).unwrap();
    let (desc, options) = loaded(&scene).unwrap();
    to_glb(&desc, &out, &options).unwrap();
    let (json, _) = split(&std::fs::read(&out).unwrap());
    let x = &list(&json, "materials")[0]["extensions"]["KHR_materials_anisotropy"];
    let angle = x["anisotropyRotation"].as_f64().unwrap();
    assert!((angle - std::f64::consts::FRAC_PI_6).abs() < 1e-15, "{x}");
    // Read back.
    let back = load(&out, &LoadOptions::default()).unwrap().desc;
    let found = back.materials.iter().find_map(|m| match &m.value {
        MaterialDesc::Principled(m) => Some(m.anisotropy_rotation),
        _ => None,
    });
    assert_eq!(found, Some(30.0));
}
