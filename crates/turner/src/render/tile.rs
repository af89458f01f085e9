//! One tile: camera samples in batches, their results summed per pixel.

use std::ops::Range;
use std::sync::Arc;

use turner_bvh::lanes::{Block, LANES};

use super::pixel::Log;
use crate::camera::camera_rays;
use crate::color::Spectrum;
use crate::film::{Antialias, Band, NonFinite, PixelRect, PixelSample, PixelSum};
use crate::filter::Filter;
use crate::integrator::path::CELL;
use crate::integrator::{CameraSamples, PhotonMap, Radiance, RayStats, Tracer};
use crate::math::DVec2;
use crate::sampler::{OwenSobol, SampleId, stratified};
use crate::scene::Scene;

/// Dimensions of a sample's random numbers: the place in the pixel, the place on the lens; lights come after 16.
const PIXEL_DIMENSION: u64 = 0;
const LENS_DIMENSION: u64 = 1;

/// The same for integrators with Sobol points: surfaces come after 2.
const PIXEL_SET: u32 = 0;
const LENS_SET: u32 = 1;

/// What a worker needs for its tiles; kept from tile to tile.
pub(super) struct TileBuffers<'a> {
    pub(super) scene: &'a Scene,
    tracer: Box<dyn Tracer + 'a>,
    filter: Filter,
    /// The results of scenes with one sample per pixel.
    pub(super) pixels: Vec<Radiance>,
    /// The sums of the others.
    sums: Vec<PixelSum>,
    pub(super) non_finite: NonFinite,
    pub(super) stats: RayStats,
    pub(super) samples: CameraSamples,
    pub(super) radiance: Vec<Radiance>,
    /// The photons of a sample's number, if samples find any.
    photons: Option<Arc<PhotonMap>>,
    finds_photons: bool,
    /// Samples by themselves, for one pixel; `None` where a picture is rendered.
    pub(super) log: Option<Box<Log>>,
}

