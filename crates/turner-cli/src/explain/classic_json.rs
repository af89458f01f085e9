//! A tree of the classic integrator as JSON.

use serde_json::{Value, json};
use turner::integrator::classic::{
    Caster, CutRecord, HitRecord, LightTerm, RayEnd, RayRecord, ShadowRecord, TreeRecord,
};

use super::json::{color, material, object, vector};
use super::names::Names;

pub(super) fn of(names: &Names<'_>, tree: &TreeRecord) -> Value {
    let rays: Vec<Value> = tree.rays.iter().map(|r| ray(names, r)).collect();
    json!({
        "kind": "tree",
        "rays": rays,
        "unwritten_rays": tree.unwritten,
        "dropped_rays": tree.dropped,
    })
}

fn ray(names: &Names<'_>, r: &RayRecord) -> Value {
    let (hit, miss) = match &r.end {
        RayEnd::Hit(h) => (Some(hit(names, h)), None),
        RayEnd::Miss(m) => {
            (None, Some(json!({ "seen": m.seen.word(), "contribution": color(m.contribution) })))
        }
    };
    json!({
        "kind": r.kind.word(),
        "parent": r.parent,
        "depth": r.depth,
        "origin": vector(r.origin),
        "direction": vector(r.direction),
        "weight": r.weight,
        "hit": hit,
        "miss": miss,
    })
}

fn hit(names: &Names<'_>, h: &HitRecord) -> Value {
    let lights: Vec<Value> = h.lights.iter().map(|l| light(names, l)).collect();
    let cut: Vec<Value> = h.cut.iter().map(cut).collect();
    let [ka, kd, ks] = h.coefficients;
    let [local, reflect, refract] = h.weights;
    json!({
        "t": h.t,
        "position": vector(h.p),
        "geometric_normal": vector(h.ng),
        "shading_normal": vector(h.ns),
        "normal": vector(h.n),
        "object": object(names, h.primitive, h.shape),
        "part": h.part,
        "uv": h.uv,
        "material": material(names, h.material),
        "entering": h.entering,
        "total_internal_reflection": h.total_internal_reflection,
        "color": color(h.color),
        "ka": ka,
        "kd": kd,
        "ks": ks,
        "shininess": h.shininess,
        "ior": h.ior,
        "ambient": color(h.ambient),
        "lights": lights,
        "local": color(h.local),
        "k_local": local,
        "k_reflect": reflect,
        "k_refract": refract,
        "emission": h.emitted.map(color),
        "contribution": h.contribution.map(color),
        "not_traced": cut,
    })
}

fn cut(c: &CutRecord) -> Value {
    json!({
        "kind": c.kind.word(),
        "direction": vector(c.direction),
        "weight": c.weight,
        "reason": c.reason.word(),
        "seen": c.seen.word(),
        "contribution": color(c.contribution),
    })
}

fn light(names: &Names<'_>, l: &LightTerm) -> Value {
    json!({
        "light": l.light,
        "name": names.light(l.light),
        "point": l.sample,
        "to_light": vector(l.to_light),
        "distance": l.finite.then(|| l.to_light.length()),
        "reaches": l.reaches,
        "intensity": color(l.intensity),
        "n_dot_l": l.n_dot_l,
        "r_dot_v": l.r_dot_v,
        "diffuse": color(l.diffuse),
        "highlight": color(l.highlight),
        "shadow": l.shadow.as_ref().map(|s| shadow(names, s)),
        "added": color(l.added),
    })
}

fn shadow(names: &Names<'_>, s: &ShadowRecord) -> Value {
    let by: Vec<Value> = s.casters.iter().map(|c| caster(names, c)).collect();
    json!({
        "origin": vector(s.origin),
        "direction": vector(s.direction),
        "t_min": s.t_min,
        "t_max": s.t_max,
        "through": color(s.through),
        "by": by,
    })
}

pub(super) fn caster(names: &Names<'_>, c: &Caster) -> Value {
    json!({
        "t": c.t,
        "object": object(names, c.primitive, c.shape),
        "material": material(names, c.material),
    })
}
