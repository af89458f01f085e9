//! The pilot run for caustics: how much light and noise light paths account for, and what they cost. A few light paths
//! and camera paths with fixed seeds measure both, so the result is the same on every run.

use std::sync::Arc;

use super::light_path_batch::LightPathBatch;
use super::photons::{Photon, PhotonMap};
use super::strategy::CausticsStrategy;
use crate::integrator::path::Context;
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Off;
use crate::integrator::{CameraSamples, RayStats, Tracer};
use crate::math::DVec2;
use crate::sampler::SampleId;
use crate::view::{View, take_points};

/// Cells along each side of the image, pixels per cell, and samples per pixel.
const SIDE: u32 = 16;
const PIXELS: u32 = 2;
const SAMPLES: u32 = 2;

/// Number of light paths, and of additional ones if those leave any doubt.
const PATHS: u32 = 2048;
const MORE: u32 = 6 * PATHS;

/// Minimum fraction of the image's light for caustics to count.
const MIN_FRACTION: f64 = 1e-3;

/// In dark cells errors are relative to the mean luminance: this fraction of its square is added.
const DARK: f64 = 0.1;

/// Maximum cost for the same noise, relative to no light paths, at which light paths pay. The estimate is right within a
/// factor of 1.5 or so, and where nothing is gained nothing should be lost.
const MAX_COST: f64 = 0.6;

/// Numbers of light paths per camera path that are considered.
const RATIOS: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0];

/// Cost of the start of a light path, of its ray and of a scattering event on it, in rays of camera paths with their
/// shading. Measured; right within a factor of 1.5.
const START_COST: f64 = 0.5;
const RAY_COST: f64 = 1.0;
const SCATTERING_COST: f64 = 2.2;

/// Cost of the reverse densities of a camera path, relative to the path. Measured.
const REVERSE_COST: f64 = 0.08;

/// Further cost of a scattering event on a thin film, whose interference colours are expensive. Right within a factor of
/// about 2; measured with mirrors with thin films and with IridescenceSuzanne of glTF's sample models.
const FILM_COST: f64 = 6.0;

/// The samples of a render are well distributed, those of the probe are not: the fraction of the variance that remains,
/// for camera paths and for light paths. Measured.
const STRATIFIED: f64 = 0.25;
const STRATIFIED_LIGHT: f64 = 0.1;

/// Samples per pixel for which missing light is weighed against noise, where fireflies are removed. A fixed number, so
/// that a picture with more samples continues one with fewer.
const FEW: f64 = 16.0;

/// Contributions that fewer camera paths have are unknown to the pilot run.
const SEEN: f64 = 3.0 / (SIDE * SIDE * PIXELS * SAMPLES) as f64;

/// Factor by which the photons within the radius become fewer after some dozens of samples, because the radius shrinks.
const SHRUNK: f64 = 2.0;

/// The image as a few camera paths see it.
struct PilotRun {
    /// Mean luminance of each cell.
    cells: Vec<f64>,
    /// Added to the square of a luminance before squared errors are divided by it.
    dark: f64,
    /// Squared relative error of a sample.
    variance: f64,
    /// Mean number of rays of a path.
    rays: f64,
}

/// The result.
pub(super) struct ProbeResult {
    /// Best number of light paths per camera path, without photons and with them.
    pub(super) ratio: f64,
    pub(super) ratio_with_photons: f64,
    /// Whether light paths pay.
    pub(super) pays: bool,
    /// Cost for the same noise relative to no light paths; `None` where only light paths find some of the light.
    pub(super) gain: Option<f64>,
    /// Cost of a light path, in camera paths with their shading.
    pub(super) price: f64,
    /// Fractions of the image's light: what light paths contribute, what only they find, what photons contribute.
    pub(super) contribution: f64,
    pub(super) light_paths_only: f64,
    pub(super) by_photons: f64,
    /// The part of the last that camera paths miss without photons.
    pub(super) missed: f64,
    /// For each caustic target, the weight with which to choose it.
    pub(super) groups: Vec<f64>,
}

