//! A summary of the measurements.

use super::evidence::Evidence;
use super::kind::PathKind;
use super::picture::quantile;
use crate::scene::ListedEmitter;

/// One kind of path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KindShare {
    /// The kind.
    pub kind: PathKind,
    /// Its fraction of the light in the picture, 0 to 1.
    pub light: f64,
    /// Its fraction of the variance, by its covariance with the complete sample, so that fractions sum to 1. Where kinds are anticorrelated one may be below 0.
    pub variance: f64,
}

/// One light or emissive shape.
#[derive(Clone, Debug, PartialEq)]
pub struct LightShare {
    /// Its name.
    pub name: String,
    /// Mean irradiance (luminance) that arrives at visible surfaces.
    pub arrives: f64,
    /// Mean irradiance that something blocks.
    pub kept_off: f64,
    /// Fraction of points on these surfaces that it reaches.
    pub reaches: f64,
    /// Its fraction of the light in the picture, where paths were traced.
    pub light: Option<f64>,
    /// Its fraction of the variance.
    pub variance: Option<f64>,
}

/// The measurements in short.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Pixels probed.
    pub pixels: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Whether the time was enough for all of them.
    pub complete: bool,
    /// The 5th, 50th and 95th percentile of the pixels' brightness as displayed (0 to 1, values in the file).
    pub shown: [f64; 3],
    /// Fraction of pixels that are white.
    pub white: f64,
    /// Fraction of camera rays that hit something.
    pub met: f64,
    /// Whether almost nothing is visible.
    pub black: bool,
    /// The expected error with the samples of the film (relMSE); `None` where no paths are traced.
    pub error: Option<f64>,
    /// Samples per pixel for an error of 0.01.
    pub samples_wanted: Option<u64>,
    /// Surfaces on a path on average, or rays of a classic ray tree.
    pub surfaces_per_sample: f64,
    /// Shadow rays per sample.
    pub shadow_rays_per_sample: f64,
    /// Boxes and shapes tested per camera ray.
    pub steps_per_ray: f64,
    /// Light and variance by kind of path, the most variance first.
    pub kinds: Vec<KindShare>,
    /// Lights, by irradiance; at most 16.
    pub lights: Vec<LightShare>,
    /// Lights and emissive shapes in all.
    pub emitters: usize,
}

pub(super) fn of(e: &Evidence<'_>) -> Summary {
    let p = &e.picture;
    let shown = [0.05, 0.5, 0.95].map(|q| quantile(p.shown.iter().copied(), q));
    let share = |v: f64, i: usize| if e.all[i] > 0.0 { v / e.all[i] } else { 0.0 };
    let mut kinds: Vec<KindShare> = e
        .by_kind
        .iter()
        .map(|(kind, sums)| KindShare { kind: *kind, light: share(sums[0], 0), variance: share(sums[1], 1) })
        .collect();
    kinds.sort_by(|a, b| b.variance.total_cmp(&a.variance).then(a.kind.cmp(&b.kind)));
    let mut lights: Vec<LightShare> =
        e.g.lights
            .iter()
            .map(|l| {
                let source = match l.one {
                    ListedEmitter::Light(i) => super::Source::Light(i),
                    ListedEmitter::Shape { primitive, .. } => super::Source::Object(primitive),
                };
                let sums = e.by_source.get(&source);
                let followed = !e.g.paths.is_empty();
                LightShare {
                    name: e.emitter_name(l.one).text,
                    arrives: l.arrives,
                    kept_off: l.kept_off,
                    reaches: f64::from(l.clear) / f64::from(l.asked.max(1)),
                    light: followed.then(|| sums.map_or(0.0, |s| share(s[0], 0))),
                    variance: followed.then(|| sums.map_or(0.0, |s| share(s[1], 1))),
                }
            })
            .collect();
    lights.sort_by(|a, b| {
        b.arrives.total_cmp(&a.arrives).then(b.kept_off.total_cmp(&a.kept_off)).then(a.name.cmp(&b.name))
    });
    // The faces of a box are one light.
    lights.dedup_by(|a, b| a.name == b.name);
    lights.truncate(16);
    let paths = e.sum(|p| f64::from(p.samples));
    let followed = paths > 0.0;
    let trees = e.g.trees.unwrap_or_default();
    let per = |of_paths: f64, of_trees: u64| {
        if followed { of_paths / paths } else { of_trees as f64 / trees.samples.max(1) as f64 }
    };
    let rays = e.g.first_hits.iter().flatten().count().max(1) as f64;
    Summary {
        pixels: e.g.pixels.len() as u32,
        samples: e.g.paths.iter().flatten().map(|p| p.samples).max().unwrap_or(1),
        complete: e.g.complete,
        shown,
        white: p.white,
        met: e.met,
        black: e.is_black(),
        error: followed.then(|| e.variance / f64::from(e.samples())),
        samples_wanted: followed.then(|| (e.variance / 0.01).ceil().max(1.0) as u64),
        surfaces_per_sample: per(e.sum(|p| p.vertices as f64), trees.rays),
        shadow_rays_per_sample: per(e.sum(|p| p.shadow_rays as f64), trees.shadow_rays),
        steps_per_ray: e.g.first_hits.iter().flatten().map(|s| s.steps as f64).sum::<f64>() / rays,
        kinds,
        lights,
        emitters: e.g.emitters,
    }
}
