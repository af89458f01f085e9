//! A path as JSON.

use serde_json::{Value, json};
use turner::bsdf::Lobe;
use turner::integrator::path::{
    AroundRecord, EmissionRecord, EscapeRecord, LentRecord, LightRecord, Passage, PathRecord, ScatterRecord,
    SharedRecord, VertexRecord, WayRecord,
};

use super::classic_json::caster;
use super::json::{color, material, object, vector};
use super::names::Names;

pub(super) fn of(names: &Names<'_>, path: &PathRecord) -> Value {
    let vertices: Vec<Value> = path.vertices.iter().map(|v| vertex(names, v)).collect();
    json!({
        "kind": "path",
        "camera": {
            "origin": vector(path.origin),
            "direction": vector(path.direction),
            "time": path.time,
        },
        "vertices": vertices,
        "escape": path.escape.as_ref().map(|e| escape(names, e)),
        "end": path.end.word(),
        "shared": path.shared.as_ref().map(shared),
    })
}

fn shared(s: &SharedRecord) -> Value {
    let part = |p: &LentRecord| {
        json!({
            "pixel": [p.id.x, p.id.y],
            "position": vector(p.p),
            "radiance": color(p.radiance),
            "share": color(p.share),
            "contribution": color(p.contribution),
        })
    };
    json!({ "from": s.from, "paths": s.parts.iter().map(part).collect::<Vec<Value>>() })
}

fn way(names: &Names<'_>, w: &WayRecord) -> Value {
    json!({
        "inside": w.solid.map(|id| material(names, id)),
        "length": w.length,
        "weight": color(w.weight),
        "emission": w.emission.map(color),
        "second": w.second.as_ref().map(|(t, l)| json!({ "t": t, "light": light(names, l) })),
    })
}

fn vertex(names: &Names<'_>, v: &VertexRecord) -> Value {
    let inside: Vec<Value> = v.inside.iter().map(|&id| material(names, id)).collect();
    if v.passage == Passage::Medium {
        return json!({
            "way": v.way.as_ref().map(|w| way(names, w)),
            "origin": vector(v.origin),
            "direction": vector(v.direction),
            "t": v.t,
            "position": vector(v.p),
            "inside": inside,
            "transmittance": v.transmittance.map(color),
            "throughput": color(v.throughput),
            "passage": v.passage.word(),
            "band": v.band,
            "light": v.light.as_ref().map(|l| light(names, l)),
            "scatter": v.scatter.as_ref().map(scatter),
        });
    }
    json!({
        "way": v.way.as_ref().map(|w| way(names, w)),
        "origin": vector(v.origin),
        "direction": vector(v.direction),
        "t": v.t,
        "position": vector(v.p),
        "geometric_normal": vector(v.ng),
        "shading_normal": vector(v.ns),
        "object": object(names, v.primitive, v.shape),
        "part": v.part,
        "uv": v.uv,
        "material": material(names, v.material),
        "chosen": v.chosen.map(|id| material(names, id)),
        "outside": v.outside,
        "inside": inside,
        "transmittance": v.transmittance.map(color),
        "throughput": color(v.throughput),
        "passage": v.passage.word(),
        "walk": v.walk.map(|w| json!({ "steps": w.steps, "length": w.length, "weight": color(w.weight) })),
        "emission": v.emission.as_ref().map(emission),
        "photons": v.photons.as_ref().map(|p| json!({
            "radius": p.radius,
            "count": p.count,
            "radiance": color(p.radiance),
            "contribution": color(p.contribution),
        })),
        "ior_around": v.ior_around,
        "band": v.band,
        "dispersed": v.dispersed.map(color),
        "light": v.light.as_ref().map(|l| light(names, l)),
        "scatter": v.scatter.as_ref().map(scatter),
    })
}

fn emission(e: &EmissionRecord) -> Value {
    json!({
        "radiance": color(e.radiance),
        "pdf": e.pdf,
        "light_pdf": e.light_pdf,
        "mis_weight": e.weight,
        "contribution": color(e.contribution),
    })
}

fn light(names: &Names<'_>, l: &LightRecord) -> Value {
    let by: Vec<Value> = l.casters.iter().map(|c| caster(names, c)).collect();
    json!({
        "direction": vector(l.direction),
        "distance": l.distance,
        "pdf": l.pdf,
        "delta": l.is_delta,
        "radiance": color(l.radiance),
        "bsdf": color(l.bsdf),
        "bsdf_pdf": l.bsdf_pdf,
        "cosine": l.cosine,
        "mis_weight": l.weight,
        "transmittance": l.transmittance.map(color),
        "unshadowed": color(l.unshadowed),
        "visible": l.visible.map(color),
        "by": by,
        "contribution": color(l.contribution),
    })
}

fn scatter(s: &ScatterRecord) -> Value {
    let Lobe { is_delta, is_transmission, is_diffuse } = s.lobe;
    json!({
        "direction": vector(s.direction),
        "lobe": { "delta": is_delta, "transmission": is_transmission, "diffuse": is_diffuse },
        "bsdf": color(s.bsdf),
        "pdf": s.pdf,
        "cosine": s.cosine,
        "eta": s.eta,
        "terminator": s.terminator,
        "weight": color(s.weight),
        "roulette": s.roulette.map(|r| json!({ "survival": r.survival, "number": r.number })),
        "throughput": color(s.throughput),
    })
}

fn escape(names: &Names<'_>, e: &EscapeRecord) -> Value {
    let around = |l: &AroundRecord| json!({ "radiance": color(l.radiance), "light_pdf": l.light_pdf, "mis_weight": l.weight });
    let lights: Vec<Value> = e.lights.iter().map(around).collect();
    json!({
        "way": e.way.as_ref().map(|w| way(names, w)),
        "origin": vector(e.origin),
        "direction": vector(e.direction),
        "transmittance": e.transmittance.map(color),
        "throughput": color(e.throughput),
        "pdf": e.pdf,
        "lights": lights,
        "background": color(e.background),
        "ambient": color(e.ambient),
        "contribution": color(e.contribution),
    })
}