/// Sums over light paths.
#[derive(Default)]
struct LightPathSums {
    paths: f64,
    /// Light that arrives at the camera.
    light: f64,
    /// The part of it that camera paths never find.
    light_paths_only: f64,
    /// Squared relative contributions: of light paths with their MIS weights, and of camera paths that find the same
    /// light.
    squares: f64,
    squares_camera: f64,
    /// Of those of camera paths, each square and the number of camera paths, of one per pixel, that have it.
    camera: Vec<[f64; 2]>,
    of_group: Vec<f64>,
    /// For each cell of the image: light and its squares.
    of_cell: Vec<[f64; 2]>,
}

impl LightPathSums {
    /// Variance that the light of light paths adds to a sample if camera paths alone must find it. `seen`: the part of it
    /// that the camera paths of the pilot run have. It limits frequent contributions, whose variance is below their mean
    /// square.
    fn variance_without(&mut self, seen: impl FnOnce() -> f64, pixels: f64) -> f64 {
        self.camera.sort_by(|[a, _], [b, _]| b.total_cmp(a));
        let scale = 1.0 / (self.paths * pixels);
        let (mut rare, mut frequent) = (0.0, 0.0);
        // The number of contributions per camera path so far, the greatest first.
        let mut rate = 0.0;
        for [square, number] in &self.camera {
            let sum = if rate < SEEN { &mut rare } else { &mut frequent };
            *sum += square * number * scale;
            rate += number * scale;
        }
        if frequent > 0.0 { rare + frequent.min(seen()) } else { rare }
    }

    /// Mean square over the image of the light of light paths, each relative to the light of its cell.
    fn bias(&self, pilot: &PilotRun, pixels: f64) -> f64 {
        let cells = self.of_cell.len().max(1) as f64;
        let scale = cells / (self.paths * pixels);
        let of = |([light, squares], mean): (&[f64; 2], &f64)| {
            // Without the products of a value with itself, which are noise.
            (light * light - squares) * scale * scale / (mean * mean + pilot.dark).max(f64::MIN_POSITIVE)
        };
        (self.of_cell.iter().zip(&pilot.cells).map(of).sum::<f64>() / cells).max(0.0)
    }
}

impl PilotRun {
    fn new(context: Context<'_>, strategy: Option<&CausticsStrategy>) -> PilotRun {
        let mut batch = PathBatch::new(Context { strategy, ..context }, Off);
        let (values, rays) = PilotRun::trace(context.view, &mut batch);
        let each = (PIXELS * SAMPLES) as usize;
        let cells: Vec<f64> =
            values.chunks(each).map(|cell| cell.iter().sum::<f64>() / cell.len() as f64).collect();
        let mut pilot = PilotRun { cells, dark: 0.0, variance: 0.0, rays };
        pilot.dark = DARK * pilot.mean() * pilot.mean();
        let mut variance = 0.0;
        for (cell, mean) in values.chunks(each).zip(&pilot.cells) {
            // Variance within one pixel: differences between pixels are not noise.
            let spread: f64 = cell.chunks(SAMPLES as usize).map(spread).sum();
            variance += spread / f64::from(PIXELS) / (mean * mean + pilot.dark).max(f64::MIN_POSITIVE);
        }
        pilot.variance = variance / pilot.cells.len().max(1) as f64;
        pilot
    }

    /// Luminance of each camera path, and their mean number of rays.
    fn trace(view: &View, batch: &mut PathBatch<'_, Off>) -> (Vec<f64>, f64) {
        let film = &view.film;
        let (mut samples, mut out, mut stats) = (CameraSamples::default(), Vec::new(), RayStats::default());
        let size = DVec2::new(f64::from(film.width), f64::from(film.height)) / f64::from(SIDE);
        let points = (0..SIDE * SIDE * PIXELS * SAMPLES).map(|i| {
            let pixel = i / SAMPLES;
            let cell = pixel / PIXELS;
            let of_pixel = SampleId { x: cell % SIDE, y: cell / SIDE, index: pixel % PIXELS, seed: 0x51de };
            let id = SampleId { index: i % (PIXELS * SAMPLES), seed: 0x9e37_79b9, ..of_pixel };
            let corner = DVec2::new(f64::from(id.x), f64::from(id.y));
            let position = ((corner + of_pixel.unit_square(0)) * size).floor();
            (id, position + id.unit_square(0))
        });
        take_points(view, &mut samples, points);
        batch.radiance(&samples, &mut out, &mut stats);
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let values: Vec<f64> = out.iter().map(|r| finite(f64::from(r.color.luminance()))).collect();
        let rays = stats.total() as f64 / values.len().max(1) as f64;
        (values, rays)
    }

