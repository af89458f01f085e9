//! Whether neighbours' paths make up for the shadow rays that join them: measured by a few paths, the same on every run.

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

/// Groups that are looked at, along the picture's width and height.
const SIDE: u32 = 8;

/// What a shadow ray between neighbours takes, in rays of paths with all that belongs to them: measured.
const PRICE: f64 = 0.45;

/// Where it is dark, errors count by the mean luminance: by so much of its square.
const DARK: f64 = 0.1;

/// How much of the work for the same noise may be left.
const GAIN: f64 = 0.95;

/// Looks at a picture, each at other groups, until it is clear whether there is a gain.
const PLACES: [[u32; 2]; 4] = [[4, 4], [0, 2], [6, 0], [2, 6]];

/// From here to its inverse a gain is in doubt.
const DOUBT: f64 = 0.7;

/// Samples of pixels, two of each, with the rays they took.
#[derive(Default)]
struct PilotRun {
    groups: Vec<Vec<[f64; 2]>>,
    rays: f64,
}

/// Decides whether pixels use one another's paths. If these help more than light paths that are a matter of choice, they take their place. Gives the light
/// paths that are left, and whether paths are shared.
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
    // Scenes in which probes would take long do without.
    let gains = |least: f64| is_cheap(scene, view) && gain(context) < least.min(GAIN);
    match suits && least.is_some_and(gains) {
        true => (None, true),
        false => (strategy, false),
    }
}

/// Work for the same noise, over that of paths which keep to themselves; infinite where there is no noise.
fn gain(context: Context<'_>) -> f64 {
    let (mut specular_bounce, mut together) = (PilotRun::default(), PilotRun::default());
    let mut gain = f64::INFINITY;
    for place in PLACES {
        specular_bounce.add(context, place, false);
        together.add(context, place, true);
        // Of whole groups: of few samples of one pixel one that is far from the mean would make it its own.
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

/// Of all samples of a group.
fn mean(specular_bounce: &[[f64; 2]], together: &[[f64; 2]]) -> f64 {
    let sum: f64 = specular_bounce.iter().chain(together).flatten().sum();
    sum / (2 * (specular_bounce.len() + together.len())).max(1) as f64
}

impl PilotRun {
    /// Squares of what samples of a pixel differ by, over those of their groups.
    fn noise(&self, squares: &[f64]) -> f64 {
        let of_group = |group: &[[f64; 2]]| group.iter().map(|[a, b]| (a - b) * (a - b)).sum::<f64>();
        let terms = self.groups.iter().zip(squares).filter(|(_, square)| **square > 0.0);
        terms.map(|(group, square)| of_group(group) / square).sum()
    }

    /// Looks at groups all over the picture, those at a place in eighths of the way from one to the next.
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
