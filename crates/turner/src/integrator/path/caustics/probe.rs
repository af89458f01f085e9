//! What light paths would bring to a picture, and at what price: measured by a few of them and a few camera paths, the same on every run.

use std::sync::Arc;

use super::light::LightWave;
use super::photons::{Photon, PhotonMap};
use super::plan::Plan;
use crate::integrator::path::Context;
use crate::integrator::path::record::Off;
use crate::integrator::path::wave::Wave;
use crate::integrator::{CameraSamples, RayStats, Tracer};
use crate::math::DVec2;
use crate::sampler::SampleId;
use crate::view::{View, take_points};

/// Cells of the picture along its sides, pixels looked at in each, and camera paths in each pixel.
const SIDE: u32 = 16;
const PIXELS: u32 = 2;
const SAMPLES: u32 = 2;

/// Light paths: so many, and again so many if those leave any doubt.
const PATHS: u32 = 2048;
const MORE: u32 = 6 * PATHS;

/// The share of the picture's light that caustics must have to count.
const LEAST: f64 = 1e-3;

/// Where it is dark, errors count by the mean luminance: by so much of its square.
const DARK: f64 = 0.1;

/// How many times fewer samples must be needed for the same noise and time.
const GAIN: f64 = 0.9;

/// Light paths to each camera path that are considered.
const RATIOS: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0];

/// What a ray of a light path and a surface that scatters one take, in rays of camera paths with all that belongs to them: measured.
const RAY: f64 = 0.4;
const SCATTERING: f64 = 2.2;

/// The same for a thin film, whose interference colours are costly. It counts only for the reported price, which is right within a factor of about 2: measured with mirrors
/// with thin films and with IridescenceSuzanne of glTF's sample models.
const FILM: f64 = 6.0;

/// The samples of a picture are spread evenly, those of the probe are not: what is left of the variance of so many camera paths, and of light paths. Measured.
const EVEN: f64 = 0.25;
const EVEN_LIGHT: f64 = 0.1;

/// How many times fewer photons count for a sample than for the first one, after some dozens: the radius shrinks.
const SHRUNK: f64 = 2.0;

/// The picture as some camera paths see it.
struct Look {
    /// Luminance of each cell.
    cells: Vec<f64>,
    /// What is added to the square of a luminance before squares of errors are divided by it.
    dark: f64,
    /// Square of the relative error of a sample.
    variance: f64,
    /// Rays of a path.
    rays: f64,
}

/// What was found.
pub(super) struct Found {
    /// The best number of light paths to each camera path; without photons and with them.
    pub(super) ratio: f64,
    pub(super) ratio_with_photons: f64,
    /// Whether they pay.
    pub(super) pays: bool,
    /// Work for the same noise, over that without light paths; `None` where they bring light that nothing else does.
    pub(super) gain: Option<f64>,
    /// Work of a light path, in that of a camera path with all that belongs to it.
    pub(super) price: f64,
    /// Fractions of the picture's light: what light paths bring, what camera paths never find, what photons bring.
    pub(super) brings: f64,
    pub(super) alone: f64,
    pub(super) by_photons: f64,
    /// For each group, how often it should be chosen.
    pub(super) groups: Vec<f64>,
}

/// Sums over light paths.
#[derive(Default)]
struct Brought {
    paths: f64,
    /// Light that arrives at the camera.
    light: f64,
    /// Of that what camera paths never find.
    alone: f64,
    /// Squares of relative contributions: of light paths, weighed, and of camera paths that find the same.
    squares: f64,
    squares_by_chance: f64,
    of_group: Vec<f64>,
}