    /// Mean luminance contributed by these photons of a few light paths, relative to the image, the approximate square of
    /// its relative error with the strategy's number of light paths, and the part of it that the camera paths of the pilot
    /// run did not find without photons.
    fn photons(
        &self,
        context: Context<'_>,
        strategy: &CausticsStrategy,
        photons: Vec<Photon>,
        paths: f64,
    ) -> (f64, f64, f64) {
        /// Factor on the radius, because there are few photons.
        const WIDER: f64 = 8.0;
        if photons.is_empty() {
            return (0.0, 0.0, 0.0);
        }
        let pilot_strategy = CausticsStrategy {
            paths: paths as u64,
            first_radius: WIDER * strategy.first_radius,
            ..strategy.clone()
        };
        let mut batch = PathBatch::new(Context { strategy: Some(&pilot_strategy), ..context }, Off);
        batch.find_photons(Arc::new(PhotonMap::new(&pilot_strategy, 0, photons)));
        let (values, _) = PilotRun::trace(context.view, &mut batch);
        let (n, mean) = (values.len().max(1) as f64, self.mean().max(1e-30));
        let photons_ratio = strategy.paths as f64 / (paths * WIDER * WIDER * SHRUNK);
        let by_photons = batch.by_photons / n;
        // With photons camera paths omit what photons count.
        let more = values.iter().sum::<f64>() / n - self.mean();
        let missed = (more / by_photons.max(1e-30)).clamp(0.0, 1.0);
        (by_photons / mean, batch.photon_variance / (n * mean * mean * photons_ratio), missed)
    }

    fn mean(&self) -> f64 {
        self.cells.iter().sum::<f64>() / self.cells.len().max(1) as f64
    }

    /// Weight of a squared luminance in a cell.
    fn weight(&self, cell: usize) -> f64 {
        let value = self.cells.get(cell).copied().unwrap_or(0.0);
        1.0 / (value * value + self.dark).max(f64::MIN_POSITIVE)
    }
}

/// The cell at a position of the image, given in 0..1.
fn cell_at(position: DVec2) -> usize {
    let cell = position * f64::from(SIDE);
    let at = |v: f64| (v.max(0.0) as u32).min(SIDE - 1);
    (at(cell.y) * SIDE + at(cell.x)) as usize
}

/// Sample variance.
fn spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n.max(1.0);
    values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0).max(1.0)
}

/// Cost of a light path in rays of camera paths, when targets are chosen by these weights: paths to targets that matter may
/// be longer than most.
fn price_of(context: Context<'_>, strategy: &CausticsStrategy, groups: &[f64]) -> f64 {
    let mut strategy = strategy.clone();
    let _ = strategy.caustic_targets.choose_by(groups);
    let mut batch = LightPathBatch::new(context, &strategy);
    let mut stats = RayStats::default();
    batch.advance(u64::MAX / 4, PATHS, &mut stats, |_, _, _| {});
    let (rays, n) = (stats.light as f64, f64::from(PATHS));
    let scatterings = SCATTERING_COST * batch.scatterings as f64 + FILM_COST * batch.films as f64;
    START_COST + (RAY_COST * rays + scatterings) / n
}

