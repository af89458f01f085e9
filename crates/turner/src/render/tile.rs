//! One tile: camera samples in batches, summed per pixel.
//!
//! For each sample index, the samples of all pixels of the tile form one batch: pixel position, lens position,
//! time, camera ray ([`take_points`]). The tracer turns the batch into radiance, which is added to sums that
//! belong to this worker: the tile's pixels and, where the pixel filter weights samples, a border around them. At the
//! end of the tile, the sums are added to the film, one lock for each row of tiles.
//!
//! Three cases differ. With shared paths, the batch covers all cells of pixels that the tile touches, since a
//! pixel needs the paths of its cell; results outside the tile are discarded. Where samples take many rays, a
//! batch covers only some rows (a strip), so that a cancel is noticed soon. With one sample per pixel, radiance
//! is stored without sums.

use std::ops::Range;
use std::sync::Arc;

use super::pixel::Log;
use super::tile_aovs::TileAovs;
use super::work::Stop;
use crate::color::Spectrum;
use crate::film::{
    Antialias, HALF_SQUARE, Half, NonFinite, PixelRect, Preview, SampleSet, SampleValues, SharedFilm,
    TileSums,
};
use crate::filter::Filter;
use crate::integrator::path::CELL;
use crate::integrator::{CameraSamples, PhotonMap, Prepared, Radiance, RayStats, Tracer};
use crate::math::DVec2;
use crate::sampler::SampleId;
use crate::view::{PlaceBuffer, places, take_points};

/// Approximate number of rays between two checks for a cancel: a few milliseconds of work. Small in tests, so
/// that tiles are traced in strips.
const MOST_RAYS: u64 = if cfg!(test) { 128 } else { 8192 };

/// Pixels that share paths are in the same half.
const _: () = assert!(CELL == HALF_SQUARE);

/// A worker's state for tiles, reused from tile to tile.
pub(super) struct TileBuffers<'a> {
    pub(super) p: &'a Prepared,
    tracer: Box<dyn Tracer + 'a>,
    /// Places the samples.
    pub(super) filter: Filter,
    /// The pixel filter, if it weights samples in several pixels.
    pub(super) reconstruction: Option<Filter>,
    /// The region of the film.
    pub(super) region: PixelRect,
    /// The half of the tile to render; `None` for all of it.
    half: Option<Half>,
    /// Rays of the tile's samples with an index above 0.
    rays: u64,
    /// Whether the film estimates its error.
    pub(super) estimates_error: bool,
    /// The results, with one sample per pixel.
    pub(super) pixels: Vec<Radiance>,
    /// The sums, with more samples per pixel.
    pub(super) sums: TileSums,
    /// The non-finite samples of the tile.
    pub(super) non_finite: NonFinite,
    pub(super) stats: RayStats,
    pub(super) samples: CameraSamples,
    /// The samples to trace, and the positions of samples.
    ids: Vec<SampleId>,
    places: PlaceBuffer,
    pub(super) radiance: Vec<Radiance>,
    /// Samples and radiance of the strips of this tile that are already traced.
    earlier: (Vec<SampleId>, Vec<Radiance>),
    /// The values of AOVs, if the film has any.
    pub(super) aovs: Option<TileAovs<'a>>,
    /// A recent estimate of the number of rays per sample.
    rays_per_sample: u64,
    /// The photon map of the current sample index, if camera paths merge with photons.
    photons: Option<Arc<PhotonMap>>,
    finds_photons: bool,
    /// Samples with index 0 that are already traced.
    preview: Option<&'a Preview>,
    /// Records the samples of one pixel; `None` for rendering.
    pub(super) log: Option<Box<Log>>,
}

