//! The film: sums of samples over a region of the picture.

use std::ops::Range;

use super::band::Band;
use super::brightest::Brightest;
use super::error::ERROR_SUMS;
use super::preview::Preview;
use super::{
    Channel, FilmDesc, Fixed96, Identity, LabelChannel, NonFinite, PixelRect, PixelSum, SampleSet, Splats,
    TILE, TileGrid,
};
use crate::schema::{ErrorCode, SceneError};

/// Sums of weighted samples and of their weights over a region of the picture. Sums are integers, so the order in
/// which samples, tiles, passes or machines add to them does not matter. The film knows the samples that each
/// tile holds, so none counts twice.
#[derive(Clone, Debug)]
pub struct Film {
    /// The part that is rendered: `crop` and the border whose samples count in it ([`FilmDesc::border`]).
    pub region: PixelRect,
    /// The part that is shown.
    pub crop: PixelRect,
    /// The channels in addition to colour and coverage.
    channels: Vec<Channel>,
    /// The channels of labels.
    pub(super) labels: Vec<LabelChannel>,
    /// The region in rows of tiles, [`TILE`] pixels high.
    pub(super) bands: Vec<Band>,
    pub(super) bytes_per_pixel: usize,
    /// The splats of light paths, if there are light paths.
    pub(super) splats: Option<Splats>,
    /// Non-finite samples and splats.
    pub non_finite: NonFinite,
    /// Which picture it belongs to.
    pub(super) identity: Identity,
    /// The mean of the goals of an adaptive film: see [`super::adaptive`].
    pub(super) step: u32,
    /// Shown in pixels without samples.
    pub(super) preview: Option<Preview>,
}

/// The maximum number of pixels of a film: 16384 × 16384, 13 GB of sums.
pub const MAX_PIXELS: u64 = 1 << 28;

impl Film {
    /// Region and crop of a description.
    ///
    /// Errors: an invalid crop, too many pixels.
    pub(super) fn rects(desc: &FilmDesc) -> Result<(PixelRect, PixelRect), SceneError> {
        let full = PixelRect { x: 0, y: 0, width: desc.width, height: desc.height };
        let crop = match desc.crop {
            None => full,
            Some([x, y, width, height]) => {
                let fits = |from: u32, size: u32, of: u32| {
                    size > 0 && u64::from(from) + u64::from(size) <= u64::from(of)
                };
                if !fits(x, width, desc.width) || !fits(y, height, desc.height) {
                    let message = format!(
                        "the crop of {width}x{height} pixels at ({x}, {y}) is empty or reaches beyond the picture of {}x{}",
                        desc.width, desc.height
                    );
                    return Err(SceneError::new(ErrorCode::OutOfRange, message));
                }
                PixelRect { x, y, width, height }
            }
        };
        let region = crop.grown(desc.border(), &full);
        if region.area() > MAX_PIXELS {
            let message = format!(
                "a picture of {}x{} has more than the {MAX_PIXELS} pixels a film may have",
                region.width, region.height
            );
            return Err(SceneError::new(ErrorCode::TooLarge, message).help("render it in parts with `crop`"));
        }
        Ok((region, crop))
    }

    /// Size in bytes of the film of a description, without splats.
    ///
    /// Errors: an invalid crop, too many pixels.
    pub fn check(desc: &FilmDesc) -> Result<u64, SceneError> {
        let sums = Band::bytes_per_pixel(desc.is_one_sample(), desc.channels().len());
        let brightest = if desc.removes_fireflies() { Brightest::BYTES } else { 0 };
        let bytes = (sums + brightest + Film::label_bytes(&desc.labels())) as u64;
        Film::rects(desc).map(|(region, _)| region.area() * bytes)
    }

    /// Size in bytes of film and picture together: the sums, the linear and display values, and the file before
    /// it is written.
    ///
    /// Errors: an invalid crop, too many pixels.
    pub fn peak(desc: &FilmDesc) -> Result<u64, SceneError> {
        const PICTURE: u64 = 16 + 4;
        const FILE: u64 = 20;
        let (region, _) = Film::rects(desc)?;
        // Developed, and in the file before it is written.
        let aovs = 2 * 4 * desc.aov_values();
        // With some integrators; this is an upper limit.
        let is_random = desc.antialias == super::Antialias::MonteCarlo && desc.samples > 1;
        let error = if is_random { (ERROR_SUMS * size_of::<Fixed96>()) as u64 } else { 0 };
        let more = PICTURE + FILE + aovs + error;
        Ok(Film::check(desc)?.saturating_add(region.area().saturating_mul(more)))
    }

