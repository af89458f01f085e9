//! A path as JSON.

use serde::Serialize;
use turner::integrator::path::{
    AroundRecord, EmissionRecord, EscapeRecord, LentRecord, LightRecord, Passage, PathRecord, PhotonsRecord,
    ScatterRecord, SharedRecord, VertexRecord, WalkRecord, WayRecord,
};

use super::classic_json::{InTheWay, caster};
use super::json::{Material, Object, color, material, object, vector};
use super::names::Names;

#[derive(Serialize)]
pub(super) struct Path<'a> {
    camera: Camera,
    vertices: Vec<Vertex<'a>>,
    escape: Option<Escape<'a>>,
    end: &'a str,
    shared: Option<Shared>,
}

/// What the sample's group shares with it.
#[derive(Serialize)]
struct Shared {
    from: Option<usize>,
    paths: Vec<Lent>,
}

#[derive(Serialize)]
struct Lent {
    pixel: [u32; 2],
    position: [f64; 3],
    radiance: [f64; 3],
    share: [f64; 3],
    contribution: [f64; 3],
}

#[derive(Serialize)]
struct Camera {
    origin: [f64; 3],
    direction: [f64; 3],
    time: f64,
}

pub(super) fn of<'a>(names: &Names<'a>, path: &'a PathRecord) -> Path<'a> {
    Path {
        camera: Camera {
            origin: vector(path.origin),
            direction: vector(path.direction),
            time: f64::from(path.time),
        },
        vertices: path.vertices.iter().map(|v| vertex(names, v)).collect(),
        escape: path.escape.as_ref().map(|e| escape(names, e)),
        end: path.end.word(),
        shared: path.shared.as_ref().map(shared),
    }
}

fn shared(s: &SharedRecord) -> Shared {
    let lent = |p: &LentRecord| Lent {
        pixel: [p.id.x, p.id.y],
        position: vector(p.p),
        radiance: color(p.radiance),
        share: color(p.share),
        contribution: color(p.contribution),
    };
    Shared { from: s.from, paths: s.parts.iter().map(lent).collect() }
}

#[derive(Serialize)]
struct Way<'a> {
    inside: Option<Material<'a>>,
    length: f64,
    weight: [f64; 3],
    emission: Option<[f64; 3]>,
    second: Option<Second<'a>>,
}

#[derive(Serialize)]
struct Second<'a> {
    t: f64,
    light: Light<'a>,
}

fn way<'a>(names: &Names<'a>, w: &'a WayRecord) -> Way<'a> {
    Way {
        inside: w.solid.map(|id| material(names, id)),
        length: w.length,
        weight: color(w.weight),
        emission: w.emission.map(color),
        second: w.second.as_ref().map(|(t, l)| Second { t: *t, light: light(names, l) }),
    }
}

#[derive(Serialize)]
struct Vertex<'a> {
    way: Option<Way<'a>>,
    origin: [f64; 3],
    direction: [f64; 3],
    t: f64,
    position: [f64; 3],
    /// Places in a medium have none.
    #[serde(flatten)]
    surface: Option<Surface<'a>>,
    inside: Vec<Material<'a>>,
    transmittance: Option<[f64; 3]>,
    throughput: [f64; 3],
    passage: &'a str,
    band: Option<u8>,
    light: Option<Light<'a>>,
    scatter: Option<Scatter>,
}

/// What only surfaces have.
#[derive(Serialize)]
struct Surface<'a> {
    geometric_normal: [f64; 3],
    shading_normal: [f64; 3],
    object: Object<'a>,
    part: u32,
    uv: [f64; 2],
    material: Material<'a>,
    chosen: Option<Material<'a>>,
    outside: bool,
    walk: Option<Walk>,
    emission: Option<Emission>,
    photons: Option<Photons>,
    ior_around: Option<f64>,
    dispersed: Option<[f64; 3]>,
}

fn vertex<'a>(names: &Names<'a>, v: &'a VertexRecord) -> Vertex<'a> {
    let surface = (v.passage != Passage::Medium).then(|| Surface {
        geometric_normal: vector(v.ng),
        shading_normal: vector(v.ns),
        object: object(names, v.primitive, v.shape),
        part: v.part,
        uv: v.uv,
        material: material(names, v.material),
        chosen: v.chosen.map(|id| material(names, id)),
        outside: v.outside,
        walk: v.walk.as_ref().map(walk),
        emission: v.emission.as_ref().map(emission),
        photons: v.photons.as_ref().map(photons),
        ior_around: v.ior_around,
        dispersed: v.dispersed.map(color),
    });
    Vertex {
        way: v.way.as_ref().map(|w| way(names, w)),
        origin: vector(v.origin),
        direction: vector(v.direction),
        t: v.t,
        position: vector(v.p),
        surface,
        inside: v.inside.iter().map(|&id| material(names, id)).collect(),
        transmittance: v.transmittance.map(color),
        throughput: color(v.throughput),
        passage: v.passage.word(),
        band: v.band,
        light: v.light.as_ref().map(|l| light(names, l)),
        scatter: v.scatter.as_ref().map(scatter),
    }
}

