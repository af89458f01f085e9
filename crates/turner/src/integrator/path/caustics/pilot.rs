//! The image as a few camera paths with fixed seeds see it.

use std::sync::Arc;

use super::photons::{Photon, PhotonMap};
use super::strategy::CausticsStrategy;
use crate::integrator::path::Context;
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Off;
use crate::integrator::{CameraSamples, RayStats, Tracer, tasks};
use crate::math::DVec2;
use crate::sampler::SampleId;
use crate::view::take_points;

/// Cells along each side of the image, pixels per cell, and samples per pixel.
pub(super) const SIDE: u32 = 16;
const PIXELS: u32 = 2;
const SAMPLES: u32 = 2;

/// Camera paths that are traced together.
const TOGETHER: u32 = 256;

/// In dark cells errors are relative to the mean luminance: this fraction of its square is added.
const DARK: f64 = 0.1;

/// Contributions per camera path that are rarer than this are unknown to the pilot run.
pub(super) const UNKNOWN: f64 = 3.0 / (SIDE * SIDE * PIXELS * SAMPLES) as f64;

/// Factor by which the photons within the radius become fewer after some dozens of samples, because the radius shrinks.
const SHRUNK: f64 = 2.0;

/// The light of photons.
#[derive(Clone, Copy, Default)]
pub(super) struct PhotonLight {
    /// Mean luminance relative to the image.
    pub(super) light: f64,
    /// Approximate square of its relative error with the strategy's number of light paths.
    pub(super) variance: f64,
    /// The part of it that the camera paths of the pilot run did not find without photons.
    pub(super) missed: f64,
    /// Effective number of photons: so many equal ones are as certain about it.
    pub(super) effective: f64,
}

/// The image as a few camera paths see it.
pub(super) struct PilotRun {
    /// Luminance of each camera path.
    values: Vec<f64>,
    /// Mean luminance of each cell.
    cells: Vec<f64>,
    /// Mean luminance of the image.
    pub(super) mean: f64,
    /// Added to the square of a luminance before squared errors are divided by it.
    dark: f64,
    /// Squared relative error of a sample.
    pub(super) variance: f64,
    /// Mean number of rays of a path.
    pub(super) rays: f64,
}

impl PilotRun {
    pub(super) fn new(context: Context<'_>, strategy: Option<&CausticsStrategy>) -> PilotRun {
        let CameraPaths { values, rays, .. } = trace_camera_paths(Context { strategy, ..context }, None);
        let each = (PIXELS * SAMPLES) as usize;
        let cells: Vec<f64> =
            values.chunks(each).map(|cell| cell.iter().sum::<f64>() / cell.len() as f64).collect();
        PilotRun { values, cells, mean: 0.0, dark: 0.0, variance: 0.0, rays }
    }

    /// Makes errors relative to an image whose mean luminance is at least `light`: that of light paths, which camera paths
    /// may not find.
    pub(super) fn with_light(mut self, light: f64) -> PilotRun {
        self.mean = (self.cells.iter().sum::<f64>() / self.cells.len().max(1) as f64).max(light);
        self.dark = DARK * self.mean * self.mean;
        let mut variance = 0.0;
        for (cell, mean) in self.values.chunks((PIXELS * SAMPLES) as usize).zip(&self.cells) {
            // Variance within one pixel: differences between pixels are not noise.
            let spread: f64 = cell.chunks(SAMPLES as usize).map(spread).sum();
            variance += spread / f64::from(PIXELS) / (mean * mean + self.dark).max(f64::MIN_POSITIVE);
        }
        self.variance = variance / self.cells.len().max(1) as f64;
        self
    }

    /// What these photons of a few light paths contribute.
    pub(super) fn photons(
        &self,
        context: Context<'_>,
        strategy: &CausticsStrategy,
        photons: Vec<Photon>,
        paths: f64,
    ) -> PhotonLight {
        /// Factor on the radius, because there are few photons.
        const WIDER: f64 = 8.0;
        if photons.is_empty() {
            return PhotonLight::default();
        }
        let pilot_strategy = CausticsStrategy {
            paths: paths as u64,
            first_radius: WIDER * strategy.first_radius,
            ..strategy.clone()
        };
        let photons = Arc::new(PhotonMap::new(&pilot_strategy, 0, photons));
        let traced =
            trace_camera_paths(Context { strategy: Some(&pilot_strategy), ..context }, Some(&photons));
        let CameraPaths { values, by_photons, photon_variance, .. } = traced;
        let (n, mean) = (values.len().max(1) as f64, self.mean.max(1e-30));
        let photons_ratio = strategy.paths as f64 / (paths * WIDER * WIDER * SHRUNK);
        let light = by_photons / n;
        // With photons camera paths omit what photons count.
        let found = self.cells.iter().sum::<f64>() / self.cells.len().max(1) as f64;
        let more = values.iter().sum::<f64>() / n - found;
        let missed = (more / light.max(1e-30)).clamp(0.0, 1.0);
        PhotonLight {
            light: light / mean,
            variance: photon_variance / (n * mean * mean * photons_ratio),
            missed,
            effective: by_photons * by_photons / photon_variance.max(f64::MIN_POSITIVE),
        }
    }

