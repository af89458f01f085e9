//! An explanation as JSON, documented in docs/explain.md: numbers in full, what is infinite or not there as null.

use serde_json::{Value, json};
use turner::color::Spectrum;
use turner::math::DVec3;
use turner::scene::MaterialId;

use super::names::Names;
use super::samples::{Explained, Record};
use super::{classic_json, path_json};

/// Changes when a key changes its meaning or goes away; new keys may come at any time.
const VERSION: u32 = 1;

pub(super) fn color(s: Spectrum) -> [f32; 3] {
    s.to_array()
}

pub(super) fn vector(v: DVec3) -> [f64; 3] {
    v.to_array()
}

/// A material: its number and name.
pub(super) fn material(names: &Names<'_>, id: MaterialId) -> Value {
    json!({ "id": id.0, "name": names.material_name(id) })
}

/// An object: the number of its primitive, its shape and its name, and the instance that placed it.
pub(super) fn object(names: &Names<'_>, primitive: u32, shape: &str) -> Value {
    let name = names.scene.object_name(primitive);
    json!({ "primitive": primitive, "shape": shape, "name": name.own, "instance": name.instance })
}

pub(super) fn of(explained: &Explained<'_>, hash: &str) -> Value {
    let Explained { names, explanation: e, records } = explained;
    let samples: Vec<Value> = e
        .pixel
        .samples
        .iter()
        .map(|s| {
            let radiance = s.radiance;
            json!({
                "place": s.place,
                "share": s.weight,
                "color": color(radiance.color),
                "alpha": radiance.alpha,
            })
        })
        .collect();
    let squares: Vec<Value> = e
        .pixel
        .squares
        .iter()
        .map(|s| json!({ "corner": s.corner, "size": s.size, "spread": s.spread }))
        .collect();
    let each: Vec<Value> = e
        .trees
        .iter()
        .zip(records)
        .map(|(tree, record)| {
            let mut out = match record {
                Record::Tree(record) => classic_json::of(names, record),
                Record::Path(record) => path_json::of(names, record),
                Record::Other => first_hit(names, tree),
            };
            if let Some(map) = out.as_object_mut() {
                map.insert("sample".into(), json!(tree.number));
                map.insert("place".into(), json!(tree.sample.place));
                map.insert("sum".into(), json!(color(tree.sum)));
                map.insert("rendered".into(), json!(color(tree.sample.radiance.color)));
                map.insert("alpha".into(), json!(tree.sample.radiance.alpha));
                map.insert("exact".into(), json!(tree.is_exact()));
                if e.path_of.is_some() {
                    map.insert("touches".into(), json!(tree.nodes.iter().any(|n| n.touches)));
                }
            }
            out
        })
        .collect();
    json!({
        "format": "turner-explanation",
        "version": VERSION,
        "turner": env!("CARGO_PKG_VERSION"),
        "scene": e.scene,
        "scene_hash": hash,
        "integrator": e.integrator,
        "seed": e.seed,
        "size": e.size,
        "pixel": [e.pixel.x, e.pixel.y],
        "color": color(e.color()),
        "alpha": e.pixel.color[3],
        "antialias": names.scene.film.antialias.word(),
        "sample_count": e.pixel.count,
        "samples": samples,
        "squares": squares,
        "path_of": e.path_of,
        "explained": each,
        "exact": e.is_exact(),
    })
}

/// What integrators for looking at things show: the first hit.
fn first_hit(names: &Names<'_>, tree: &super::model::SampleTree) -> Value {
    let camera =
        tree.nodes.first().map(|n| json!({ "origin": vector(n.from), "direction": vector(n.direction) }));
    let hit = tree.nodes.first().and_then(|n| {
        let ray = turner::render::camera_ray(names.scene, tree.sample.id, tree.sample.place)?;
        let hit = names.scene.intersect(&ray)?;
        let surface = names.scene.surface(&ray, &hit);
        Some(json!({
            "t": hit.shape.t,
            "position": n.to.map(vector),
            "geometric_normal": vector(surface.ng),
            "shading_normal": vector(surface.ns),
            "object": object(names, names.scene.primitive_id(&hit), names.scene.shape_word(&hit)),
            "material": material(names, surface.material),
        }))
    });
    json!({ "kind": "first-hit", "camera": camera, "hit": hit })
}
