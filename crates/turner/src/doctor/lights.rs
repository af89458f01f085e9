//! The irradiance from each light at visible surfaces, and what blocks the rest.

use std::collections::BTreeMap;

use super::first_hits::directions;
use super::{Options, materials, threads};
use crate::material::ShadowKind;
use crate::math::{Bounds, DVec3, Ray};
use crate::sampler::SampleId;
use crate::scene::emitters::LightSample;
use crate::scene::{ListedEmitter, Scene};

/// Light samples in all.
const MOST_ASKED: usize = 60_000;

/// The most lights that are measured; of a longer list, that many at even intervals.
const MOST_LIGHTS: usize = 512;

/// The most surface points.
const MOST_POINTS: usize = 192;

/// One light, sampled from many surface points.
#[derive(Clone, Debug)]
pub(super) struct LightFacts {
    pub(super) one: ListedEmitter,
    /// Its bounds, if it has a position.
    pub(super) bounds: Option<Bounds>,
    /// Samples of it, and of these: without light towards the point; from behind the surface; blocked; arrived.
    pub(super) asked: u32,
    pub(super) none: u32,
    pub(super) away: u32,
    pub(super) blocked: u32,
    pub(super) clear: u32,
    /// Mean irradiance (luminance) that arrives, is blocked, or comes from behind the surface.
    pub(super) arrives: f64,
    pub(super) kept_off: f64,
    pub(super) behind: f64,
    /// The objects that block it.
    pub(super) blockers: Vec<Blocker>,
    /// The fraction of directions in which it emits, and their mean (not of unit length).
    pub(super) lit: f64,
    pub(super) axis: DVec3,
    /// The median distance to the points.
    pub(super) distance: f64,
    /// The fraction of rays from its centre that hit an opaque surface, and the object that most of them hit.
    pub(super) enclosed: f64,
    pub(super) encloser: Option<(u32, &'static str)>,
    /// The distance within which 90 % of these rays end.
    pub(super) walls: f64,
    /// The mean direction from the surface points towards it.
    pub(super) towards: DVec3,
}

/// An object that blocks a light: its fraction of the blocked light, and whether it transmits light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocker {
    pub(super) primitive: u32,
    pub(super) shape: &'static str,
    pub(super) share: f64,
    pub(super) lets_through: bool,
}

/// Samples all lights from surface points, each with the normal on the visible side.
pub(super) fn ask(scene: &Scene, points: &[(DVec3, DVec3)], options: &Options<'_>) -> Vec<LightFacts> {
    let all = scene.emitter_list();
    let step = all.len().div_ceil(MOST_LIGHTS).max(1);
    let chosen: Vec<ListedEmitter> = all.iter().copied().step_by(step).collect();
    let count = (MOST_ASKED / chosen.len().max(1)).clamp(8, MOST_POINTS * 2);
    let step = (points.len() * 2).div_ceil(count).max(1);
    let points: Vec<(DVec3, DVec3)> = points.iter().copied().step_by(step).collect();
    let size = scene.stats.bounds.map_or(1.0, |b| b.size().length());
    let facts = threads::map(&chosen, options.threads, &|| false, |one| of_light(scene, *one, &points, size));
    facts.into_iter().flatten().collect()
}

/// The median.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::INFINITY)
}

fn of_light(scene: &Scene, one: ListedEmitter, points: &[(DVec3, DVec3)], size: f64) -> LightFacts {
    let bounds = scene.emitter_bounds(one);
    let mut f = LightFacts {
        one,
        bounds,
        asked: 0,
        none: 0,
        away: 0,
        blocked: 0,
        clear: 0,
        arrives: 0.0,
        kept_off: 0.0,
        behind: 0.0,
        blockers: Vec::new(),
        lit: 1.0,
        axis: DVec3::ZERO,
        distance: f64::INFINITY,
        enclosed: 0.0,
        encloser: None,
        walls: f64::INFINITY,
        towards: DVec3::ZERO,
    };
    let mut blockers: BTreeMap<u32, Blocker> = BTreeMap::new();
    let mut distances = Vec::new();
    for (i, (p, n)) in (0..).zip(points) {
        for k in 0..2 {
            let id = SampleId { x: i, y: k, index: 0, seed: 0x6c69_6768 };
            let (a, b) = (id.unit_square(0), id.unit_square(1));
            f.asked += 1;
            let Some(lit) = scene.sample_emitter(one, *p, [a.x, a.y, b.x]).filter(|l| !l.radiance.is_black())
            else {
                f.none += 1;
                continue;
            };
            let distance = lit.to_light.length();
            let wi = lit.to_light / distance;
            f.towards += wi;
            if lit.finite {
                distances.push(distance);
            }
            let cosine = wi.dot(*n);
            let arrives = f64::from(lit.radiance.luminance()) * cosine.abs() / lit.pdf;
            if !arrives.is_finite() {
                f.none += 1;
            } else if cosine <= 0.0 {
                f.away += 1;
                f.behind += arrives;
            } else {
                look(scene, &mut f, &mut blockers, (*p, *n), &lit, arrives);
            }
        }
    }
    let scale = 1.0 / f64::from(f.asked.max(1));
    (f.arrives, f.kept_off, f.behind) = (f.arrives * scale, f.kept_off * scale, f.behind * scale);
    f.towards = f.towards.normalize_or_zero();
    f.distance = median(distances);
    let sum: f64 = blockers.values().map(|b| b.share).sum();
    f.blockers = blockers.into_values().map(|b| Blocker { share: b.share / sum, ..b }).collect();
    f.blockers.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.primitive.cmp(&b.primitive)));
    if let Some(bounds) = bounds {
        around(scene, &mut f, &bounds, size);
    }
    f
}

