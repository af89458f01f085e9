//! The irradiance that each light gives at visible surface points, and the objects that block it.
//!
//! A light is sampled from each point p with normal n, and a shadow ray traces the sample:
//!
//! ```text
//!   light ●
//!          ╲          E = L cosθ / pdf
//!       ▓▓▓▓╲▓▓▓      blocked: the opaque object closest to the light is the blocker
//!            ╲ θ  n
//!             ╲  │
//! ─────────────p─┴─── cosθ < 0: the surface faces away from the light
//! ```

use std::collections::BTreeMap;

use super::first_hits::directions;
use super::{Options, materials, threads};
use crate::material::ShadowKind;
use crate::math::{Bounds, DVec3, Ray};
use crate::sampler::SampleId;
use crate::scene::light_sample::LightSample;
use crate::scene::{ListedEmitter, Scene};

/// Maximum number of light samples in total.
const MAX_SAMPLES: usize = 60_000;

/// Maximum number of measured lights. Of a longer list, lights at even intervals are measured.
const MAX_LIGHTS: usize = 512;

/// Maximum number of surface points.
const MAX_POINTS: usize = 192;

/// The measurements of one light.
#[derive(Clone, Debug)]
pub(super) struct LightFacts {
    pub(super) emitter: ListedEmitter,
    /// Its bounds, if it has a position.
    pub(super) bounds: Option<Bounds>,
    /// Number of light samples, and of these: the light does not emit towards the point; the surface faces away from
    /// the light; blocked; visible.
    pub(super) sampled: u32,
    pub(super) unlit: u32,
    pub(super) facing_away: u32,
    pub(super) blocked: u32,
    pub(super) visible: u32,
    /// Mean irradiance (luminance): unblocked, blocked, and at the back of surfaces that face away.
    pub(super) irradiance: f64,
    pub(super) blocked_irradiance: f64,
    pub(super) back_irradiance: f64,
    /// The objects that block it, the most important first.
    pub(super) blockers: Vec<Blocker>,
    /// The fraction of directions in which it emits, and the mean of these directions (not of unit length).
    pub(super) emitting: f64,
    pub(super) axis: DVec3,
    /// The median distance to the surface points.
    pub(super) distance: f64,
    /// The fraction of rays from its centre that hit an opaque surface, and the object that most of them hit, with its
    /// shape.
    pub(super) enclosed: f64,
    pub(super) encloser: Option<(u32, &'static str)>,
    /// The distance within which 90 % of the rays from its centre end.
    pub(super) wall_distance: f64,
    /// The mean direction from the surface points towards it.
    pub(super) towards: DVec3,
}

/// An object that blocks a light, with its fraction of the blocked light, and whether it transmits light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocker {
    pub(super) primitive: u32,
    pub(super) shape: &'static str,
    pub(super) fraction: f64,
    pub(super) transmits: bool,
}

/// Samples all lights from surface points, given with the normal on the visible side.
pub(super) fn measure(scene: &Scene, points: &[(DVec3, DVec3)], options: &Options<'_>) -> Vec<LightFacts> {
    let all = scene.emitter_list();
    let step = all.len().div_ceil(MAX_LIGHTS).max(1);
    let chosen: Vec<ListedEmitter> = all.iter().copied().step_by(step).collect();
    let count = (MAX_SAMPLES / chosen.len().max(1)).clamp(8, MAX_POINTS * 2);
    let step = (points.len() * 2).div_ceil(count).max(1);
    let points: Vec<(DVec3, DVec3)> = points.iter().copied().step_by(step).collect();
    let size = scene.stats.bounds.map_or(1.0, |b| b.size().length());
    let facts =
        threads::map(&chosen, options.threads, &|| false, |emitter| of_light(scene, *emitter, &points, size));
    facts.into_iter().flatten().collect()
}

/// The median.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::INFINITY)
}

fn of_light(scene: &Scene, emitter: ListedEmitter, points: &[(DVec3, DVec3)], size: f64) -> LightFacts {
    let bounds = scene.emitter_bounds(emitter);
    let mut f = LightFacts {
        emitter,
        bounds,
        sampled: 0,
        unlit: 0,
        facing_away: 0,
        blocked: 0,
        visible: 0,
        irradiance: 0.0,
        blocked_irradiance: 0.0,
        back_irradiance: 0.0,
        blockers: Vec::new(),
        emitting: 1.0,
        axis: DVec3::ZERO,
        distance: f64::INFINITY,
        enclosed: 0.0,
        encloser: None,
        wall_distance: f64::INFINITY,
        towards: DVec3::ZERO,
    };
    let mut blockers: BTreeMap<u32, Blocker> = BTreeMap::new();
    let mut distances = Vec::new();
    for (i, (p, n)) in (0..).zip(points) {
        for k in 0..2 {
            let id = SampleId { x: i, y: k, index: 0, seed: 0x6c69_6768 };
            let (a, b) = (id.unit_square(0), id.unit_square(1));
            f.sampled += 1;
            let Some(lit) =
                scene.sample_emitter(emitter, *p, [a.x, a.y, b.x]).filter(|l| !l.radiance.is_black())
            else {
                f.unlit += 1;
                continue;
            };
            let distance = lit.to_light.length();
            let wi = lit.to_light / distance;
            f.towards += wi;
            if lit.finite {
                distances.push(distance);
            }
            let cosine = wi.dot(*n);
            let irradiance = f64::from(lit.radiance.luminance()) * cosine.abs() / lit.pdf;
            if !irradiance.is_finite() {
                f.unlit += 1;
            } else if cosine <= 0.0 {
                f.facing_away += 1;
                f.back_irradiance += irradiance;
            } else {
                trace_shadow_ray(scene, &mut f, &mut blockers, (*p, *n), &lit, irradiance);
            }
        }
    }
    let scale = 1.0 / f64::from(f.sampled.max(1));
    (f.irradiance, f.blocked_irradiance, f.back_irradiance) =
        (f.irradiance * scale, f.blocked_irradiance * scale, f.back_irradiance * scale);
    f.towards = f.towards.normalize_or_zero();
    f.distance = median(distances);
    let sum: f64 = blockers.values().map(|b| b.fraction).sum();
    f.blockers = blockers.into_values().map(|b| Blocker { fraction: b.fraction / sum, ..b }).collect();
    f.blockers.sort_by(|a, b| b.fraction.total_cmp(&a.fraction).then(a.primitive.cmp(&b.primitive)));
    if let Some(bounds) = bounds {
        measure_enclosure(scene, &mut f, &bounds, size);
    }
    f
}