    /// An empty film with colour and coverage, and the channels of the description's AOVs.
    ///
    /// Errors: those of [`Film::with_channels`].
    pub fn new(desc: &FilmDesc) -> Result<Film, SceneError> {
        let mut film = Film::with_channels(desc, desc.channels())?;
        film.take_labels(&desc.labels())?;
        Ok(film)
    }

    /// An empty film with additional channels.
    ///
    /// Errors: an invalid crop, too many pixels or channels, duplicate channel names, not enough memory.
    pub fn with_channels(desc: &FilmDesc, channels: Vec<Channel>) -> Result<Film, SceneError> {
        let (region, crop) = Film::rects(desc)?;
        Film::empty(Identity::new(desc, region, crop), channels)
    }

    /// An empty film of a picture.
    pub(super) fn empty(identity: Identity, channels: Vec<Channel>) -> Result<Film, SceneError> {
        Channel::check(&channels)?;
        let (region, crop) = (identity.region, identity.crop);
        // Test the allocation first: a failed one would abort the program.
        let bytes_per_pixel = Film::pixel_bytes(&identity, &channels);
        if Vec::<u8>::new().try_reserve_exact(region.area() as usize * bytes_per_pixel).is_err() {
            let message = format!("not enough memory for a film of {}x{}", region.width, region.height);
            return Err(SceneError::new(ErrorCode::TooLarge, message).help("render it in parts with `crop`"));
        }
        let one_sample = Film::keeps_samples(&identity, &channels);
        let bands = (0..region.height)
            .step_by(TILE as usize)
            .map(|y| {
                let rows = PixelRect { y: region.y + y, height: TILE.min(region.height - y), ..region };
                let mut band = Band::new(rows, one_sample, Film::extra_sums(&identity, &channels));
                if identity.removes_fireflies {
                    band.keep_brightest();
                }
                band
            })
            .collect();
        let non_finite = NonFinite::default();
        Ok(Film {
            region,
            crop,
            channels,
            labels: Vec::new(),
            bands,
            bytes_per_pixel,
            splats: None,
            non_finite,
            identity,
            step: 0,
            preview: None,
        })
    }

    /// Whether pixels store their single sample instead of sums.
    pub(super) fn keeps_samples(identity: &Identity, channels: &[Channel]) -> bool {
        identity.samples == 1 && !identity.weighted && Film::extra_sums(identity, channels) == 0
    }

    /// Bytes per pixel without splats.
    pub(super) fn pixel_bytes(identity: &Identity, channels: &[Channel]) -> usize {
        let brightest = if identity.removes_fireflies { Brightest::BYTES } else { 0 };
        brightest
            + Band::bytes_per_pixel(
                Film::keeps_samples(identity, channels),
                Film::extra_sums(identity, channels),
            )
    }

    /// Sums per pixel in addition to colour and coverage.
    fn extra_sums(identity: &Identity, channels: &[Channel]) -> usize {
        channels.len() + if identity.estimates_error { ERROR_SUMS } else { 0 }
    }

    /// Adds what an estimate of the error needs, 60 bytes per pixel ([`Film::error`]). Does nothing if the film has
    /// it. The film must be empty.
    ///
    /// Errors: not enough memory.
    pub fn estimate_error(&mut self) -> Result<(), SceneError> {
        if !self.identity.estimates_error {
            let identity = Identity { estimates_error: true, ..self.identity.clone() };
            let labels = std::mem::take(&mut self.labels);
            *self = Film::empty(identity, std::mem::take(&mut self.channels))?;
            self.take_labels(&labels)?;
        }
        Ok(())
    }

    /// Adds room for splats, with `paths` light paths per sample index. Does nothing if there is room already, or
    /// if `paths` is 0.
    ///
    /// Errors: not enough memory.
    pub fn take_light(&mut self, paths: u64) -> Result<(), SceneError> {
        if self.splats.is_none() && paths > 0 {
            self.splats = Some(Splats::new(self.region)?);
            self.identity.light_paths = paths;
        }
        Ok(())
    }

    /// Notes how many neighbouring pixels share paths (1: none): their errors are smaller than independent samples suggest.
    pub fn note_cluster(&mut self, size: u32) {
        self.identity.cluster = size;
    }

    /// The splats, if the film has room for them.
    pub fn splats(&self) -> Option<&Splats> {
        self.splats.as_ref()
    }

    /// Which picture the film belongs to. Films of one picture can be merged.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Sets the fingerprint of the scene, so that films of other scenes are not merged with this one. The caller
    /// defines it.
    pub fn set_scene(&mut self, fingerprint: u64) {
        self.identity.scene = Some(fingerprint);
    }

