//! The sums of one tile while its samples are traced.

use std::ops::Range;

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Simd, Work, dispatch};

use super::PixelRect;
use super::brightest::Brightest;
use super::error::ErrorSample;
use super::extra_sums::ExtraSums;
use super::tile_pixels::{TilePixels, TileSample};
use crate::color::Spectrum;
use crate::filter::Filter;
use crate::math::DVec2;

/// A sample's values.
#[derive(Clone, Copy, Debug)]
pub struct SampleValues<'a> {
    /// Colour times coverage.
    pub color: Spectrum,
    /// Coverage, 0..=1.
    pub alpha: f32,
    /// One value for each additional channel of the film.
    pub extra: &'a [f32],
    /// The index of the sample, for the error estimate.
    pub index: u32,
}

impl SampleValues<'_> {
    fn is_finite(&self) -> bool {
        self.color.is_finite() && self.alpha.is_finite() && self.extra.iter().all(|v| v.is_finite())
    }
}

/// Sums of the pixels of a tile and a border around it. A worker fills them and then adds them to the film.
#[derive(Clone, Debug)]
pub struct TileSums {
    rect: PixelRect,
    pub(super) pixels: TilePixels,
    /// Sums of additional channels.
    pub(super) extra: ExtraSums,
    /// Whether the film estimates its error.
    pub(super) estimates_error: bool,
    /// The brightest samples of each pixel; empty unless the film keeps them.
    pub(super) brightest: Vec<Brightest>,
}

impl Default for TileSums {
    fn default() -> TileSums {
        TileSums {
            rect: PixelRect { x: 0, y: 0, width: 0, height: 0 },
            pixels: TilePixels::default(),
            extra: ExtraSums::default(),
            estimates_error: false,
            brightest: Vec::new(),
        }
    }
}

impl TileSums {
    /// Width in pixels of the border that the filter reaches from inside a tile.
    pub fn border(filter: &Filter) -> u32 {
        (filter.radius() - 0.5).ceil().max(0.0) as u32
    }

    /// Clears the sums and sets their rectangle, for a film with `channels` channels in addition to colour and
    /// coverage, which estimates its error or not, and keeps no brightest samples.
    pub fn reset(&mut self, rect: PixelRect, channels: usize, estimates_error: bool) {
        let count = rect.area() as usize;
        self.rect = rect;
        self.pixels.reset(count);
        self.extra.reset(count, channels);
        self.estimates_error = estimates_error;
        self.keep_brightest(false);
    }