/// Traces the shadow ray of a light sample and adds its irradiance, or its blocker.
fn trace_shadow_ray(
    scene: &Scene,
    f: &mut LightFacts,
    blockers: &mut BTreeMap<u32, Blocker>,
    (p, n): (DVec3, DVec3),
    lit: &LightSample,
    irradiance: f64,
) {
    let origin = p + n * (1e-9 * (p.abs().max_element() + lit.to_light.length().min(1e6)));
    let to = p + lit.to_light - origin;
    let ray = if lit.finite {
        Ray { t_max: 1.0 - 1e-9, ..Ray::new(origin, to) }
    } else {
        Ray::new(origin, lit.to_light.normalize())
    };
    let through = scene.transmittance(&ray);
    let fraction = f64::from(through.luminance());
    f.irradiance += irradiance * fraction;
    f.blocked_irradiance += irradiance * (1.0 - fraction);
    if !through.is_black() {
        f.visible += 1;
        return;
    }
    f.blocked += 1;
    let Some(hit) = next_to_light(scene, f.emitter, ray) else { return };
    let entry = blockers.entry(hit.primitive).or_insert(Blocker { fraction: 0.0, ..hit });
    entry.fraction += irradiance;
}

/// The opaque object on a shadow ray that is closest to the light, because that one blocks most points.
fn next_to_light(scene: &Scene, emitter: ListedEmitter, mut ray: Ray) -> Option<Blocker> {
    const MAX: u32 = 32;
    let own = match emitter {
        ListedEmitter::Shape { primitive, .. } => Some(primitive),
        ListedEmitter::Light(_) => None,
    };
    let mut last = None;
    for _ in 0..MAX {
        let Some(hit) = scene.intersect(&ray) else { break };
        let surface = scene.surface(&ray, &hit);
        let primitive = scene.primitive_id(&hit);
        let shadow = scene.materials.get(surface.material.index()).map(|m| m.shadow());
        if Some(primitive) != own && shadow == Some(ShadowKind::Opaque) {
            let transmits = materials::transmits(scene, surface.material);
            last = Some(Blocker { primitive, shape: scene.shape_word(&hit), fraction: 1.0, transmits });
        }
        ray.t_min = scene.behind(&ray, &hit);
    }
    last
}

/// Measures in which directions a light emits, and which objects enclose it.
fn measure_enclosure(scene: &Scene, f: &mut LightFacts, bounds: &Bounds, size: f64) {
    const DIRECTIONS: u32 = 128;
    let center = bounds.center();
    let far = bounds.size().length() + 1e-3 * size.max(1e-30);
    let own = match f.emitter {
        ListedEmitter::Shape { primitive, .. } => Some(primitive),
        ListedEmitter::Light(_) => None,
    };
    let (mut lit, mut hit_counts): (u32, BTreeMap<u32, (u32, &'static str)>) = (0, BTreeMap::new());
    let (mut axis, mut walls) = (DVec3::ZERO, Vec::new());
    for d in directions(DIRECTIONS) {
        let sample = scene.sample_emitter(f.emitter, center + d * far, [0.5, 0.5, 0.5]);
        if sample.is_some_and(|l| !l.radiance.is_black()) {
            lit += 1;
            axis += d;
        }
        let mut ray = Ray::new(center, d);
        // Skip hits on its own shape.
        for _ in 0..4 {
            let Some(hit) = scene.intersect(&ray) else { break };
            if Some(scene.primitive_id(&hit)) == own {
                ray.t_min = scene.behind(&ray, &hit);
                continue;
            }
            let surface = scene.surface(&ray, &hit);
            if !materials::transmits(scene, surface.material) {
                walls.push(hit.shape.t);
                let entry = hit_counts.entry(scene.primitive_id(&hit)).or_insert((0, scene.shape_word(&hit)));
                entry.0 += 1;
            }
            break;
        }
    }
    f.emitting = f64::from(lit) / f64::from(DIRECTIONS);
    f.axis = axis / f64::from(DIRECTIONS);
    walls.resize(DIRECTIONS as usize, f64::INFINITY);
    f.wall_distance = super::picture::quantile(walls, 0.9);
    let hits: u32 = hit_counts.values().map(|(n, _)| n).sum();
    f.enclosed = f64::from(hits) / f64::from(DIRECTIONS);
    let most = hit_counts.iter().max_by_key(|(id, (n, _))| (*n, std::cmp::Reverse(**id)));
    f.encloser = most.map(|(id, (_, shape))| (*id, *shape));
}
