//! The pilot run for adaptive sampling of an environment: a few paths find points of the scene, and shadow rays from
//! there find what each sees of the environment. Both have fixed seeds, so the result is the same on every run.

use turner_bvh::lanes::LANES;

use super::path_batch::PathBatch;
use super::record::Off;
use super::{Context, LightSampling};
use crate::bsdf::sample_cosine;
use crate::color::Spectrum;
use crate::integrator::probing::is_cheap;
use crate::integrator::{CameraSamples, RayStats, Tracer};
use crate::light::{AdaptiveEnvironment, EnvironmentLearning, Light};
use crate::math::{DVec2, DVec3, Frame, Ray};
use crate::sampler::SampleId;
use crate::scene::{RayBatch, RayOrigin, SurfaceInteraction};
use crate::view::take_points;

/// Maximum number of paths along each side of the image, and pixels for each of them along a side: the paths are a small
/// part of those of any picture.
const MOST_SIDE: u32 = 64;
const PIXELS: f64 = 4.0;

/// Shadow rays of a point: half in proportion to the luminance of the environment, half to the cosine.
const RAYS: u32 = 8;

const SEED: u64 = 0x51de;

/// A point where lights are sampled.
pub(super) struct LitPoint {
    p: DVec3,
    /// Origin of rays that leave it, and the normal, both on the side of the viewer.
    origin: DVec3,
    n: DVec3,
    from: RayOrigin,
}

impl LitPoint {
    pub(super) fn new(surface: &SurfaceInteraction, direction: DVec3) -> LitPoint {
        let n = if surface.ng.dot(direction) <= 0.0 { surface.ng } else { -surface.ng };
        LitPoint { p: surface.p, origin: surface.leave(n), n, from: surface.hit.origin() }
    }
}

/// The environment of the scene with what is learned about it; `None` without an environment, or where nothing is
/// gained.
pub(super) fn learn(context: Context<'_>) -> Option<AdaptiveEnvironment> {
    let Context { scene, view, settings, .. } = context;
    let mut environments = scene.lights.iter().enumerate().filter_map(|(i, light)| match light {
        Light::Environment(light) => Some((i as u32, light)),
        _ => None,
    });
    let (index, light) = environments.next()?;
    // Points in media have no normal, and no cell.
    let possible = settings.light_sampling != LightSampling::Bsdf && scene.volumes.is_none();
    if !possible || !is_cheap(scene, view) {
        return None;
    }
    let points = find_points(context);
    let mut learning = EnvironmentLearning::new(light, points.iter().map(|point| point.p).collect())?;
    let (mut rays, mut through, mut waiting) = (RayBatch::default(), Vec::new(), Vec::new());
    for (chunk, points) in (0u32..).zip(points.chunks(256)) {
        rays.clear();
        waiting.clear();
        for (i, point) in (0u32..).zip(points) {
            for k in 0..RAYS {
                let id = SampleId { x: i, y: chunk, index: k, seed: SEED };
                let u = id.unit_square(0).to_array();
                let direction = match k % 2 {
                    0 => learning.direction(u),
                    _ => Some(Frame::from_z(point.n).to_world(sample_cosine(u))),
                };
                let Some(direction) = direction else { continue };
                let cos = direction.dot(point.n);
                if cos > 0.0 {
                    rays.push_leaving(&Ray::new(point.origin, direction), point.from);
                    waiting.push((point.p, direction, cos as f32));
                } else {
                    learning.add(point.p, direction, 0.0);
                }
            }
        }
        scene.transmittance_batch(&mut rays, &mut through);
        for (i, (p, direction, cos)) in waiting.iter().enumerate() {
            let through: Spectrum = through[i / LANES].get(i % LANES);
            learning.add(*p, *direction, cos * through.max_component());
        }
    }
    learning.finish(index)
}

/// Points where the paths of the image sample lights.
fn find_points(context: Context<'_>) -> Vec<LitPoint> {
    let view = context.view;
    let size = DVec2::new(f64::from(view.film.width), f64::from(view.film.height));
    let side = (((size.x * size.y).sqrt() / PIXELS) as u32).clamp(1, MOST_SIDE);
    let mut batch = PathBatch::new(context, Off);
    batch.lit_points = Some(Vec::new());
    let mut out = Vec::new();
    for y in 0..side {
        let mut samples = CameraSamples::default();
        let points = (0..side).map(|x| {
            let id = SampleId { x, y, index: 0, seed: SEED };
            let place = DVec2::new(f64::from(x), f64::from(y)) + id.unit_square(0);
            (id, place * size / f64::from(side))
        });
        take_points(view, &mut samples, points);
        batch.radiance(&samples, &mut out, &mut RayStats::default());
    }
    batch.lit_points.take().unwrap_or_default()
}