impl Look {
    fn new(context: Context<'_>, plan: &Plan) -> Look {
        let mut wave = Wave::new(Context { plan: Some(plan), ..context }, Off);
        let (values, rays) = Look::trace(context.view, &mut wave);
        let each = (PIXELS * SAMPLES) as usize;
        let cells: Vec<f64> =
            values.chunks(each).map(|cell| cell.iter().sum::<f64>() / cell.len() as f64).collect();
        let mut look = Look { cells, dark: 0.0, variance: 0.0, rays };
        look.dark = DARK * look.mean() * look.mean();
        let mut variance = 0.0;
        for (cell, mean) in values.chunks(each).zip(&look.cells) {
            // Of paths through one pixel: what the picture shows is no noise.
            let spread: f64 = cell.chunks(SAMPLES as usize).map(spread).sum();
            variance += spread / f64::from(PIXELS) / (mean * mean + look.dark).max(f64::MIN_POSITIVE);
        }
        look.variance = variance / look.cells.len().max(1) as f64;
        look
    }

    /// The luminance of camera paths, and their rays on average.
    fn trace(view: &View, wave: &mut Wave<'_, Off>) -> (Vec<f64>, f64) {
        let film = &view.film;
        let (mut samples, mut out, mut stats) = (CameraSamples::default(), Vec::new(), RayStats::default());
        let size = DVec2::new(f64::from(film.width), f64::from(film.height)) / f64::from(SIDE);
        let points = (0..SIDE * SIDE * PIXELS * SAMPLES).map(|i| {
            let pixel = i / SAMPLES;
            let cell = pixel / PIXELS;
            let of_pixel = SampleId { x: cell % SIDE, y: cell / SIDE, index: pixel % PIXELS, seed: 0x51de };
            let id = SampleId { index: i % (PIXELS * SAMPLES), seed: 0x9e37_79b9, ..of_pixel };
            let corner = DVec2::new(f64::from(id.x), f64::from(id.y));
            let place = ((corner + of_pixel.unit_square(0)) * size).floor();
            (id, place + id.unit_square(0))
        });
        take_points(view, &mut samples, points);
        wave.radiance(&samples, &mut out, &mut stats);
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let values: Vec<f64> = out.iter().map(|r| finite(f64::from(r.color.luminance()))).collect();
        let rays = stats.total() as f64 / values.len().max(1) as f64;
        (values, rays)
    }

    /// The luminance that these photons of some light paths bring on average, over that of the picture, and about the square of their relative error if there are as many light paths as in the plan.
    fn photons(&self, context: Context<'_>, plan: &Plan, photons: Vec<Photon>, paths: f64) -> (f64, f64) {
        /// How many times farther than in a picture photons count, for there are few.
        const WIDER: f64 = 8.0;
        if photons.is_empty() {
            return (0.0, 0.0);
        }
        let few = Plan { paths: paths as u64, first_radius: WIDER * plan.first_radius, ..plan.clone() };
        let mut wave = Wave::new(Context { plan: Some(&few), ..context }, Off);
        wave.find_photons(Arc::new(PhotonMap::new(&few, 0, photons)));
        let (values, _) = Look::trace(context.view, &mut wave);
        let (n, mean) = (values.len().max(1) as f64, self.mean().max(1e-30));
        let more = plan.paths as f64 / (paths * WIDER * WIDER * SHRUNK);
        (wave.by_photons / (n * mean), wave.photon_variance / (n * mean * mean * more))
    }

    fn mean(&self) -> f64 {
        self.cells.iter().sum::<f64>() / self.cells.len().max(1) as f64
    }

    /// What a square of luminance at a place of the picture counts.
    fn weight(&self, place: DVec2) -> f64 {
        let cell = place * f64::from(SIDE);
        let at = |v: f64| (v.max(0.0) as u32).min(SIDE - 1);
        let value = self.cells.get((at(cell.y) * SIDE + at(cell.x)) as usize).copied().unwrap_or(0.0);
        1.0 / (value * value + self.dark).max(f64::MIN_POSITIVE)
    }
}

/// The variance of a few values.
fn spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n.max(1.0);
    values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0).max(1.0)
}

