//! The pilot run for shared paths: whether they reduce noise enough to pay for their shadow rays. A few paths with
//! fixed seeds measure it, so the result is the same on every run.

use super::{CELL, SharedPaths, group};
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::probing::is_cheap;
use crate::integrator::path::record::Off;
use crate::integrator::path::settings::Settings;
use crate::integrator::path::{CausticsStrategy, Context, PathDesc, SharedPathsMode};
use crate::integrator::{CameraSamples, RayStats, Tracer};
use crate::sampler::SampleId;
use crate::scene::Scene;
use crate::view::{View, place_of, take_points};

/// Clusters that are measured, along the width and height of the image.
const SIDE: u32 = 8;

/// Cost of a shadow ray that joins two paths, in rays of paths with their shading. Measured.
const PRICE: f64 = 0.45;

/// In dark clusters errors are relative to the mean luminance: this fraction of its square is added.
const DARK: f64 = 0.1;

/// Maximum cost for the same noise, relative to separate paths.
const GAIN: f64 = 0.95;

/// Passes over the image, each with other clusters, until the result is clear.
const PLACES: [[u32; 2]; 4] = [[4, 4], [0, 2], [6, 0], [2, 6]];

/// A result between this and its inverse is in doubt.
const DOUBT: f64 = 0.7;

/// Luminances of pixels, two samples of each, and the number of rays traced.
#[derive(Default)]
struct PilotRun {
    groups: Vec<Vec<[f64; 2]>>,
    rays: f64,
}

/// Decides whether paths are shared. If that gains more than optional light paths, it replaces them. Returns the
/// remaining light paths, and whether paths are shared.
pub(in crate::integrator::path) fn decide(
    scene: &Scene,
    view: &View,
    desc: &PathDesc,
    strategy: Option<CausticsStrategy>,
) -> (Option<CausticsStrategy>, bool) {
    let settings = Settings::path(desc);
    if !settings.shared_paths {
        return (strategy, false);
    }
    let suits = SharedPaths::suits(scene, view);
    if desc.shared_paths == SharedPathsMode::Always {
        let shares = suits && strategy.is_none();
        return (strategy, shares);
    }
    let least = strategy.as_ref().map_or(Some(GAIN), |strategy| strategy.gain);
    let context = Context { scene, view, settings, strategy: None, shares: false };
    // Scenes with expensive rays are not probed.
    let gains = |least: f64| is_cheap(scene, view) && gain(context) < least.min(GAIN);
    match suits && least.is_some_and(gains) {
        true => (None, true),
        false => (strategy, false),
    }
}

/// Cost for the same noise relative to separate paths; infinite where there is no noise.
fn gain(context: Context<'_>) -> f64 {
    let (mut specular_bounce, mut together) = (PilotRun::default(), PilotRun::default());
    let mut gain = f64::INFINITY;
    for place in PLACES {
        specular_bounce.add(context, place, false);
        together.add(context, place, true);
        // The mean is that of a cluster: with a few samples of one pixel an outlier would dominate its own mean.
        let means: Vec<f64> =
            specular_bounce.groups.iter().zip(&together.groups).map(|(a, b)| mean(a, b)).collect();
        let all = means.iter().sum::<f64>() / means.len().max(1) as f64;
        let squares: Vec<f64> = means.iter().map(|mean| mean * mean + DARK * all * all).collect();
        let joined = (together.rays - specular_bounce.rays).max(0.0) / specular_bounce.rays;
        let (specular_bounce, together) = (specular_bounce.noise(&squares), together.noise(&squares));
        gain = if specular_bounce > 0.0 {
            together * (1.0 + PRICE * joined) / specular_bounce
        } else {
            f64::INFINITY
        };
        if joined == 0.0 || !(DOUBT..1.0 / DOUBT).contains(&gain) {
            break;
        }
    }
    gain
}

/// Mean luminance of all samples of a cluster.
fn mean(specular_bounce: &[[f64; 2]], together: &[[f64; 2]]) -> f64 {
    let sum: f64 = specular_bounce.iter().chain(together).flatten().sum();
    sum / (2 * (specular_bounce.len() + together.len())).max(1) as f64
}

impl PilotRun {
    /// Squared differences of the two samples of each pixel, relative to `squares` of their cluster.
    fn noise(&self, squares: &[f64]) -> f64 {
        let of_group = |group: &[[f64; 2]]| group.iter().map(|[a, b]| (a - b) * (a - b)).sum::<f64>();
        let terms = self.groups.iter().zip(squares).filter(|(_, square)| **square > 0.0);
        terms.map(|(group, square)| of_group(group) / square).sum()
    }

    /// Measures clusters all over the image, offset by `place` in eighths of their distance.
    fn add(&mut self, context: Context<'_>, place: [u32; 2], together: bool) {
        let view = context.view;
        let film = &view.film;
        let mut batch = PathBatch::new(Context { shares: together, ..context }, Off);
        for cell in 0..SIDE * SIDE {
            let corner = |n: u32, place: u32, size: u32| {
                let at = (u64::from(size) * u64::from(8 * n + place) / u64::from(8 * SIDE)) as u32;
                at - at % CELL
            };
            let x = corner(cell % SIDE, place[0], film.width);
            let y = corner(cell / SIDE, place[1], film.height);
            let [first, second] = [0x51de, 0x9e37_79b9].map(|seed| {
                let id = SampleId { x, y, index: 0, seed: seed + u64::from(place[0]) };
                let mut samples = CameraSamples::default();
                let points = group(view, id).map(|id| (id, place_of(view, &id).into()));
                take_points(view, &mut samples, points);
                let (mut out, mut stats) = (Vec::new(), RayStats::default());
                batch.radiance(&samples, &mut out, &mut stats);
                self.rays += stats.total() as f64;
                let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
                out.iter().map(|r| finite(f64::from(r.color.luminance()))).collect::<Vec<f64>>()
            });
            self.groups.push(first.into_iter().zip(second).map(|(a, b)| [a, b]).collect());
        }
    }
}