#[derive(Serialize)]
struct Walk {
    steps: u32,
    length: f64,
    weight: [f64; 3],
}

fn walk(w: &WalkRecord) -> Walk {
    Walk { steps: w.steps, length: w.length, weight: color(w.weight) }
}

#[derive(Serialize)]
struct Photons {
    radius: f64,
    count: u32,
    radiance: [f64; 3],
    contribution: [f64; 3],
}

fn photons(p: &PhotonsRecord) -> Photons {
    Photons {
        radius: p.radius,
        count: p.count,
        radiance: color(p.radiance),
        contribution: color(p.contribution),
    }
}

#[derive(Serialize)]
struct Emission {
    radiance: [f64; 3],
    pdf: Option<f64>,
    light_pdf: f64,
    mis_weight: f64,
    contribution: [f64; 3],
}

fn emission(e: &EmissionRecord) -> Emission {
    Emission {
        radiance: color(e.radiance),
        pdf: e.pdf,
        light_pdf: e.light_pdf,
        mis_weight: e.weight,
        contribution: color(e.contribution),
    }
}

#[derive(Serialize)]
struct Light<'a> {
    direction: [f64; 3],
    distance: f64,
    pdf: f64,
    delta: bool,
    radiance: [f64; 3],
    bsdf: [f64; 3],
    bsdf_pdf: f64,
    cosine: f64,
    mis_weight: f64,
    candidates: u32,
    counts: f64,
    transmittance: Option<[f64; 3]>,
    unshadowed: [f64; 3],
    visible: Option<[f64; 3]>,
    by: Vec<InTheWay<'a>>,
    contribution: [f64; 3],
}

fn light<'a>(names: &Names<'a>, l: &'a LightRecord) -> Light<'a> {
    Light {
        direction: vector(l.direction),
        distance: l.distance,
        pdf: l.pdf,
        delta: l.is_delta,
        radiance: color(l.radiance),
        bsdf: color(l.bsdf),
        bsdf_pdf: l.bsdf_pdf,
        cosine: l.cosine,
        mis_weight: l.weight,
        candidates: l.candidates,
        counts: f64::from(l.counts),
        transmittance: l.transmittance.map(color),
        unshadowed: color(l.unshadowed),
        visible: l.visible.map(color),
        by: l.casters.iter().map(|c| caster(names, c)).collect(),
        contribution: color(l.contribution),
    }
}

#[derive(Serialize)]
struct Scatter {
    direction: [f64; 3],
    lobe: Lobe,
    bsdf: [f64; 3],
    pdf: f64,
    cosine: f64,
    eta: f64,
    terminator: f64,
    weight: [f64; 3],
    roulette: Option<Roulette>,
    throughput: [f64; 3],
}

#[derive(Serialize)]
struct Lobe {
    delta: bool,
    transmission: bool,
    diffuse: bool,
}

#[derive(Serialize)]
struct Roulette {
    survival: f64,
    number: f64,
}

fn scatter(s: &ScatterRecord) -> Scatter {
    let turner::bsdf::Lobe { is_delta, is_transmission, is_diffuse } = s.lobe;
    Scatter {
        direction: vector(s.direction),
        lobe: Lobe { delta: is_delta, transmission: is_transmission, diffuse: is_diffuse },
        bsdf: color(s.bsdf),
        pdf: s.pdf,
        cosine: s.cosine,
        eta: s.eta,
        terminator: s.terminator,
        weight: color(s.weight),
        roulette: s.roulette.map(|r| Roulette { survival: r.survival, number: r.number }),
        throughput: color(s.throughput),
    }
}

#[derive(Serialize)]
struct Escape<'a> {
    way: Option<Way<'a>>,
    origin: [f64; 3],
    direction: [f64; 3],
    transmittance: Option<[f64; 3]>,
    throughput: [f64; 3],
    pdf: Option<f64>,
    lights: Vec<Around>,
    background: [f64; 3],
    ambient: [f64; 3],
    contribution: [f64; 3],
}

/// A light around the scene.
#[derive(Serialize)]
struct Around {
    radiance: [f64; 3],
    light_pdf: f64,
    mis_weight: f64,
}

fn around(l: &AroundRecord) -> Around {
    Around { radiance: color(l.radiance), light_pdf: l.light_pdf, mis_weight: l.weight }
}

fn escape<'a>(names: &Names<'a>, e: &'a EscapeRecord) -> Escape<'a> {
    Escape {
        way: e.way.as_ref().map(|w| way(names, w)),
        origin: vector(e.origin),
        direction: vector(e.direction),
        transmittance: e.transmittance.map(color),
        throughput: color(e.throughput),
        pdf: e.pdf,
        lights: e.lights.iter().map(around).collect(),
        background: color(e.background),
        ambient: color(e.ambient),
        contribution: color(e.contribution),
    }
}
