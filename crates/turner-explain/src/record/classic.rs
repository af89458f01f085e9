//! The record of a sample of the classic integrator: its ray tree, as JSON has it.

use serde::Serialize;
use turner::color::Spectrum;
use turner::integrator::classic::{
    CutReason, CutRecord, HitRecord, LightTerm, RayEnd, RayKind, RayRecord, Seen, ShadowRecord, TreeRecord,
};
use turner::math::DVec3;
use turner::scene::Caster;

use super::{Material, Object, plain};
use turner::explain::Names;

#[derive(Serialize)]
pub(crate) struct Tree<'a> {
    pub(crate) rays: Vec<Ray<'a>>,
    pub(crate) unrecorded_rays: u64,
    pub(crate) dropped_rays: u64,
}

pub(crate) fn of<'a>(names: &Names<'a>, tree: &TreeRecord) -> Tree<'a> {
    Tree {
        rays: tree.rays.iter().map(|r| ray(names, r)).collect(),
        unrecorded_rays: tree.unwritten,
        dropped_rays: tree.dropped,
    }
}

#[derive(Serialize)]
pub(crate) struct Ray<'a> {
    #[serde(serialize_with = "plain")]
    pub(crate) kind: RayKind,
    pub(crate) parent: Option<u32>,
    pub(crate) depth: u32,
    #[serde(serialize_with = "plain")]
    pub(crate) origin: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    pub(crate) weight: f64,
    pub(crate) hit: Option<Hit<'a>>,
    pub(crate) miss: Option<Miss>,
}

#[derive(Serialize)]
pub(crate) struct Miss {
    #[serde(serialize_with = "plain")]
    pub(crate) seen: Seen,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Spectrum,
}

fn ray<'a>(names: &Names<'a>, r: &RayRecord) -> Ray<'a> {
    let (hit, miss) = match &r.end {
        RayEnd::Hit(h) => (Some(hit(names, h)), None),
        RayEnd::Miss(m) => (None, Some(Miss { seen: m.seen, contribution: m.contribution })),
    };
    Ray {
        kind: r.kind,
        parent: r.parent,
        depth: r.depth,
        origin: r.origin,
        direction: r.direction,
        weight: r.weight,
        hit,
        miss,
    }
}

#[derive(Serialize)]
pub(crate) struct Hit<'a> {
    /// Whether `--path-of` selects it.
    #[serde(skip)]
    pub(crate) touches: bool,
    pub(crate) t: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) position: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) geometric_normal: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) shading_normal: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) normal: DVec3,
    pub(crate) object: Object<'a>,
    pub(crate) part: u32,
    pub(crate) uv: [f64; 2],
    pub(crate) material: Material<'a>,
    pub(crate) entering: bool,
    pub(crate) total_internal_reflection: bool,
    #[serde(serialize_with = "plain")]
    pub(crate) color: Spectrum,
    pub(crate) ka: f64,
    pub(crate) kd: f64,
    pub(crate) ks: f64,
    pub(crate) shininess: f64,
    pub(crate) ior: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) ambient: Spectrum,
    pub(crate) lights: Vec<Light<'a>>,
    #[serde(serialize_with = "plain")]
    pub(crate) local: Spectrum,
    pub(crate) k_local: f64,
    pub(crate) k_reflect: f64,
    pub(crate) k_refract: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) emission: Option<Spectrum>,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Option<Spectrum>,
    pub(crate) not_traced: Vec<Cut>,
}

fn hit<'a>(names: &Names<'a>, h: &HitRecord) -> Hit<'a> {
    let [ka, kd, ks] = h.coefficients;
    let [local, reflect, refract] = h.weights;
    Hit {
        touches: names.touches(h.primitive, h.shape, h.material),
        t: h.t,
        position: h.p,
        geometric_normal: h.ng,
        shading_normal: h.ns,
        normal: h.n,
        object: Object::new(names, h.primitive, h.shape),
        part: h.part,
        uv: h.uv,
        material: Material::new(names, h.material),
        entering: h.entering,
        total_internal_reflection: h.total_internal_reflection,
        color: h.color,
        ka,
        kd,
        ks,
        shininess: h.shininess,
        ior: h.ior,
        ambient: h.ambient,
        lights: h.lights.iter().map(|l| light(names, l)).collect(),
        local: h.local,
        k_local: local,
        k_reflect: reflect,
        k_refract: refract,
        emission: h.emitted,
        contribution: h.contribution,
        not_traced: h.cut.iter().map(cut).collect(),
    }
}

