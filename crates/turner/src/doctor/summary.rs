//! What was measured, in short.

use super::evidence::Evidence;
use super::kind::PathKind;
use super::picture::quantile;
use crate::scene::ListedEmitter;

/// Of one sort of path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KindShare {
    /// The sort.
    pub kind: PathKind,
    /// Its share of the light in the picture, 0 to 1.
    pub light: f64,
    /// Its share of the variance: that of its covariance with the whole, so that shares sum to 1. Where sorts make up for each other one may be below 0.
    pub variance: f64,
}

/// Of one light, or shape that shines.
#[derive(Clone, Debug, PartialEq)]
pub struct LightShare {
    /// Its name.
    pub name: String,
    /// Mean irradiance (luminance) on the surfaces that are seen: that arrives, and that something keeps off.
    pub arrives: f64,
    /// See `arrives`.
    pub kept_off: f64,
    /// Share of points of these surfaces that it reaches.
    pub reaches: f64,
    /// Its share of the light in the picture, where paths were followed.
    pub light: Option<f64>,
    /// Its share of the variance.
    pub variance: Option<f64>,
}

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Pixels and samples of each.
    pub pixels: u32,
    /// See `pixels`.
    pub samples: u32,
    /// Whether there was time for all of them.
    pub complete: bool,
    /// Brightness as shown (0 to 1, values in the file): of a twentieth of the pixels, half of them, and all but a twentieth.
    pub shown: [f64; 3],
    /// Share of pixels that are white.
    pub white: f64,
    /// Share of camera rays that meet something.
    pub met: f64,
    /// Whether next to nothing is to be seen.
    pub black: bool,
    /// The error to expect with the picture's samples (relMSE); `None` where paths are not followed.
    pub error: Option<f64>,
    /// Samples per pixel that bring it to 0.01.
    pub samples_wanted: Option<u64>,
    /// Surfaces that a path meets on average, or rays of a classic tree.
    pub surfaces_per_sample: f64,
    /// Rays towards lights per sample.
    pub shadow_rays_per_sample: f64,
    /// Boxes and shapes that the search for a camera ray's hit goes through.
    pub steps_per_ray: f64,
    /// Light and variance by sort of path, the most variance first.
    pub kinds: Vec<KindShare>,
    /// Lights, those first that bring most; at most 16.
    pub lights: Vec<LightShare>,
    /// Things that shine, in all.
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
                    name: e.emitter_name(l.one),
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
    // The faces of a box are one.
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