/// Measures a strategy that has as many light paths as pixels.
pub(super) fn probe(context: Context<'_>, strategy: &CausticsStrategy) -> ProbeResult {
    let view = context.view;
    let pixels = f64::from(view.film.width) * f64::from(view.film.height);
    let size = DVec2::new(f64::from(view.film.width), f64::from(view.film.height));
    let mut batch = LightPathBatch::new(context, strategy);
    let mut sums = LightPathSums {
        of_group: vec![0.0; strategy.caustic_targets.len()],
        of_cell: vec![[0.0; 2]; (SIDE * SIDE) as usize],
        ..LightPathSums::default()
    };
    let mut stats = RayStats::default();
    let mut pilot = None;
    // Indices that no render reaches.
    let mut first = u64::MAX / 2;
    for count in [PATHS, MORE] {
        sums.paths += f64::from(count);
        let pilot = pilot.get_or_insert_with(|| PilotRun::new(context, Some(strategy)));
        let mut photons = batch.take_photons();
        batch.advance(first, count, &mut stats, |splat, weight, group| {
            let value = f64::from(splat.color.luminance());
            if !(value > 0.0 && value.is_finite()) {
                return;
            }
            sums.light += value;
            let cell = cell_at(splat.place / size);
            let square = value * value * pilot.weight(cell);
            if let Some([light, squares]) = sums.of_cell.get_mut(cell) {
                *light += value;
                *squares += value * value;
            }
            sums.squares += weight * weight * square;
            // From the power heuristic w = 1/(1 + a² + b²): the other strategies together have about √(a² + b²) times
            // the density of all light paths.
            let others = (1.0 / weight - 1.0).max(0.0).sqrt();
            match others > 1e-12 {
                true => {
                    let number = others * strategy.paths as f64;
                    sums.squares_camera += square / number;
                    sums.camera.push([square / (number * number), number]);
                }
                false => sums.light_paths_only += value,
            }
            if let Some(sum) = sums.of_group.get_mut(group as usize) {
                *sum += weight * weight * square;
            }
        });
        photons.append(&mut batch.photons);
        batch.photons = photons;
        first += u64::from(count);
        // Stop if there is little light, and little noise from it even if a rare bright path was missed.
        let fraction = sums.light / (sums.paths * pixels) / pilot.mean().max(1e-30);
        let noise = sums.squares_camera / (sums.paths * pixels);
        if fraction < MIN_FRACTION && noise < 0.01 * pilot.variance {
            break;
        }
    }
    let pilot = pilot.unwrap_or_else(|| PilotRun::new(context, Some(strategy)));
    let n = sums.paths;
    // Variance per pixel and sample; for light paths, with as many as pixels.
    let seen = || (PilotRun::new(context, None).variance - pilot.variance).max(0.0);
    let variance_camera = sums.variance_without(seen, pixels);
    let variance_light = STRATIFIED_LIGHT * sums.squares / (n * pixels * strategy.paths as f64);
    let groups: Vec<f64> = (0u32..)
        .zip(&sums.of_group)
        .map(|(g, m)| (m * strategy.caustic_targets.probability(g)).sqrt())
        .collect();
    let price = price_of(context, strategy, &groups) / pilot.rays.max(1.0);
    let of_image = |light: f64| light / (n * pixels) / pilot.mean().max(1e-30);
    let (light_paths_only, contribution) = (of_image(sums.light_paths_only), of_image(sums.light));
    let ratio_of = strategy.paths as f64 / pixels;
    // Light of near-specular lobes is found by other strategies too, and is no reason for photons.
    let mut photons = batch.take_photons();
    photons.retain(|photon| photon.by_delta);
    let (by_photons, of_photons, missed) = pilot.photons(context, strategy, photons, n);
    // Squared error times time per sample.
    let cost = |ratio: f64, photon_variance: f64| {
        (STRATIFIED * pilot.variance + (variance_light + photon_variance) * ratio_of / ratio)
            * (1.0 + REVERSE_COST + price * ratio)
    };
    let best = |photon_variance: f64| {
        RATIOS
            .into_iter()
            .min_by(|a, b| cost(*a, photon_variance).total_cmp(&cost(*b, photon_variance)))
            .unwrap_or(1.0)
    };
    let (ratio, ratio_with_photons) = (best(0.0), best(of_photons));
    let mut of_camera = STRATIFIED * variance_camera;
    if view.film.removes_fireflies() {
        // What is rare is removed: its light is missing, but does not make noise.
        of_camera = of_camera.min(FEW * sums.bias(&pilot, pixels));
    }
    let gain = cost(ratio, 0.0) / (STRATIFIED * pilot.variance + of_camera);
    let pays = light_paths_only > MIN_FRACTION || gain < MAX_COST;
    let gain = (light_paths_only <= MIN_FRACTION).then_some(gain);
    ProbeResult {
        ratio,
        ratio_with_photons,
        pays,
        gain,
        price,
        contribution,
        light_paths_only,
        by_photons,
        missed,
        groups,
    }
}
