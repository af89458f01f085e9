//! One tile: camera samples in batches, their results summed per pixel.

use std::ops::Range;

use super::grid_side;
use crate::film::{Antialias, NonFinite, PixelRect, PixelSample, PixelSum};
use crate::integrator::{CameraSample, Radiance, RayStats};
use crate::math::DVec2;
use crate::sampler::{SampleId, stratified};
use crate::scene::Scene;

/// Dimensions of a sample's random numbers: the place in the pixel, the place on the lens; lights come after 16.
const PIXEL_DIMENSION: u64 = 0;
const LENS_DIMENSION: u64 = 1;

/// What a worker needs for its tiles; kept from tile to tile.
#[derive(Default)]
pub(super) struct TileBuffers {
    pub(super) sums: Vec<PixelSum>,
    pub(super) non_finite: NonFinite,
    pub(super) stats: RayStats,
    samples: Vec<CameraSample>,
    radiance: Vec<Radiance>,
}

impl TileBuffers {
    /// Renders the samples of all pixels of a tile into `sums`; `non_finite` and `stats` count on from tile to tile.
    pub(super) fn render(&mut self, scene: &Scene, tile: &PixelRect, samples: Range<u32>) {
        self.sums.clear();
        self.sums.resize(tile.area() as usize, PixelSum::default());
        if scene.film.antialias == Antialias::Adaptive {
            if samples.contains(&0) {
                self.render_adaptive(scene, tile);
            }
            return;
        }
        for index in samples {
            self.samples.clear();
            for y in tile.y..tile.y + tile.height {
                for x in tile.x..tile.x + tile.width {
                    let id = SampleId { x, y, index, seed: u64::from(scene.film.seed) };
                    let within = within_pixel(scene, &id);
                    self.samples.push(camera_sample(
                        scene,
                        id,
                        DVec2::new(f64::from(x), f64::from(y)) + within,
                    ));
                }
            }
            self.trace(scene);
            for (i, (sample, radiance)) in self.samples.iter().zip(&self.radiance).enumerate() {
                add(&mut self.sums[i], &mut self.non_finite, &sample.id, radiance);
            }
        }
    }

    /// Traces the prepared samples.
    pub(super) fn trace(&mut self, scene: &Scene) {
        self.radiance.clear();
        scene.integrator.integrator().radiance(scene, &self.samples, &mut self.radiance, &mut self.stats);
    }

    /// Traces a list of points of the picture and gives their results in order.
    pub(super) fn trace_points(
        &mut self,
        scene: &Scene,
        points: impl Iterator<Item = (SampleId, DVec2)>,
    ) -> &[Radiance] {
        self.samples.clear();
        self.samples.extend(points.map(|(id, at)| camera_sample(scene, id, at)));
        self.trace(scene);
        &self.radiance
    }
}

/// Adds a result to its pixel, or counts it as not finite.
pub(super) fn add(sum: &mut PixelSum, non_finite: &mut NonFinite, id: &SampleId, radiance: &Radiance) {
    if radiance.color.is_finite() && radiance.alpha.is_finite() {
        sum.add(radiance.color, radiance.alpha);
    } else {
        sum.leave_out();
        non_finite.note(id.x, id.y, id.index);
    }
}

/// Where in its pixel a sample lies: (0, 0) is the top left corner, (1, 1) the bottom right one.
fn within_pixel(scene: &Scene, id: &SampleId) -> DVec2 {
    let film = &scene.film;
    match film.antialias {
        Antialias::None | Antialias::Mean | Antialias::Adaptive => match film.pixel_sample {
            PixelSample::Center => DVec2::splat(0.5),
            PixelSample::Corner => DVec2::new(0.0, 1.0),
        },
        Antialias::Grid => {
            let side = grid_side(film.samples);
            let cell = DVec2::new(f64::from(id.index % side), f64::from(id.index / side));
            (cell + 0.5) / f64::from(side)
        }
        Antialias::MonteCarlo => stratified(id.index, film.samples, id.unit_square(PIXEL_DIMENSION)),
    }
}

/// The camera ray through a point of the picture, in pixels from its top left corner.
fn camera_sample(scene: &Scene, id: SampleId, at: DVec2) -> CameraSample {
    let film = &scene.film;
    let screen =
        DVec2::new(2.0 * at.x / f64::from(film.width) - 1.0, 1.0 - 2.0 * at.y / f64::from(film.height));
    let lens = if scene.camera.has_lens() { id.unit_square(LENS_DIMENSION) } else { DVec2::splat(0.5) };
    let mut ray = scene.camera.ray(screen, lens);
    let length = ray.direction.length();
    ray.direction *= length.recip();
    ray.t_min *= length;
    CameraSample { id, ray, length }
}