    /// The channels in addition to colour and coverage.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The weighted mean of an additional channel in a pixel of the region; `None` without such a channel, pixel
    /// or sample.
    pub fn channel(&self, name: &str, x: u32, y: u32) -> Option<f32> {
        let channel = self.channels.iter().position(|c| c.name == name)?;
        let PixelRect { x: left, y: top, width, height } = self.region;
        let inside = (left..left + width).contains(&x) && (top..top + height).contains(&y);
        let (band, i) = self.place(x, y).filter(|_| inside)?;
        let weight = band.sum(i).weight();
        (weight != 0.0).then(|| Fixed96::from_words(band.extra(i)[channel]).mean(weight) as f32)
    }

    /// The tiles of the region.
    pub fn tiles(&self) -> TileGrid {
        TileGrid::new(self.region)
    }

    /// The indices of the samples that a tile holds. In adaptive films those of its even half.
    pub fn held(&self, tile: usize) -> &SampleSet {
        let columns = self.tiles().columns();
        &self.bands[tile / columns].held[tile % columns]
    }

    /// The first sample index that some tile lacks, or of which a light path is missing.
    pub fn first_missing(&self) -> u32 {
        let held = self.bands.iter().flat_map(Band::sets).map(SampleSet::first_missing).min().unwrap_or(0);
        let light =
            self.splats.as_ref().map_or(u64::MAX, |s| s.held().first_missing() / self.identity.light_paths);
        held.min(light).min(u64::from(u32::MAX)) as u32
    }

    /// The first sample index of a range that some tile lacks, or of which a light path is missing; `None` if the
    /// film holds the whole range.
    pub fn first_missing_in(&self, range: &Range<u32>) -> Option<u32> {
        let [start, end] = [range.start, range.end].map(u64::from);
        let first = |set: &SampleSet, by: u64| {
            set.missing(start.saturating_mul(by)..end.saturating_mul(by)).first().map(|r| r.start / by)
        };
        let tiles = self.bands.iter().flat_map(Band::sets).filter_map(|held| first(held, 1));
        let light = self.splats.as_ref().and_then(|s| first(s.held(), self.identity.light_paths.max(1)));
        tiles.chain(light).min().map(|index| index as u32)
    }

    /// The fraction of the samples of a range that the film holds, 0 to 1; light paths do not count.
    pub fn finished(&self, range: &Range<u32>) -> f64 {
        if self.identity.adaptive {
            let done = self.mean_samples() / f64::from(self.identity.samples);
            let is_finished = self.step >= self.identity.samples && self.has_reached_goals();
            // Goals are rounded down.
            return if is_finished { 1.0 } else { done.min(0.999) };
        }
        let asked = u64::from(range.start)..u64::from(range.end);
        let grid = self.tiles();
        let lacking =
            |set: &SampleSet| set.missing(asked.clone()).iter().map(|r| r.end - r.start).sum::<u64>();
        let missing: f64 =
            (0..grid.count()).map(|t| lacking(self.held(t)) as f64 * grid.rect(t).area() as f64).sum();
        let all = self.region.area() as f64 * asked.end.saturating_sub(asked.start) as f64;
        if all > 0.0 { 1.0 - missing / all } else { 1.0 }
    }

    /// Updates the count of non-finite samples and splats.
    pub(crate) fn count_non_finite(&mut self) {
        let mut all = NonFinite::default();
        self.bands.iter().for_each(|band| all.merge(&band.non_finite));
        let light = self.splats.as_ref().map_or(0, |splats| splats.non_finite);
        all.merge(&NonFinite { count: light, first: None });
        self.non_finite = all;
    }

    /// The band of a pixel of the region, and the pixel's index in it.
    pub(super) fn place(&self, x: u32, y: u32) -> Option<(&Band, usize)> {
        let row = y.checked_sub(self.region.y)?;
        let i = (row % TILE) as usize * self.region.width as usize + x.checked_sub(self.region.x)? as usize;
        Some((self.bands.get((row / TILE) as usize)?, i))
    }

    /// The sums of a pixel of the region.
    pub(crate) fn sum(&self, x: u32, y: u32) -> PixelSum {
        self.place(x, y).map_or_else(PixelSum::default, |(band, i)| band.sum(i))
    }

    /// The sum of the weights of a pixel's samples; 0 outside the region.
    pub fn weight(&self, x: u32, y: u32) -> f64 {
        self.sum(x, y).weight()
    }

    /// The number of finite samples of all pixels.
    pub fn samples(&self) -> u64 {
        self.bands.iter().map(Band::samples).sum()
    }

    /// Size in bytes.
    pub fn memory(&self) -> usize {
        self.region.area() as usize * self.bytes_per_pixel + self.splats.as_ref().map_or(0, Splats::memory)
    }
}
