//! A tree of the classic integrator as JSON.

use serde::Serialize;
use turner::integrator::classic::{
    Caster, CutRecord, HitRecord, LightTerm, RayEnd, RayRecord, ShadowRecord, TreeRecord,
};

use super::json::{Material, Object, color, material, object, vector};
use super::names::Names;

#[derive(Serialize)]
pub(super) struct Tree<'a> {
    rays: Vec<Ray<'a>>,
    unwritten_rays: u64,
    dropped_rays: u64,
}

pub(super) fn of<'a>(names: &Names<'a>, tree: &'a TreeRecord) -> Tree<'a> {
    Tree {
        rays: tree.rays.iter().map(|r| ray(names, r)).collect(),
        unwritten_rays: tree.unwritten,
        dropped_rays: tree.dropped,
    }
}

#[derive(Serialize)]
struct Ray<'a> {
    kind: &'a str,
    parent: Option<u32>,
    depth: u32,
    origin: [f64; 3],
    direction: [f64; 3],
    weight: f64,
    hit: Option<Hit<'a>>,
    miss: Option<Miss<'a>>,
}

#[derive(Serialize)]
struct Miss<'a> {
    seen: &'a str,
    contribution: [f64; 3],
}

fn ray<'a>(names: &Names<'a>, r: &'a RayRecord) -> Ray<'a> {
    let (hit, miss) = match &r.end {
        RayEnd::Hit(h) => (Some(hit(names, h)), None),
        RayEnd::Miss(m) => (None, Some(Miss { seen: m.seen.word(), contribution: color(m.contribution) })),
    };
    Ray {
        kind: r.kind.word(),
        parent: r.parent,
        depth: r.depth,
        origin: vector(r.origin),
        direction: vector(r.direction),
        weight: r.weight,
        hit,
        miss,
    }
}

#[derive(Serialize)]
struct Hit<'a> {
    t: f64,
    position: [f64; 3],
    geometric_normal: [f64; 3],
    shading_normal: [f64; 3],
    normal: [f64; 3],
    object: Object<'a>,
    part: u32,
    uv: [f64; 2],
    material: Material<'a>,
    entering: bool,
    total_internal_reflection: bool,
    color: [f64; 3],
    ka: f64,
    kd: f64,
    ks: f64,
    shininess: f64,
    ior: f64,
    ambient: [f64; 3],
    lights: Vec<Light<'a>>,
    local: [f64; 3],
    k_local: f64,
    k_reflect: f64,
    k_refract: f64,
    emission: Option<[f64; 3]>,
    contribution: Option<[f64; 3]>,
    not_traced: Vec<Cut<'a>>,
}

fn hit<'a>(names: &Names<'a>, h: &'a HitRecord) -> Hit<'a> {
    let [ka, kd, ks] = h.coefficients;
    let [local, reflect, refract] = h.weights;
    Hit {
        t: h.t,
        position: vector(h.p),
        geometric_normal: vector(h.ng),
        shading_normal: vector(h.ns),
        normal: vector(h.n),
        object: object(names, h.primitive, h.shape),
        part: h.part,
        uv: h.uv,
        material: material(names, h.material),
        entering: h.entering,
        total_internal_reflection: h.total_internal_reflection,
        color: color(h.color),
        ka,
        kd,
        ks,
        shininess: h.shininess,
        ior: h.ior,
        ambient: color(h.ambient),
        lights: h.lights.iter().map(|l| light(names, l)).collect(),
        local: color(h.local),
        k_local: local,
        k_reflect: reflect,
        k_refract: refract,
        emission: h.emitted.map(color),
        contribution: h.contribution.map(color),
        not_traced: h.cut.iter().map(cut).collect(),
    }
}

#[derive(Serialize)]
struct Cut<'a> {
    kind: &'a str,
    direction: [f64; 3],
    weight: f64,
    reason: &'a str,
    seen: &'a str,
    contribution: [f64; 3],
}

fn cut(c: &CutRecord) -> Cut<'static> {
    Cut {
        kind: c.kind.word(),
        direction: vector(c.direction),
        weight: c.weight,
        reason: c.reason.word(),
        seen: c.seen.word(),
        contribution: color(c.contribution),
    }
}

#[derive(Serialize)]
struct Light<'a> {
    light: u32,
    name: String,
    point: u32,
    to_light: [f64; 3],
    distance: Option<f64>,
    reaches: bool,
    intensity: [f64; 3],
    n_dot_l: f64,
    r_dot_v: f64,
    diffuse: [f64; 3],
    highlight: [f64; 3],
    shadow: Option<Shadow<'a>>,
    added: [f64; 3],
}

fn light<'a>(names: &Names<'a>, l: &'a LightTerm) -> Light<'a> {
    Light {
        light: l.light,
        name: names.light(l.light),
        point: l.sample,
        to_light: vector(l.to_light),
        distance: l.finite.then(|| l.to_light.length()),
        reaches: l.reaches,
        intensity: color(l.intensity),
        n_dot_l: l.n_dot_l,
        r_dot_v: l.r_dot_v,
        diffuse: color(l.diffuse),
        highlight: color(l.highlight),
        shadow: l.shadow.as_ref().map(|s| shadow(names, s)),
        added: color(l.added),
    }
}

#[derive(Serialize)]
struct Shadow<'a> {
    origin: [f64; 3],
    direction: [f64; 3],
    t_min: f64,
    t_max: f64,
    through: [f64; 3],
    by: Vec<InTheWay<'a>>,
}

fn shadow<'a>(names: &Names<'a>, s: &'a ShadowRecord) -> Shadow<'a> {
    Shadow {
        origin: vector(s.origin),
        direction: vector(s.direction),
        t_min: s.t_min,
        t_max: s.t_max,
        through: color(s.through),
        by: s.casters.iter().map(|c| caster(names, c)).collect(),
    }
}

/// What casts a shadow.
#[derive(Serialize)]
pub(super) struct InTheWay<'a> {
    t: f64,
    object: Object<'a>,
    material: Material<'a>,
}

pub(super) fn caster<'a>(names: &Names<'a>, c: &Caster) -> InTheWay<'a> {
    InTheWay { t: c.t, object: object(names, c.primitive, c.shape), material: material(names, c.material) }
}