    /// The pixels.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// For each of some pixels, the sums of its additional channels, then those of its error estimate.
    pub(super) fn extra_of(&self, pixels: Range<usize>) -> impl Iterator<Item = i128> + '_ {
        pixels.flat_map(|pixel| {
            let error = self.estimates_error.then(|| self.pixels.error(pixel));
            self.extra.of_pixel(pixel).chain(error.into_iter().flatten())
        })
    }

    /// Adds a sample with a weight of -64..=64 to the pixel at an index, row by row. A non-finite sample is not
    /// added. Returns whether the sample is finite.
    pub fn add_weighted(&mut self, pixel: usize, sample: &SampleValues<'_>, weight: f32) -> bool {
        if !(sample.is_finite() && weight.is_finite()) {
            self.pixels.omit(pixel);
            return false;
        }
        let prepared = self.begin_sample(sample);
        self.add(pixel, &prepared, weight);
        self.note_bright(pixel, sample.color, weight, None, sample.index);
        true
    }

    #[inline(always)]
    fn begin_sample(&mut self, sample: &SampleValues<'_>) -> TileSample {
        self.pixels.begin_sample();
        self.extra.begin_sample(sample.extra);
        let error = ErrorSample::new(sample.color, sample.index);
        TileSample::new(sample.color, sample.alpha, &error)
    }

    #[inline(always)]
    fn add(&mut self, pixel: usize, sample: &TileSample, weight: f32) {
        self.pixels.add(pixel, sample, weight);
        self.extra.add(pixel, f64::from(weight));
    }

    /// [`TileSums::splat`] for samples and their positions. Calls `omit` with the index of each non-finite sample.
    pub fn splat_all<'s>(
        &mut self,
        set: InstructionSet,
        filter: &Filter,
        samples: impl Iterator<Item = (DVec2, SampleValues<'s>)>,
        omit: impl FnMut(usize),
    ) {
        dispatch(set, SplatAll { sums: self, filter, samples, omit });
    }

    /// Adds a sample at a position of the picture to every pixel that the filter reaches, weighted by the filter,
    /// whose peak has weight 1. Returns whether the sample is finite.
    #[inline(always)]
    pub fn splat(&mut self, filter: &Filter, place: DVec2, sample: &SampleValues<'_>) -> bool {
        let PixelRect { x: left, y: top, width, height } = self.rect;
        let mut along_x = [0.0; MAX_REACHED];
        let columns = reached(filter, place.x, left, width, &mut along_x);
        let mut along_y = [0.0; MAX_REACHED];
        let rows = reached(filter, place.y, top, height, &mut along_y);
        if !sample.is_finite() {
            for (y, vertical) in rows.zip(along_y) {
                let reached =
                    columns.clone().zip(along_x).filter(|(_, horizontal)| horizontal * vertical != 0.0);
                reached.for_each(|(x, _)| self.pixels.omit(((y - top) * width + x - left) as usize));
            }
            return false;
        }
        let prepared = self.begin_sample(sample);
        for (y, vertical) in rows.zip(along_y) {
            let row = (y - top) * width;
            for (x, horizontal) in columns.clone().zip(along_x) {
                let weight = (horizontal * vertical) as f32;
                let pixel = (row + x - left) as usize;
                self.add(pixel, &prepared, weight);
                if weight != 0.0 {
                    self.note_bright(pixel, sample.color, weight, Some(place), sample.index);
                }
            }
        }
        true
    }
}

/// The loop of [`TileSums::splat_all`], compiled for each instruction set.
struct SplatAll<'a, I, F> {
    sums: &'a mut TileSums,
    filter: &'a Filter,
    samples: I,
    omit: F,
}

impl<'s, I: Iterator<Item = (DVec2, SampleValues<'s>)>, F: FnMut(usize)> Work for SplatAll<'_, I, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, _: S) {
        for (i, (at, values)) in self.samples.enumerate() {
            if !self.sums.splat(self.filter, at, &values) {
                (self.omit)(i);
            }
        }
    }
}

/// The maximum number of pixels that a filter reaches along an axis: radius 16, and both ends.
pub(super) const MAX_REACHED: usize = 34;

/// The pixels along one axis, from `start`, whose centres are within the filter's radius of `at`, and their weights.
#[inline]
pub(super) fn reached(
    filter: &Filter,
    at: f64,
    start: u32,
    size: u32,
    weights: &mut [f64; MAX_REACHED],
) -> Range<u32> {
    let first = ceil(at - filter.radius() - 0.5).max(f64::from(start));
    let last = floor(at + filter.radius() - 0.5).min(f64::from(start + size) - 1.0);
    if first > last || !at.is_finite() {
        return 0..0;
    }
    for (i, weight) in weights.iter_mut().enumerate().take((last - first) as usize + 1) {
        *weight = filter.weight(at - (first + i as f64 + 0.5));
    }
    first as u32..last as u32 + 1
}

/// As [`f64::floor`] for positions in pictures, without a call.
#[inline]
fn floor(x: f64) -> f64 {
    let whole = x as i64 as f64;
    if whole > x { whole - 1.0 } else { whole }
}

