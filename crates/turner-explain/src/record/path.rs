//! The record of a sample of the path tracer: its path, as JSON has it.

use serde::Serialize;
use turner::color::Spectrum;
use turner::integrator::path::{
    DonorRecord, EmissionRecord, End, EscapeRecord, InfiniteLightRecord, LightRecord, MediumSegmentRecord,
    Passage, PathRecord, PhotonsRecord, RandomWalkRecord, ScatterRecord, SharedRecord, VertexRecord,
};
use turner::math::DVec3;

use super::classic::Occluder;
use super::{Material, Object, plain};
use turner::explain::Names;

#[derive(Serialize)]
pub(crate) struct Path<'a> {
    pub(crate) camera: Camera,
    pub(crate) vertices: Vec<Vertex<'a>>,
    pub(crate) escape: Option<Escape<'a>>,
    #[serde(serialize_with = "plain")]
    pub(crate) end: End,
    pub(crate) shared: Option<Shared>,
}

/// Shared paths that contribute to the sample.
#[derive(Serialize)]
pub(crate) struct Shared {
    pub(crate) from: Option<usize>,
    pub(crate) until: Option<usize>,
    pub(crate) paths: Vec<Donated>,
}

#[derive(Serialize)]
pub(crate) struct Donated {
    pub(crate) pixel: [u32; 2],
    #[serde(serialize_with = "plain")]
    pub(crate) position: DVec3,
    /// "radiance", "direct" or "next".
    pub(crate) part: &'static str,
    #[serde(serialize_with = "plain")]
    pub(crate) radiance: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) weight: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Spectrum,
}

#[derive(Serialize)]
pub(crate) struct Camera {
    #[serde(serialize_with = "plain")]
    pub(crate) origin: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    pub(crate) time: f64,
}

pub(crate) fn of<'a>(names: &Names<'a>, path: &PathRecord) -> Path<'a> {
    Path {
        camera: Camera { origin: path.origin, direction: path.direction, time: f64::from(path.time) },
        vertices: path.vertices.iter().map(|v| vertex(names, v)).collect(),
        escape: path.escape.as_ref().map(|e| escape(names, e)),
        end: path.end,
        shared: path.shared.as_ref().map(shared),
    }
}

fn shared(s: &SharedRecord) -> Shared {
    let donated = |p: &DonorRecord| Donated {
        pixel: [p.id.x, p.id.y],
        position: p.p,
        part: p.part.word(),
        radiance: p.radiance,
        weight: p.share,
        contribution: p.contribution,
    };
    Shared { from: s.from, until: s.until, paths: s.parts.iter().map(donated).collect() }
}

#[derive(Serialize)]
pub(crate) struct MediumSegment<'a> {
    /// The solid that holds the medium; `None` for the medium of the scene.
    pub(crate) solid: Option<Material<'a>>,
    pub(crate) length: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) weight: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) emission: Option<Spectrum>,
    pub(crate) equiangular: Option<Equiangular<'a>>,
}

#[derive(Serialize)]
pub(crate) struct Equiangular<'a> {
    pub(crate) t: f64,
    pub(crate) light: Light<'a>,
}

fn medium_segment<'a>(names: &Names<'a>, w: &MediumSegmentRecord) -> MediumSegment<'a> {
    MediumSegment {
        solid: w.solid.map(|id| Material::new(names, id)),
        length: w.length,
        weight: w.weight,
        emission: w.emission,
        equiangular: w.second.as_ref().map(|(t, l)| Equiangular { t: *t, light: light(names, l) }),
    }
}

#[derive(Serialize)]
pub(crate) struct Vertex<'a> {
    /// Whether `--path-of` selects it.
    #[serde(skip)]
    pub(crate) touches: bool,
    pub(crate) medium_segment: Option<MediumSegment<'a>>,
    #[serde(serialize_with = "plain")]
    pub(crate) origin: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    pub(crate) t: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) position: DVec3,
    /// `None` for a vertex in a medium.
    #[serde(flatten)]
    pub(crate) surface: Option<Surface<'a>>,
    pub(crate) inside: Vec<Material<'a>>,
    #[serde(serialize_with = "plain")]
    pub(crate) transmittance: Option<Spectrum>,
    #[serde(serialize_with = "plain")]
    pub(crate) throughput: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) passage: Passage,
    pub(crate) band: Option<u8>,
    pub(crate) lights: Vec<Light<'a>>,
    pub(crate) scatter: Option<Scatter>,
}