/// Measures for a plan with as many light paths as pixels.
pub(super) fn probe(context: Context<'_>, plan: &Plan) -> Found {
    let view = context.view;
    let pixels = f64::from(view.film.width) * f64::from(view.film.height);
    let size = DVec2::new(f64::from(view.film.width), f64::from(view.film.height));
    let mut wave = LightWave::new(context, plan);
    let mut brought = Brought { of_group: vec![0.0; plan.casters.len()], ..Brought::default() };
    let mut stats = RayStats::default();
    let mut look = None;
    // Numbers that no picture gets to.
    let mut first = u64::MAX / 2;
    for count in [PATHS, MORE] {
        brought.paths += f64::from(count);
        let look = look.get_or_insert_with(|| Look::new(context, plan));
        let mut photons = wave.take_photons();
        wave.advance(first, count, &mut stats, |splat, weight, group| {
            let value = f64::from(splat.color.luminance());
            if !(value > 0.0 && value.is_finite()) {
                return;
            }
            brought.light += value;
            let square = value * value * look.weight(splat.place / size);
            brought.squares += weight * weight * square;
            // By the power heuristic w = 1/(1 + a² + b²): the other ways together have about √(a² + b²) of the density of all light paths.
            let others = (1.0 / weight - 1.0).max(0.0).sqrt();
            match others > 1e-12 {
                true => brought.squares_by_chance += square / (others * plan.paths as f64),
                false => brought.alone += value,
            }
            if let Some(sum) = brought.of_group.get_mut(group as usize) {
                *sum += weight * weight * square;
            }
        });
        photons.append(&mut wave.photons);
        wave.photons = photons;
        first += u64::from(count);
        // Little light, and little noise of it even if some rare bright path was missed.
        let share = brought.light / (brought.paths * pixels) / look.mean().max(1e-30);
        let noise = brought.squares_by_chance / (brought.paths * pixels);
        if share < LEAST && noise < 0.01 * look.variance {
            break;
        }
    }
    let look = look.unwrap_or_else(|| Look::new(context, plan));
    let n = brought.paths;
    // Per pixel and sample; of light paths with as many as pixels.
    let by_chance = brought.squares_by_chance / (n * pixels);
    let by_light = EVEN_LIGHT * brought.squares / (n * pixels * plan.paths as f64);
    let price = (RAY * stats.light as f64 + SCATTERING * wave.scattered as f64) / n / look.rays.max(1.0);
    let with_films = price + FILM * wave.films as f64 / n / look.rays.max(1.0);
    let of_picture = |light: f64| light / (n * pixels) / look.mean().max(1e-30);
    let (alone, brings) = (of_picture(brought.alone), of_picture(brought.light));
    let ratio_of = plan.paths as f64 / pixels;
    // Light of narrow lobes is found in other ways as well: by itself it is no reason for photons.
    let mut photons = wave.take_photons();
    photons.retain(|photon| photon.by_delta);
    let (by_photons, of_photons) = look.photons(context, plan, photons, n);
    // The square of the error and the time of a sample, one times the other.
    let cost = |ratio: f64, more: f64| {
        (EVEN * look.variance + (by_light + more) * ratio_of / ratio) * (1.0 + price * ratio)
    };
    let best = |more: f64| {
        RATIOS.into_iter().min_by(|a, b| cost(*a, more).total_cmp(&cost(*b, more))).unwrap_or(1.0)
    };
    let (ratio, ratio_with_photons) = (best(0.0), best(of_photons));
    let gain = cost(ratio, 0.0) / (EVEN * (look.variance + by_chance));
    let pays = alone > LEAST || gain < GAIN;
    let gain = (alone <= LEAST).then_some(gain);
    let groups =
        (0u32..).zip(&brought.of_group).map(|(g, m)| (m * plan.casters.probability(g)).sqrt()).collect();
    Found { ratio, ratio_with_photons, pays, gain, price: with_films, brings, alone, by_photons, groups }
}