impl<'a> TileBuffers<'a> {
    pub(super) fn new(p: &'a Prepared) -> TileBuffers<'a> {
        let aovs = TileAovs::new(p);
        let mut tracer = p.tracer();
        if let Some(aovs) = &aovs {
            aovs.of_samples.ask(&mut *tracer);
        }
        TileBuffers {
            p,
            tracer,
            aovs,
            filter: p.view.film.placement(),
            reconstruction: p.view.film.weights_samples().then(|| p.view.film.filter()),
            region: p.view.film.region(),
            half: None,
            rays: 0,
            estimates_error: false,
            pixels: Vec::new(),
            sums: TileSums::default(),
            non_finite: NonFinite::default(),
            stats: RayStats::default(),
            samples: CameraSamples::default(),
            ids: Vec::new(),
            places: PlaceBuffer::default(),
            radiance: Vec::new(),
            earlier: (Vec::new(), Vec::new()),
            rays_per_sample: 0,
            photons: None,
            finds_photons: p.integrator.finds_photons(),
            preview: None,
            log: None,
        }
    }

    /// Sets the photon map of one sample index. For other indices, this worker traces photons itself.
    pub(super) fn find_photons(&mut self, photons: Arc<PhotonMap>) {
        self.tracer.find_photons(photons.clone());
        self.photons = Some(photons);
    }

    /// Uses the preview's samples of index 0 where they equal those of the picture, that is, where pixels do not
    /// depend on one another.
    pub(super) fn reuse_preview(&mut self, preview: Option<&'a Preview>) {
        let alone = !self.p.integrator.shares_paths() && !self.finds_photons;
        // A preview holds no AOVs.
        let alone = alone && self.aovs.is_none();
        self.preview = preview.filter(|_| alone && self.p.view.film.antialias != Antialias::Adaptive);
    }

    /// Ensures that the tracer has the photon map of this sample index.
    pub(super) fn prepare(&mut self, index: u32) {
        if self.finds_photons && self.photons.as_ref().is_none_or(|p| p.index != index) {
            let photons = self.p.integrator.photons(&self.p.scene, &self.p.view, index);
            if let Some(photons) = photons {
                self.find_photons(photons);
            }
        }
    }

    /// Renders samples of all pixels of a tile, or of one half of them; `stats` accumulates over tiles. Returns the
    /// finished samples: all, unless stopped.
    pub(super) fn render(
        &mut self,
        tile: &PixelRect,
        half: Option<Half>,
        samples: &[Range<u64>],
        stop: Stop<'_>,
    ) -> SampleSet {
        self.half = half;
        self.rays = 0;
        let one_sample = self.p.view.film.is_one_sample();
        let mut finished = SampleSet::default();
        self.pixels.clear();
        self.non_finite = NonFinite::default();
        if self.p.view.film.antialias == Antialias::Adaptive {
            if !samples.is_empty() {
                self.prepare(0);
                if self.render_adaptive(tile, stop) {
                    self.add_aovs_of_centers(tile);
                    finished.insert(0..1);
                }
            }
            return finished;
        }
        if !one_sample {
            self.begin_sums(tile);
        }
        // One sample index of all pixels per batch. Batches of four indices (1024 samples) were tried: path
        // tracers are 2 to 9 % slower, because the state of the paths no longer fits in the caches.
        let traced = self.traced(tile);
        for index in samples.iter().cloned().flatten() {
            if stop.is_set() {
                break;
            }
            let before = self.stats.total();
            if !self.render_sample(tile, &traced, index as u32, stop) {
                break;
            }
            if index > 0 {
                self.rays += self.stats.total() - before;
            }
            finished.insert(index..index + 1);
            if one_sample {
                std::mem::swap(&mut self.pixels, &mut self.radiance);
                self.check_pixels(tile);
                continue;
            }
            self.add_samples();
        }
        finished
    }

    /// Adds the samples of one index to the sums.
    fn add_samples(&mut self) {
        if self.aovs.is_some() {
            return self.add_samples_with_aovs();
        }
        let samples = self.samples.ids.iter().zip(&self.radiance);
        if let Some(filter) = &self.reconstruction {
            places(&self.p.view, &self.filter, &self.samples.ids, &mut self.places);
            let samples = samples.zip(&self.places.places).map(|((id, &Radiance { color, alpha }), at)| {
                (*at, SampleValues { color, alpha, extra: &[], index: id.index })
            });
            let (ids, non_finite) = (&self.samples.ids, &mut self.non_finite);
            let omit = |i: usize| non_finite.note(ids[i].x, ids[i].y, ids[i].index);
            self.sums.splat_all(self.p.view.instruction_set, filter, samples, omit);
            return;
        }
        let PixelRect { x, y, width, .. } = self.sums.rect();
        for (id, &Radiance { color, alpha }) in samples {
            let i = ((id.y - y) * width + id.x - x) as usize;
            let values = SampleValues { color, alpha, extra: &[], index: id.index };
            if !self.sums.add_weighted(i, &values, 1.0) {
                self.non_finite.note(id.x, id.y, id.index);
            }
        }
    }

    /// Traces one sample of each pixel of a tile; `traced` is the rectangle of pixels that share paths with them.
    /// Returns false if it was stopped.
    fn render_sample(&mut self, tile: &PixelRect, traced: &PixelRect, index: u32, stop: Stop<'_>) -> bool {
        self.prepare(index);
        let rows = self.rows_at_once(traced);
        if rows >= traced.height {
            self.render_strip(tile, traced, index);
            return true;
        }
        // Without shared paths, `traced` equals the tile.
        self.earlier.0.clear();
        self.earlier.1.clear();
        if let Some(aovs) = &mut self.aovs {
            aovs.forget_earlier();
        }
        for first in (0..tile.height).step_by(rows as usize) {
            if stop.is_set() {
                return false;
            }
            let height = rows.min(tile.height - first);
            let strip = PixelRect { y: tile.y + first, height, ..*tile };
            self.render_strip(&strip, &strip, index);
            self.earlier.0.append(&mut self.samples.ids);
            self.earlier.1.append(&mut self.radiance);
            if let Some(aovs) = &mut self.aovs {
                aovs.keep();
            }
        }
        std::mem::swap(&mut self.earlier.0, &mut self.samples.ids);
        std::mem::swap(&mut self.earlier.1, &mut self.radiance);
        if let Some(aovs) = &mut self.aovs {
            aovs.take_kept();
        }
        true
    }

    /// The number of rows traced at a time: fewer than all if samples take so many rays that a cancel would be
    /// noticed late.
    fn rows_at_once(&self, traced: &PixelRect) -> u32 {
        if self.p.integrator.shares_paths() {
            return traced.height;
        }
        let rays = self.rays_per_sample * u64::from(traced.width);
        (MOST_RAYS / rays.max(1)).clamp(1, u64::from(traced.height)) as u32
    }

    /// Traces one sample of each pixel in some rows of a tile.
    fn render_strip(&mut self, tile: &PixelRect, traced: &PixelRect, index: u32) {
        let before = self.stats.total();
        let film = &self.p.view.film;
        let preview = self.preview.filter(|_| index == 0 && self.half.is_none());
        let half = self.half;
        let ids = (traced.y..traced.y + traced.height)
            .flat_map(|y| (traced.x..traced.x + traced.width).map(move |x| (x, y)))
            .filter(|(x, y)| half.is_none_or(|half| Half::of(*x, *y) == half))
            .filter(|(x, y)| preview.and_then(|p| p.traced(*x, *y)).is_none())
            .map(|(x, y)| SampleId { x, y, index, seed: u64::from(film.seed) });
        self.ids.clear();
        self.ids.extend(ids);
        places(&self.p.view, &self.filter, &self.ids, &mut self.places);
        let points = self.ids.iter().copied().zip(self.places.places.iter().copied());
        self.samples.clear();
        take_points(&self.p.view, &mut self.samples, points);
        self.trace();
        if traced != tile {
            self.discard_outside(tile);
        }
        if let Some(log) = &mut self.log {
            log.traced(&self.p.view, &self.samples.ids, &self.radiance);
        }
        self.clamp_samples();
        if let Some(preview) = preview {
            self.add_preview(tile, preview);
        }
        let rays = (self.stats.total() - before) / traced.area().max(1);
        self.rays_per_sample = rays.max(self.rays_per_sample / 2);
    }

    /// Merges the preview's samples with the traced ones, in the order of the tile's pixels.
    fn add_preview(&mut self, tile: &PixelRect, preview: &Preview) {
        let seed = u64::from(self.p.view.film.seed);
        let mut traced = std::mem::take(&mut self.radiance).into_iter();
        self.samples.ids.clear();
        for i in 0..tile.area() as u32 {
            let (x, y) = (tile.x + i % tile.width, tile.y + i / tile.width);
            let known = preview
                .traced(x, y)
                .map(|[r, g, b, alpha]| Radiance { color: Spectrum::new(r, g, b), alpha });
            self.radiance.extend(known.or_else(|| traced.next()));
            self.samples.ids.push(SampleId { x, y, index: 0, seed });
        }
    }

    /// Adds the finished samples to the film.
    pub(super) fn deposit(
        &self,
        (tile, half): (usize, Option<Half>),
        finished: &SampleSet,
        film: &SharedFilm<'_>,
    ) {
        if finished.is_empty() {
            return;
        }
        if self.p.view.film.is_one_sample() {
            film.deposit_samples(tile, self.pixels.iter().map(|r| (r.color, r.alpha)), &self.non_finite);
        } else {
            let added = film.deposit_sums((tile, half), &self.sums, finished, &self.non_finite, self.rays);
            if let Some(aovs) = self.aovs.as_ref().filter(|_| added) {
                film.deposit_labels(tile, &aovs.labels);
            }
        }
    }

    /// Counts the non-finite pixels.
    pub(super) fn check_pixels(&mut self, tile: &PixelRect) {
        // One branch-free test for nearly all tiles: v * 0 equals 0 only for finite v. The sum may overflow
        // although its terms are finite; the loop below decides.
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
        if self.samples.ids.is_empty() {
            self.radiance.clear();
            return;
        }
        self.tracer.radiance(&self.samples, &mut self.radiance, &mut self.stats);
        if self.p.view.camera.is_outside_field() {
            let alpha = if self.p.scene.background.transparent { 0.0 } else { 1.0 };
            for (i, radiance) in self.radiance.iter_mut().enumerate() {
                if self.samples.rays.get(i).is_some_and(|ray| ray.t_max < 0.0) {
                    *radiance = Radiance { color: Spectrum::BLACK, alpha };
                }
            }
        }
        if let Some(aovs) = &mut self.aovs {
            aovs.of_samples.take(&self.samples, &self.radiance, self.tracer.details());
        }
    }

    /// The pixels to trace for a tile: all cells that it touches, if pixels share paths.
    fn traced(&self, tile: &PixelRect) -> PixelRect {
        if !self.p.integrator.shares_paths() {
            return *tile;
        }
        let (film, down) = (&self.p.view.film, |v: u32| v - v % CELL);
        let (x, y) = (down(tile.x), down(tile.y));
        let right = (tile.x + tile.width).next_multiple_of(CELL).min(film.width);
        let bottom = (tile.y + tile.height).next_multiple_of(CELL).min(film.height);
        PixelRect { x, y, width: right - x, height: bottom - y }
    }

    /// Discards the samples outside a tile.
    fn discard_outside(&mut self, tile: &PixelRect) {
        let is_within = |id: &SampleId| {
            (tile.x..tile.x + tile.width).contains(&id.x) && (tile.y..tile.y + tile.height).contains(&id.y)
        };
        if let Some(aovs) = &mut self.aovs {
            let ids = &self.samples.ids;
            aovs.of_samples.retain(|i| ids.get(i).is_some_and(is_within));
        }
        let mut ids = self.samples.ids.iter();
        self.radiance.retain(|_| ids.next().is_some_and(is_within));
        self.samples.ids.retain(is_within);
    }

    /// Traces samples at positions in the picture; results are in the same order.
    pub(super) fn trace_points(&mut self, points: impl Iterator<Item = (SampleId, DVec2)>) -> &[Radiance] {
        self.samples.clear();
        take_points(&self.p.view, &mut self.samples, points);
        self.trace();
        if let Some(log) = &mut self.log {
            log.traced(&self.p.view, &self.samples.ids, &self.radiance);
        }
        self.clamp_samples();
        &self.radiance
    }

    /// Applies the camera's weights, then scales down samples that are brighter than the film's `clamp_sample`.
    fn clamp_samples(&mut self) {
        for (radiance, weight) in self.radiance.iter_mut().zip(&self.samples.weights) {
            radiance.color *= *weight;
        }
        if self.p.view.film.clamp_sample > 0.0 {
            for radiance in &mut self.radiance {
                radiance.color *= self.p.view.film.clamp_factor(radiance.color);
            }
        }
    }
}