#[inline]
fn ceil(x: f64) -> f64 {
    -floor(-x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Film, FilmDesc, NonFinite, SampleSet, TileGrid};
    use crate::filter::FilterKind;

    const SIZE: u32 = 40;

    /// The settings of an empty scene.
    fn plain() -> FilmDesc {
        crate::description::SceneDesc::default().film
    }

    fn random(i: u32, k: u32) -> f32 {
        ((i.wrapping_mul(2_654_435_761) >> 8).wrapping_mul(k) >> 4 & 0xffff) as f32 / 65536.0
    }

    /// Four samples per pixel of a tile: position, colour, coverage, one additional channel.
    fn samples_of(tile: &PixelRect) -> Vec<(DVec2, [f32; 5])> {
        let mut out = Vec::new();
        for i in 0..tile.area() as u32 * 4 {
            let (x, y) = (tile.x + i / 4 % tile.width, tile.y + i / 4 / tile.width);
            let id = (y * SIZE + x) * 4 + i % 4;
            let at =
                DVec2::new(f64::from(x) + f64::from(random(id, 3)), f64::from(y) + f64::from(random(id, 7)));
            out.push((at, [1, 5, 9, 11, 13].map(|k| random(id, k))));
        }
        out
    }

    fn film(filter: FilterKind, order: &[usize]) -> Film {
        let desc = FilmDesc { width: SIZE, height: SIZE, ..plain() };
        let mut film = Film::with_channels(&desc, vec![Channel::new("Z")]).unwrap();
        let (filter, grid) = (Filter::new(filter, None), TileGrid::new(film.region));
        let mut sums = TileSums::default();
        for &tile in order {
            let rect = grid.rect(tile);
            sums.reset(rect.grown(TileSums::border(&filter), &film.region), 1, false);
            for (place, [r, g, b, alpha, z]) in samples_of(&rect) {
                let color = Spectrum::new(r, g, b);
                assert!(sums.splat(&filter, place, &SampleValues { color, alpha, extra: &[z], index: 0 }));
            }
            let mut samples = SampleSet::default();
            samples.insert(0..1);
            assert!(film.share().deposit_sums((tile, None), &sums, &samples, &NonFinite::default(), 0));
        }
        film
    }

    #[test]
    fn samples_count_in_every_pixel_their_filter_reaches() {
        for kind in [FilterKind::Box, FilterKind::Tent, FilterKind::Gaussian, FilterKind::BlackmanHarris] {
            let forward: Vec<usize> = (0..9).collect();
            let first = film(kind, &forward);
            let bytes = first.to_bytes();
            assert!(bytes == film(kind, &[8, 3, 1, 0, 7, 2, 4, 6, 5]).to_bytes(), "{kind:?}: any order");
            let filter = Filter::new(kind, None);
            let all: Vec<_> =
                forward.iter().flat_map(|t| samples_of(&TileGrid::new(first.region).rect(*t))).collect();
            for (x, y) in [(0, 0), (15, 15), (16, 15), (17, 31), (39, 39), (31, 8), (5, 32)] {
                let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let (mut sum, mut total) = ([0.0; 5], 0.0);
                for (place, values) in &all {
                    let weight = filter.density(*place - center);
                    total += weight;
                    sum.iter_mut().zip(values).for_each(|(s, v)| *s += weight * f64::from(*v));
                }
                let [r, g, b, a] = first.sum(x, y).mean().unwrap();
                let z = first.channel("Z", x, y).unwrap();
                for (shown, exact) in [r, g, b, a, z].into_iter().zip(sum) {
                    let exact = exact / total;
                    assert!((f64::from(shown) - exact).abs() < 1e-5, "{kind:?} ({x}, {y}): {shown} {exact}");
                }
            }
        }
    }

    #[test]
    fn a_non_finite_sample_is_omitted_from_every_pixel() {
        let filter = Filter::new(FilterKind::Tent, None);
        let mut sums = TileSums::default();
        sums.reset(PixelRect { x: 0, y: 0, width: 4, height: 4 }, 1, false);
        let sample = SampleValues { color: Spectrum::WHITE, alpha: 1.0, extra: &[f32::INFINITY], index: 0 };
        assert!(!sums.splat(&filter, DVec2::new(1.7, 1.7), &sample));
        let unknown = |i: usize| sums.pixels.narrow(i).mean().is_some_and(|m| m[0].is_nan());
        assert_eq!((0..16).filter(|i| unknown(*i)).collect::<Vec<_>>(), [5, 6, 9, 10]);
        assert!(sums.extra_of(0..16).all(|v| v == 0));
        // Outside the tile, no pixel is reached.
        assert!(sums.splat(&filter, DVec2::new(-3.0, 900.0), &SampleValues { extra: &[0.0], ..sample }));
    }
}