/// The part of a vertex that only surfaces have.
#[derive(Serialize)]
pub(crate) struct Surface<'a> {
    #[serde(serialize_with = "plain")]
    pub(crate) geometric_normal: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) shading_normal: DVec3,
    pub(crate) object: Object<'a>,
    pub(crate) part: u32,
    pub(crate) uv: [f64; 2],
    pub(crate) material: Material<'a>,
    pub(crate) chosen: Option<Material<'a>>,
    pub(crate) outside: bool,
    pub(crate) random_walk: Option<RandomWalk>,
    pub(crate) emission: Option<Emission>,
    pub(crate) photons: Option<Photons>,
    pub(crate) exterior_ior: Option<f64>,
    #[serde(serialize_with = "plain")]
    pub(crate) dispersed: Option<Spectrum>,
}

fn vertex<'a>(names: &Names<'a>, v: &VertexRecord) -> Vertex<'a> {
    let surface = (v.passage != Passage::Medium).then(|| Surface {
        geometric_normal: v.ng,
        shading_normal: v.ns,
        object: Object::new(names, v.primitive, v.shape),
        part: v.part,
        uv: v.uv,
        material: Material::new(names, v.material),
        chosen: v.chosen.map(|id| Material::new(names, id)),
        outside: v.outside,
        random_walk: v.walk.as_ref().map(random_walk),
        emission: v.emission.as_ref().map(emission),
        photons: v.photons.as_ref().map(photons),
        exterior_ior: v.ior_around,
        dispersed: v.dispersed,
    });
    Vertex {
        touches: names.touches(v.primitive, v.shape, v.material),
        medium_segment: v.way.as_ref().map(|w| medium_segment(names, w)),
        origin: v.origin,
        direction: v.direction,
        t: v.t,
        position: v.p,
        surface,
        inside: v.inside.iter().map(|&id| Material::new(names, id)).collect(),
        transmittance: v.transmittance,
        throughput: v.throughput,
        passage: v.passage,
        band: v.band,
        lights: v.lights.iter().map(|l| light(names, l)).collect(),
        scatter: v.scatter.as_ref().map(scatter),
    }
}

#[derive(Serialize)]
pub(crate) struct RandomWalk {
    pub(crate) steps: u32,
    pub(crate) length: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) weight: Spectrum,
}

fn random_walk(w: &RandomWalkRecord) -> RandomWalk {
    RandomWalk { steps: w.steps, length: w.length, weight: w.weight }
}

#[derive(Serialize)]
pub(crate) struct Photons {
    pub(crate) radius: f64,
    pub(crate) count: u32,
    #[serde(serialize_with = "plain")]
    pub(crate) radiance: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Spectrum,
}

fn photons(p: &PhotonsRecord) -> Photons {
    Photons { radius: p.radius, count: p.count, radiance: p.radiance, contribution: p.contribution }
}

#[derive(Serialize)]
pub(crate) struct Emission {
    #[serde(serialize_with = "plain")]
    pub(crate) radiance: Spectrum,
    pub(crate) pdf: Option<f64>,
    pub(crate) light_pdf: f64,
    pub(crate) mis_weight: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Spectrum,
}

fn emission(e: &EmissionRecord) -> Emission {
    Emission {
        radiance: e.radiance,
        pdf: e.pdf,
        light_pdf: e.light_pdf,
        mis_weight: e.weight,
        contribution: e.contribution,
    }
}

#[derive(Serialize)]
pub(crate) struct Light<'a> {
    /// Whether `--path-of` selects one of the occluders.
    #[serde(skip)]
    pub(crate) touches: bool,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    pub(crate) distance: f64,
    pub(crate) pdf: f64,
    pub(crate) delta: bool,
    #[serde(serialize_with = "plain")]
    pub(crate) radiance: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) bsdf: Spectrum,
    pub(crate) bsdf_pdf: f64,
    pub(crate) cosine: f64,
    pub(crate) mis_weight: f64,
    pub(crate) candidates: u32,
    pub(crate) resampling_weight: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) transmittance: Option<Spectrum>,
    #[serde(serialize_with = "plain")]
    pub(crate) unshadowed: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) visibility: Option<Spectrum>,
    pub(crate) occluders: Vec<Occluder<'a>>,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Spectrum,
}