#[derive(Serialize)]
pub(crate) struct Cut {
    #[serde(serialize_with = "plain")]
    pub(crate) kind: RayKind,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    pub(crate) weight: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) reason: CutReason,
    #[serde(serialize_with = "plain")]
    pub(crate) seen: Seen,
    #[serde(serialize_with = "plain")]
    pub(crate) contribution: Spectrum,
}

fn cut(c: &CutRecord) -> Cut {
    Cut {
        kind: c.kind,
        direction: c.direction,
        weight: c.weight,
        reason: c.reason,
        seen: c.seen,
        contribution: c.contribution,
    }
}

#[derive(Serialize)]
pub(crate) struct Light<'a> {
    /// Whether `--path-of` selects one of the occluders.
    #[serde(skip)]
    pub(crate) touches: bool,
    pub(crate) light: u32,
    pub(crate) name: String,
    pub(crate) point: u32,
    #[serde(serialize_with = "plain")]
    pub(crate) to_light: DVec3,
    pub(crate) distance: Option<f64>,
    pub(crate) reaches: bool,
    #[serde(serialize_with = "plain")]
    pub(crate) intensity: Spectrum,
    pub(crate) n_dot_l: f64,
    pub(crate) r_dot_v: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) diffuse: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) highlight: Spectrum,
    pub(crate) shadow: Option<Shadow<'a>>,
    #[serde(serialize_with = "plain")]
    pub(crate) added: Spectrum,
}

fn light<'a>(names: &Names<'a>, l: &LightTerm) -> Light<'a> {
    let occluders = l.shadow.as_ref().map_or(&[][..], |s| &s.casters);
    Light {
        touches: occluders.iter().any(|c| names.touches(c.primitive, c.shape, c.material)),
        light: l.light,
        name: names.light(l.light),
        point: l.sample,
        to_light: l.to_light,
        distance: l.finite.then(|| l.to_light.length()),
        reaches: l.reaches,
        intensity: l.intensity,
        n_dot_l: l.n_dot_l,
        r_dot_v: l.r_dot_v,
        diffuse: l.diffuse,
        highlight: l.highlight,
        shadow: l.shadow.as_ref().map(|s| shadow(names, s)),
        added: l.added,
    }
}

#[derive(Serialize)]
pub(crate) struct Shadow<'a> {
    #[serde(serialize_with = "plain")]
    pub(crate) origin: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
    pub(crate) t_min: f64,
    pub(crate) t_max: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) transmittance: Spectrum,
    pub(crate) occluders: Vec<Occluder<'a>>,
}

fn shadow<'a>(names: &Names<'a>, s: &ShadowRecord) -> Shadow<'a> {
    Shadow {
        origin: s.origin,
        direction: s.direction,
        t_min: s.t_min,
        t_max: s.t_max,
        transmittance: s.through,
        occluders: s.casters.iter().map(|c| Occluder::new(names, c)).collect(),
    }
}

/// An object that a shadow ray hits, opaque or tinted.
#[derive(Serialize)]
pub(crate) struct Occluder<'a> {
    pub(crate) t: f64,
    pub(crate) object: Object<'a>,
    pub(crate) material: Material<'a>,
}

impl<'a> Occluder<'a> {
    pub(super) fn new(names: &Names<'a>, c: &Caster) -> Occluder<'a> {
        let (object, material) = (Object::new(names, c.primitive, c.shape), Material::new(names, c.material));
        Occluder { t: c.t, object, material }
    }
}

impl Tree<'_> {
    /// Whether `--path-of` selects a ray of the tree.
    pub(super) fn touches(&self) -> bool {
        let mut hits = self.rays.iter().filter_map(|r| r.hit.as_ref());
        hits.any(|h| h.touches || h.lights.iter().any(|l| l.touches))
    }
}