    /// Mean square over the image of light relative to that of its cell. `light` lists what light paths bring, with its
    /// cell; `paths` is their number times that of the pixels.
    pub(super) fn mean_square(&self, light: impl Iterator<Item = (usize, f64)>, paths: f64) -> f64 {
        // Light and its squares.
        let mut sums = vec![[0.0; 2]; self.cells.len()];
        for (cell, light) in light {
            if let Some([sum, squares]) = sums.get_mut(cell) {
                *sum += light;
                *squares += light * light;
            }
        }
        let cells = sums.len().max(1) as f64;
        let scale = cells / paths;
        // Without the products of a value with itself, which are noise.
        let of = |(cell, [light, squares]): (usize, &[f64; 2])| {
            (light * light - squares) * scale * scale * self.weight(cell)
        };
        (sums.iter().enumerate().map(of).sum::<f64>() / cells).max(0.0)
    }

    /// Weight of a squared luminance in a cell.
    pub(super) fn weight(&self, cell: usize) -> f64 {
        let value = self.cells.get(cell).copied().unwrap_or(0.0);
        1.0 / (value * value + self.dark).max(f64::MIN_POSITIVE)
    }
}

/// Camera paths of the pilot run: their luminances, the mean number of rays of a path, and the light of photons with its
/// approximate variance, each summed over all paths.
#[derive(Default)]
struct CameraPaths {
    values: Vec<f64>,
    rays: f64,
    by_photons: f64,
    photon_variance: f64,
}

/// Traces the camera paths.
fn trace_camera_paths(context: Context<'_>, photons: Option<&Arc<PhotonMap>>) -> CameraPaths {
    let view = context.view;
    let film = &view.film;
    let size = DVec2::new(f64::from(film.width), f64::from(film.height)) / f64::from(SIDE);
    let all = SIDE * SIDE * PIXELS * SAMPLES;
    let point = |i: u32| {
        let pixel = i / SAMPLES;
        let cell = pixel / PIXELS;
        let of_pixel = SampleId { x: cell % SIDE, y: cell / SIDE, index: pixel % PIXELS, seed: 0x51de };
        let id = SampleId { index: i % (PIXELS * SAMPLES), seed: 0x9e37_79b9, ..of_pixel };
        let corner = DVec2::new(f64::from(id.x), f64::from(id.y));
        let position = ((corner + of_pixel.unit_square(0)) * size).floor();
        (id, position + id.unit_square(0))
    };
    let parts = tasks::map(
        (all / TOGETHER) as usize,
        context.threads,
        || (),
        |(), part| {
            let mut batch = PathBatch::new(context, Off);
            if let Some(photons) = photons {
                batch.find_photons(Arc::clone(photons));
            }
            let (mut samples, mut out, mut stats) =
                (CameraSamples::default(), Vec::new(), RayStats::default());
            let first = part as u32 * TOGETHER;
            take_points(view, &mut samples, (first..first + TOGETHER).map(point));
            batch.radiance(&samples, &mut out, &mut stats);
            let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
            let (by_photons, photon_variance) = (batch.by_photons, batch.photon_variance);
            let values = out.iter().map(|r| finite(f64::from(r.color.luminance()))).collect();
            CameraPaths { values, rays: stats.total() as f64, by_photons, photon_variance }
        },
    );
    let mut all_paths = CameraPaths::default();
    for part in parts {
        all_paths.values.extend(part.values);
        all_paths.rays += part.rays / f64::from(all);
        all_paths.by_photons += part.by_photons;
        all_paths.photon_variance += part.photon_variance;
    }
    all_paths
}

/// The cell at a position of the image, given in 0..1.
pub(super) fn cell_at(position: DVec2) -> usize {
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