fn light<'a>(names: &Names<'a>, l: &LightRecord) -> Light<'a> {
    Light {
        touches: l.casters.iter().any(|c| names.touches(c.primitive, c.shape, c.material)),
        direction: l.direction,
        distance: l.distance,
        pdf: l.pdf,
        delta: l.is_delta,
        radiance: l.radiance,
        bsdf: l.bsdf,
        bsdf_pdf: l.bsdf_pdf,
        cosine: l.cosine,
        mis_weight: l.weight,
        candidates: l.candidates,
        resampling_weight: f64::from(l.counts),
        transmittance: l.transmittance,
        unshadowed: l.unshadowed,
        visibility: l.visible,
        occluders: l.casters.iter().map(|c| Occluder::new(names, c)).collect(),
        contribution: l.contribution,
    }
}

#[derive(Serialize)]
pub(crate) struct Scatter {
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    pub(crate) lobe: Lobe,
    #[serde(serialize_with = "plain")]
    pub(crate) bsdf: Spectrum,
    pub(crate) pdf: f64,
    pub(crate) cosine: f64,
    pub(crate) eta: f64,
    pub(crate) terminator: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) weight: Spectrum,
    pub(crate) roulette: Option<Roulette>,
    #[serde(serialize_with = "plain")]
    pub(crate) throughput: Spectrum,
}

#[derive(Serialize)]
pub(crate) struct Lobe {
    pub(crate) delta: bool,
    pub(crate) transmission: bool,
    pub(crate) diffuse: bool,
}

#[derive(Serialize)]
pub(crate) struct Roulette {
    pub(crate) survival_probability: f64,
    pub(crate) random_number: f64,
}

fn scatter(s: &ScatterRecord) -> Scatter {
    let turner::bsdf::Lobe { is_delta, is_transmission, is_diffuse } = s.lobe;
    Scatter {
        direction: s.direction,
        lobe: Lobe { delta: is_delta, transmission: is_transmission, diffuse: is_diffuse },
        bsdf: s.bsdf,
        pdf: s.pdf,
        cosine: s.cosine,
        eta: s.eta,
        terminator: s.terminator,
        weight: s.weight,
        roulette: s.roulette.map(|r| Roulette { survival_probability: r.survival, random_number: r.number }),
        throughput: s.throughput,
    }
}

#[derive(Serialize)]
pub(crate) struct Escape<'a> {
    pub(crate) medium_segment: Option<MediumSegment<'a>>,
    #[serde(serialize_with = "plain")]
    pub(crate) origin: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) transmittance: Option<Spectrum>,
    #[serde(serialize_with = "plain")]
    pub(crate) throughput: Spectrum,
    pub(crate) pdf: Option<f64>,
    pub(crate) lights: Vec<InfiniteLight>,
    #[serde(serialize_with = "plain")]
    pub(crate) background: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) ambient: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Spectrum,
}

/// An infinite light that the escaping ray hits.
#[derive(Serialize)]
pub(crate) struct InfiniteLight {
    #[serde(serialize_with = "plain")]
    pub(crate) radiance: Spectrum,
    pub(crate) light_pdf: f64,
    pub(crate) mis_weight: f64,
}

fn infinite_light(l: &InfiniteLightRecord) -> InfiniteLight {
    InfiniteLight { radiance: l.radiance, light_pdf: l.light_pdf, mis_weight: l.weight }
}

fn escape<'a>(names: &Names<'a>, e: &EscapeRecord) -> Escape<'a> {
    Escape {
        medium_segment: e.way.as_ref().map(|w| medium_segment(names, w)),
        origin: e.origin,
        direction: e.direction,
        transmittance: e.transmittance,
        throughput: e.throughput,
        pdf: e.pdf,
        lights: e.lights.iter().map(infinite_light).collect(),
        background: e.background,
        ambient: e.ambient,
        contribution: e.contribution,
    }
}

impl Path<'_> {
    /// Whether `--path-of` selects the path.
    pub(super) fn touches(&self) -> bool {
        let equiangular = |segment: &Option<MediumSegment<'_>>| {
            segment.as_ref().and_then(|s| s.equiangular.as_ref()).is_some_and(|s| s.light.touches)
        };
        let light = |v: &Vertex<'_>| v.lights.iter().any(|l| l.touches);
        self.vertices.iter().any(|v| v.touches || light(v) || equiangular(&v.medium_segment))
            || self.escape.as_ref().is_some_and(|e| equiangular(&e.medium_segment))
    }
}
