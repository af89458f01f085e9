//! A summary of the measurements.

use super::evidence::Evidence;
use super::kind::PathKind;
use super::picture::quantile;
use crate::scene::ListedEmitter;

/// The light and variance of one kind of path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KindSummary {
    /// The kind.
    pub kind: PathKind,
    /// Its fraction of the light in the picture, 0 to 1.
    pub light: f64,
    /// Its fraction of the variance: its covariance with the sample over the sample's variance. The fractions of all
    /// kinds sum to 1. One may be negative if kinds are anticorrelated.
    pub variance: f64,
}

/// The measurements of one light or emissive shape.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSummary {
    /// Its name.
    pub name: String,
    /// Mean irradiance (luminance) at visible surfaces, without what is blocked.
    pub irradiance: f64,
    /// Mean irradiance that objects block.
    pub blocked_irradiance: f64,
    /// Fraction of visible surface points that the light reaches.
    pub reaches: f64,
    /// Its fraction of the light in the picture; `None` if no paths were traced.
    pub light: Option<f64>,
    /// Its fraction of the variance; `None` if no paths were traced.
    pub variance: Option<f64>,
}

/// A summary of the measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Number of probed pixels.
    pub pixels: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Whether all pixels were probed within the time limit.
    pub complete: bool,
    /// The 5th, 50th and 95th percentile of the displayed brightness of the pixels (values in the file, 0 to 1).
    pub shown: [f64; 3],
    /// Fraction of white pixels.
    pub white: f64,
    /// Fraction of camera rays that hit something.
    pub hit_fraction: f64,
    /// Whether the picture is almost black.
    pub black: bool,
    /// The expected error (relMSE) with the film's samples per pixel; `None` if no paths were traced.
    pub error: Option<f64>,
    /// Samples per pixel for an expected error of 0.01.
    pub samples_wanted: Option<u64>,
    /// Mean number of surfaces on a path, or of rays in a ray tree of `classic`.
    pub surfaces_per_sample: f64,
    /// Mean number of shadow rays per sample.
    pub shadow_rays_per_sample: f64,
    /// Mean number of boxes and shapes tested per camera ray.
    pub steps_per_ray: f64,
    /// Light and variance by kind of path, in order of decreasing variance.
    pub kinds: Vec<KindSummary>,
    /// The lights with the highest irradiance, at most 16.
    pub lights: Vec<LightSummary>,
    /// Number of all lights and emissive shapes.
    pub emitters: usize,
}

pub(super) fn of(e: &Evidence<'_>) -> Summary {
    let p = &e.picture;
    let shown = [0.05, 0.5, 0.95].map(|q| quantile(p.shown.iter().copied(), q));
    let fraction = |v: f64, i: usize| if e.all[i] > 0.0 { v / e.all[i] } else { 0.0 };
    let mut kinds: Vec<KindSummary> = e
        .by_kind
        .iter()
        .map(|(kind, sums)| KindSummary {
            kind: *kind,
            light: fraction(sums[0], 0),
            variance: fraction(sums[1], 1),
        })
        .collect();
    kinds.sort_by(|a, b| b.variance.total_cmp(&a.variance).then(a.kind.cmp(&b.kind)));
    let mut lights: Vec<LightSummary> =
        e.g.lights
            .iter()
            .map(|l| {
                let source = match l.emitter {
                    ListedEmitter::Light(i) => super::Source::Light(i),
                    ListedEmitter::Shape { primitive, .. } => super::Source::Object(primitive),
                };
                let sums = e.by_source.get(&source);
                let traced = !e.g.paths.is_empty();
                LightSummary {
                    name: e.emitter_name(l.emitter).text,
                    irradiance: l.irradiance,
                    blocked_irradiance: l.blocked_irradiance,
                    reaches: f64::from(l.visible) / f64::from(l.sampled.max(1)),
                    light: traced.then(|| sums.map_or(0.0, |s| fraction(s[0], 0))),
                    variance: traced.then(|| sums.map_or(0.0, |s| fraction(s[1], 1))),
                }
            })
            .collect();
    lights.sort_by(|a, b| {
        b.irradiance
            .total_cmp(&a.irradiance)
            .then(b.blocked_irradiance.total_cmp(&a.blocked_irradiance))
            .then(a.name.cmp(&b.name))
    });
    // List the emissive faces of a box as one light.
    lights.dedup_by(|a, b| a.name == b.name);
    lights.truncate(16);
    let paths = e.sum(|p| f64::from(p.samples));
    let traced = paths > 0.0;
    let trees = e.g.trees.unwrap_or_default();
    let per = |of_paths: f64, of_trees: u64| {
        if traced { of_paths / paths } else { of_trees as f64 / trees.samples.max(1) as f64 }
    };
    let rays = e.g.first_hits.iter().flatten().count().max(1) as f64;
    Summary {
        pixels: e.g.pixels.len() as u32,
        samples: e.g.paths.iter().flatten().map(|p| p.samples).max().unwrap_or(1),
        complete: e.g.complete,
        shown,
        white: p.white,
        hit_fraction: e.hit_fraction,
        black: e.is_black(),
        error: traced.then(|| e.variance / f64::from(e.samples())),
        samples_wanted: traced.then(|| (e.variance / 0.01).ceil().max(1.0) as u64),
        surfaces_per_sample: per(e.sum(|p| p.vertices as f64), trees.rays),
        shadow_rays_per_sample: per(e.sum(|p| p.shadow_rays as f64), trees.shadow_rays),
        steps_per_ray: e.g.first_hits.iter().flatten().map(|s| s.steps as f64).sum::<f64>() / rays,
        kinds,
        lights,
        emitters: e.g.emitters,
    }
}
