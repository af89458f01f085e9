//! The pilot run for adaptive sampling of an environment: a few paths find points of the scene, and shadow rays from
//! there find what each sees of the environment. Both have fixed seeds, so the result is the same on every run.

use turner_bvh::lanes::LANES;

use super::path_batch::PathBatch;
use super::record::Off;
use super::{Context, LightSampling};
use crate::bsdf::sample_cosine;
use crate::color::Spectrum;
use crate::integrator::probing::is_cheap;
use crate::integrator::{CameraSamples, RayStats, Tracer, tasks};
use crate::light::{AdaptiveEnvironment, EnvironmentLearning, EnvironmentLight, Light};
use crate::math::{DVec2, DVec3, Frame, Ray};
use crate::sampler::SampleId;
use crate::scene::{RayBatch, RayOrigin, Scene, SurfaceInteraction};
use crate::view::{View, take_points};

/// Maximum number of paths along each side of the image, and pixels for each of them along a side: the paths are a small
/// part of those of any picture.
const MOST_SIDE: u32 = 64;
const PIXELS: f64 = 4.0;

/// Shadow rays of a point: half in proportion to the luminance of the environment, half to the cosine.
const RAYS: u32 = 8;

/// Where more of the light than this arrives, adaptive sampling gains little.
const MOST_OPEN: f64 = 0.4;

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

/// What the pilot run finds.
pub(super) struct Learned {
    /// What each part of the scene sees of the environment; `None` if it is best sampled as it is.
    pub(super) adaptive: Option<AdaptiveEnvironment>,
    pub(super) sky: Sky,
}

/// How much of an environment arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sky {
    /// Little or nothing, or it is unknown.
    Closed,
    /// Much: more than [`MOST_OPEN`].
    Open,
    /// A uniform environment is the only light, and much of it arrives. Directions that follow the BSDF then need no light
    /// samples by luminance beside them: .75 to .85 of the time, .83 to 1.06 of the variance of balls and glass under a uniform
    /// sky.
    Uniform,
}

/// What is to be learned about the environment of the scene.
pub(super) fn learn(context: Context<'_>) -> Learned {
    found(context).unwrap_or(Learned { adaptive: None, sky: Sky::Closed })
}

fn found(context: Context<'_>) -> Option<Learned> {
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
    let side = side_of(view);
    let few = find_points(context, (side / 4).max(1));
    let open = open_fraction(scene, light, &few);
    if open > MOST_OPEN {
        let alone = scene.emitters.len() == 1 && settings.light_sampling == LightSampling::Both;
        let sky = if alone && light.uniform().is_some() { Sky::Uniform } else { Sky::Open };
        return Some(Learned { adaptive: None, sky });
    }
    let points = find_points(context, side);
    let mut learning = EnvironmentLearning::new(light, points.iter().map(|point| point.p).collect())?;
    let chunks: Vec<&[LitPoint]> = points.chunks(256).collect();
    let seen = tasks::map(
        chunks.len(),
        context.threads,
        || (),
        |(), chunk| {
            let direction = |i: u32, k: u32, n: DVec3| {
                let u = SampleId { x: i, y: chunk as u32, index: k, seed: SEED }.unit_square(0).to_array();
                if k.is_multiple_of(2) {
                    learning.direction(u)
                } else {
                    Some(Frame::from_z(n).to_world(sample_cosine(u)))
                }
            };
            look(scene, chunks[chunk], direction)
        },
    );
    for TracedRay { p, direction, cos, through } in seen.into_iter().flatten() {
        learning.add(p, direction, cos.max(0.0) * through);
    }
    Some(Learned { adaptive: learning.finish(index), sky: Sky::Closed })
}

/// A traced shadow ray: its origin, its direction, the cosine to the normal there, and its transmittance, which is 0 below
/// the surface.
struct TracedRay {
    p: DVec3,
    direction: DVec3,
    cos: f32,
    through: f32,
}

/// Traces the shadow rays of points in directions given by the index of the point, that of the ray and the normal.
fn look(
    scene: &Scene,
    points: &[LitPoint],
    direction: impl Fn(u32, u32, DVec3) -> Option<DVec3>,
) -> Vec<TracedRay> {
    let (mut rays, mut through, mut traced) = (RayBatch::default(), Vec::new(), Vec::new());
    let mut seen = Vec::new();
    for (i, point) in (0u32..).zip(points) {
        for direction in (0..RAYS).filter_map(|k| direction(i, k, point.n)) {
            let cos = direction.dot(point.n);
            if cos > 0.0 {
                rays.push_leaving(&Ray::new(point.origin, direction), point.from);
                traced.push(seen.len());
            }
            seen.push(TracedRay { p: point.p, direction, cos: cos as f32, through: 0.0 });
        }
    }
    scene.transmittance_batch(&mut rays, &mut through);
    for (i, place) in traced.into_iter().enumerate() {
        let left: Spectrum = through[i / LANES].get(i % LANES);
        seen[place].through = left.max_component();
    }
    seen
}

/// The fraction of light above the surfaces at these points that arrives there.
fn open_fraction(scene: &Scene, light: &EnvironmentLight, points: &[LitPoint]) -> f64 {
    let direction = |i: u32, k: u32, _: DVec3| {
        let u = SampleId { x: i, y: 0, index: k, seed: SEED }.unit_square(0).to_array();
        light.sample(u).map(|s| s.direction)
    };
    let seen = look(scene, points, direction);
    let above = seen.iter().filter(|seen| seen.cos > 0.0);
    let (sum, count) = above.fold((0.0, 0.0), |(sum, n), seen| (sum + f64::from(seen.through), n + 1.0));
    if count > 0.0 { sum / count } else { 1.0 }
}

/// Number of paths of the pilot run along each side of the image.
fn side_of(view: &View) -> u32 {
    let pixels = f64::from(view.film.width) * f64::from(view.film.height);
    ((pixels.sqrt() / PIXELS) as u32).clamp(1, MOST_SIDE)
}

/// Points where the paths of the image sample lights.
fn find_points(context: Context<'_>, side: u32) -> Vec<LitPoint> {
    let view = context.view;
    let size = DVec2::new(f64::from(view.film.width), f64::from(view.film.height));
    let worker = || PathBatch::new(context, Off);
    let rows = tasks::map(side as usize, context.threads, worker, |batch, y| {
        batch.lit_points = Some(Vec::new());
        let y = y as u32;
        let mut samples = CameraSamples::default();
        let points = (0..side).map(|x| {
            let id = SampleId { x, y, index: 0, seed: SEED };
            let place = DVec2::new(f64::from(x), f64::from(y)) + id.unit_square(0);
            (id, place * size / f64::from(side))
        });
        take_points(view, &mut samples, points);
        batch.radiance(&samples, &mut Vec::new(), &mut RayStats::default());
        batch.lit_points.take().unwrap_or_default()
    });
    rows.into_iter().flatten().collect()
}