/// Whether light arrives at a point, or what blocks it.
fn look(
    scene: &Scene,
    f: &mut LightFacts,
    blockers: &mut BTreeMap<u32, Blocker>,
    (p, n): (DVec3, DVec3),
    lit: &LightSample,
    arrives: f64,
) {
    let origin = p + n * (1e-9 * (p.abs().max_element() + lit.to_light.length().min(1e6)));
    let to = p + lit.to_light - origin;
    let ray = if lit.finite {
        Ray { t_max: 1.0 - 1e-9, ..Ray::new(origin, to) }
    } else {
        Ray::new(origin, lit.to_light.normalize())
    };
    let through = scene.transmittance(&ray);
    let share = f64::from(through.luminance());
    f.arrives += arrives * share;
    f.kept_off += arrives * (1.0 - share);
    if !through.is_black() {
        f.clear += 1;
        return;
    }
    f.blocked += 1;
    let Some(hit) = next_to_light(scene, f.one, ray) else { return };
    let entry = blockers.entry(hit.primitive).or_insert(Blocker { share: 0.0, ..hit });
    entry.share += arrives;
}

/// Of all objects on the way, the one closest to the light: it is the one that blocks most points.
fn next_to_light(scene: &Scene, one: ListedEmitter, mut ray: Ray) -> Option<Blocker> {
    const MOST: u32 = 32;
    let own = match one {
        ListedEmitter::Shape { primitive, .. } => Some(primitive),
        ListedEmitter::Light(_) => None,
    };
    let mut last = None;
    for _ in 0..MOST {
        let Some(hit) = scene.intersect(&ray) else { break };
        let surface = scene.surface(&ray, &hit);
        let primitive = scene.primitive_id(&hit);
        let shadow = scene.materials.get(surface.material.index()).map(|m| m.shadow());
        if Some(primitive) != own && shadow == Some(ShadowKind::Opaque) {
            let lets_through = materials::lets_through(scene, surface.material);
            last = Some(Blocker { primitive, shape: scene.shape_word(&hit), share: 1.0, lets_through });
        }
        ray.t_min = scene.behind(&ray, &hit);
    }
    last
}

/// The directions in which it emits, and what surrounds it.
fn around(scene: &Scene, f: &mut LightFacts, bounds: &Bounds, size: f64) {
    const DIRECTIONS: u32 = 128;
    let center = bounds.center();
    let far = bounds.size().length() + 1e-3 * size.max(1e-30);
    let own = match f.one {
        ListedEmitter::Shape { primitive, .. } => Some(primitive),
        ListedEmitter::Light(_) => None,
    };
    let (mut lit, mut met): (u32, BTreeMap<u32, (u32, &'static str)>) = (0, BTreeMap::new());
    let (mut axis, mut walls) = (DVec3::ZERO, Vec::new());
    for d in directions(DIRECTIONS) {
        let shines = scene.sample_emitter(f.one, center + d * far, [0.5, 0.5, 0.5]);
        if shines.is_some_and(|l| !l.radiance.is_black()) {
            lit += 1;
            axis += d;
        }
        let mut ray = Ray::new(center, d);
        // Leave its own shape first.
        for _ in 0..4 {
            let Some(hit) = scene.intersect(&ray) else { break };
            if Some(scene.primitive_id(&hit)) == own {
                ray.t_min = scene.behind(&ray, &hit);
                continue;
            }
            let surface = scene.surface(&ray, &hit);
            if !materials::lets_through(scene, surface.material) {
                walls.push(hit.shape.t);
                let entry = met.entry(scene.primitive_id(&hit)).or_insert((0, scene.shape_word(&hit)));
                entry.0 += 1;
            }
            break;
        }
    }
    f.lit = f64::from(lit) / f64::from(DIRECTIONS);
    f.axis = axis / f64::from(DIRECTIONS);
    walls.resize(DIRECTIONS as usize, f64::INFINITY);
    f.walls = super::picture::quantile(walls, 0.9);
    let hits: u32 = met.values().map(|(n, _)| n).sum();
    f.enclosed = f64::from(hits) / f64::from(DIRECTIONS);
    let most = met.iter().max_by_key(|(id, (n, _))| (*n, std::cmp::Reverse(**id)));
    f.encloser = most.map(|(id, (_, shape))| (*id, *shape));
}