impl<'a> TileBuffers<'a> {
    pub(super) fn new(scene: &'a Scene) -> TileBuffers<'a> {
        TileBuffers {
            scene,
            tracer: scene.integrator.integrator().tracer(scene),
            filter: scene.film.filter(),
            pixels: Vec::new(),
            sums: Vec::new(),
            non_finite: NonFinite::default(),
            stats: RayStats::default(),
            samples: CameraSamples::default(),
            radiance: Vec::new(),
            photons: None,
            finds_photons: scene.integrator.integrator().finds_photons(scene),
            log: None,
        }
    }

    /// Photons for all samples of one number; of others it traces its own.
    pub(super) fn find_photons(&mut self, photons: Arc<PhotonMap>) {
        self.tracer.find_photons(photons.clone());
        self.photons = Some(photons);
    }

    /// Sees to it that samples of a number find the photons of that number.
    pub(super) fn prepare(&mut self, index: u32) {
        if self.finds_photons && self.photons.as_ref().is_none_or(|p| p.index != index) {
            let photons = self.scene.integrator.integrator().photons(self.scene, index);
            if let Some(photons) = photons {
                self.find_photons(Arc::new(photons));
            }
        }
    }

    /// Renders samples of all pixels of a tile; `non_finite` and `stats` count on from tile to tile.
    pub(super) fn render(&mut self, tile: &PixelRect, samples: Range<u32>) {
        let one_sample = self.scene.film.samples_per_pixel() == 1;
        self.pixels.clear();
        self.sums.clear();
        if !one_sample {
            self.sums.resize(tile.area() as usize, PixelSum::default());
        }
        if self.scene.film.antialias == Antialias::Adaptive {
            if samples.contains(&0) {
                self.prepare(0);
                self.render_adaptive(tile);
            }
            return;
        }
        let film = &self.scene.film;
        // One number of all pixels at a time: four (1024 samples) took integrators that follow light 2 to 9 % longer, for their paths' state leaves the
        // caches.
        let traced = self.traced(tile);
        for index in samples {
            self.prepare(index);
            let points = (traced.y..traced.y + traced.height)
                .flat_map(|y| (traced.x..traced.x + traced.width).map(move |x| (x, y)))
                .map(|(x, y)| {
                    let id = SampleId { x, y, index, seed: u64::from(film.seed) };
                    (id, place(self.scene, &self.filter, &id))
                });
            self.samples.clear();
            take_points(self.scene, &mut self.samples, points);
            self.trace();
            if traced != *tile {
                self.keep(tile);
            }
            if let Some(log) = &mut self.log {
                log.traced(&self.samples.ids, &self.radiance);
            }
            self.cut();
            if one_sample {
                std::mem::swap(&mut self.pixels, &mut self.radiance);
                self.check_pixels(tile);
                continue;
            }
            for ((sum, id), radiance) in self.sums.iter_mut().zip(&self.samples.ids).zip(&self.radiance) {
                if !sum.add_or_leave_out(radiance.color, radiance.alpha) {
                    self.non_finite.note(id.x, id.y, id.index);
                }
            }
        }
    }

    /// Adds what was rendered to the tile's band of the film.
    pub(super) fn deposit(&self, tile: &PixelRect, band: &mut Band) {
        if self.sums.is_empty() {
            let samples = self.pixels.iter().map(|r| (r.color, r.alpha));
            if !self.pixels.is_empty() {
                band.add_samples(tile, samples);
            }
        } else {
            band.add_sums(tile, &self.sums);
        }
    }

    /// Counts the pixels that are not finite.
    pub(super) fn check_pixels(&mut self, tile: &PixelRect) {
        // One test without branches for nearly all tiles: times 0 is 0 for finite numbers alone. The sum may be
        // infinite though they are not.
        let sum = |r: &Radiance| (r.color.r + r.color.g + r.color.b + r.alpha) * 0.0;
        if self.pixels.iter().fold(true, |finite, r| finite & (sum(r) == 0.0)) {
            return;
        }
        for (i, r) in self.pixels.iter().enumerate() {
            if !(r.color.is_finite() && r.alpha.is_finite()) {
                let (x, y) = (tile.x + i as u32 % tile.width, tile.y + i as u32 / tile.width);
                self.non_finite.note(x, y, 0);
            }
        }
    }

    /// Traces the prepared samples.
    pub(super) fn trace(&mut self) {
        self.tracer.radiance(&self.samples, &mut self.radiance, &mut self.stats);
        if self.scene.camera.leaves_out() {
            let alpha = if self.scene.background.transparent { 0.0 } else { 1.0 };
            for (i, radiance) in self.radiance.iter_mut().enumerate() {
                if self.samples.rays.get(i).is_some_and(|ray| ray.t_max < 0.0) {
                    *radiance = Radiance { color: Spectrum::BLACK, alpha };
                }
            }
        }
    }

    /// The pixels that are traced for those of a tile: all that they share paths with.
    fn traced(&self, tile: &PixelRect) -> PixelRect {
        if !self.scene.shares_paths() {
            return *tile;
        }
        let (film, down) = (&self.scene.film, |v: u32| v - v % CELL);
        let (x, y) = (down(tile.x), down(tile.y));
        let right = (tile.x + tile.width).next_multiple_of(CELL).min(film.width);
        let bottom = (tile.y + tile.height).next_multiple_of(CELL).min(film.height);
        PixelRect { x, y, width: right - x, height: bottom - y }
    }

    /// Leaves out the samples that are beyond a tile.
    fn keep(&mut self, tile: &PixelRect) {
        let is_within = |id: &SampleId| {
            (tile.x..tile.x + tile.width).contains(&id.x) && (tile.y..tile.y + tile.height).contains(&id.y)
        };
        let mut ids = self.samples.ids.iter();
        self.radiance.retain(|_| ids.next().is_some_and(is_within));
        self.samples.ids.retain(is_within);
    }

    /// Traces a list of points of the picture and gives their results in order.
    pub(super) fn trace_points(&mut self, points: impl Iterator<Item = (SampleId, DVec2)>) -> &[Radiance] {
        self.samples.clear();
        take_points(self.scene, &mut self.samples, points);
        self.trace();
        if let Some(log) = &mut self.log {
            log.traced(&self.samples.ids, &self.radiance);
        }
        self.cut();
        &self.radiance
    }

    /// Scales down the samples that are brighter than the film lets them be.
    fn cut(&mut self) {
        if self.scene.film.max_sample > 0.0 {
            for radiance in &mut self.radiance {
                radiance.color *= self.scene.film.kept(radiance.color);
            }
        }
    }
}

/// Adds the camera samples of points of the picture, in pixels from its top left corner.
pub(crate) fn take_points(
    scene: &Scene,
    samples: &mut CameraSamples,
    mut points: impl Iterator<Item = (SampleId, DVec2)>,
) {
    let has_lens = scene.camera.has_lens();
    let sobol = scene.integrator.is_physical();
    loop {
        let first = samples.ids.len();
        let (mut x, mut y) = (Block([f64::NAN; LANES]), Block([f64::NAN; LANES]));
        for (lane, (id, at)) in (&mut points).take(LANES).enumerate() {
            (x.0[lane], y.0[lane]) = (at.x, at.y);
            samples.ids.push(id);
        }
        let ids = &samples.ids[first..];
        if ids.is_empty() {
            return;
        }
        let lens = |lane: usize| match ids.get(lane) {
            Some(id) if has_lens && sobol => OwenSobol::new(id).two(LENS_SET).into(),
            Some(id) if has_lens => id.unit_square(LENS_DIMENSION),
            _ => DVec2::splat(0.5),
        };
        if scene.moves {
            // The third number beside the place on the lens.
            let [open, close] = scene.film.shutter;
            for (i, id) in ids.iter().enumerate() {
                let [.., u, _] = OwenSobol::new(id).four(LENS_SET);
                samples.rays.set_time(first + i, (open + (close - open) * u) as f32);
            }
        }
        let rays = samples.rays.add_block(ids.len());
        samples.lengths.push(camera_rays(&scene.camera, &scene.film, &x, &y, lens, rays));
        if ids.len() < LANES {
            return;
        }
    }
}

/// Where in the picture a sample lies, in pixels from its top left corner.
#[inline]
pub(super) fn place(scene: &Scene, filter: &Filter, id: &SampleId) -> DVec2 {
    DVec2::new(f64::from(id.x), f64::from(id.y)) + within_pixel(scene, filter, id)
}

/// Where in its pixel a sample lies: (0, 0) is the top left corner, (1, 1) the bottom right one. Filters may reach beyond.
#[inline]
fn within_pixel(scene: &Scene, filter: &Filter, id: &SampleId) -> DVec2 {
    let film = &scene.film;
    match film.antialias {
        Antialias::None | Antialias::Mean | Antialias::Adaptive => match film.pixel_sample {
            PixelSample::Center => DVec2::splat(0.5),
            PixelSample::Corner => DVec2::new(0.0, 1.0),
        },
        Antialias::Grid => {
            let side = film.grid_side();
            let cell = DVec2::new(f64::from(id.index % side), f64::from(id.index / side));
            (cell + 0.5) / f64::from(side)
        }
        Antialias::MonteCarlo if scene.integrator.is_physical() => {
            filter.place(OwenSobol::new(id).two(PIXEL_SET).into())
        }
        Antialias::MonteCarlo => {
            filter.place(stratified(id.index, film.samples, id.unit_square(PIXEL_DIMENSION)))
        }
    }
}
