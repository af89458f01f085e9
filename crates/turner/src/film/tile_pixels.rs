//! Sums of the pixels of a tile while its samples are traced.
//!
//! To each pixel that its filter reaches, a sample adds its colour, its coverage, 1 and the terms of the error estimate,
//! multiplied by the filter weight or its square and rounded to 64-bit integers. The loops over these products have no
//! branches, so compilers vectorize them. Bright samples are split into a multiple of 2^32 and a remainder, which have
//! sums of their own. No sum overflows within [`MOST_SAMPLES`] samples; then they move to 128-bit integers. The result
//! does not depend on the order of samples.

use super::error::{ERROR_SUMS, ErrorSample};
use super::fixed::{COLOR, LIMIT, ONE, round, round_small, whole};
use super::{Fixed96, PixelSum};
use crate::color::Spectrum;

/// Sums per pixel: red, green, blue, coverage, weight; Σ' wl, Σ' w ([`super::error`]); 1 if a sample was not finite; Σ w²l²,
/// Σ w²l, Σ w²; padding to a multiple of four.
const SUMS: usize = 12;

/// The first of the sums of squared weights.
const SQUARES: usize = 8;

/// The mark of pixels with a non-finite sample. Finite samples add 0 to it.
const OMITTED: usize = 7;

/// Where the sums of the error estimate are, in the order of the film.
const OF_ERROR: [usize; ERROR_SUMS] = [8, 9, 10, 5, 6];

/// The largest absolute value of a sample that is not bright. In units of 2^-44 it is 2^50.
pub(super) const MOST: f64 = 64.0;

/// The number of samples after which the sums move to 128-bit integers: 2^13 values of 2^50 are 2^63.
pub(super) const MOST_SAMPLES: u32 = 8000;

/// The unit of the sums [`TilePixels::high`].
const HIGH: f64 = (1u64 << HIGH_BITS) as f64;
const HIGH_BITS: u32 = 32;

/// The sums of a pixel: 96 bytes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
struct Sums([i64; SUMS]);

/// A sample, prepared to be added to several pixels.
pub(super) struct TileSample {
    /// What it adds with a weight of 1, in the units of the sums.
    values: [f64; SUMS],
    /// Whether one of them is larger than [`MOST`].
    is_bright: bool,
}

impl TileSample {
    /// A finite sample: colour times coverage, coverage, and its part of the error estimate.
    #[inline(always)]
    pub(super) fn new(color: Spectrum, alpha: f32, error: &ErrorSample) -> TileSample {
        let [r, g, b] = color.to_array().map(f64::from);
        let [l2, l, one, half_l, half] = error.terms();
        let alpha = f64::from(alpha);
        // Coverage and weight have coarser units.
        let coarse = ONE / COLOR;
        let values = [r, g, b, alpha * coarse, coarse, half_l, half, 0.0, l2, l, one, 0.0];
        let is_bright = values.iter().fold(false, |bright, v| bright | (v.abs() > MOST));
        TileSample { values: values.map(|v| v * COLOR), is_bright }
    }
}

/// Sums of pixels, equal to those of [`PixelSum::add_weighted`] bit for bit.
#[derive(Clone, Debug, Default)]
pub(super) struct TilePixels {
    sums: Vec<Sums>,
    /// Sums of the multiples of 2^32 of bright samples; empty without bright samples.
    high: Vec<Sums>,
    /// Sums of earlier samples; empty before the first move.
    moved: Vec<[i128; SUMS]>,
    /// Number of samples in `sums` and `high`.
    samples: u32,
}

impl TilePixels {
    /// Clears the sums of `count` pixels.
    pub(super) fn reset(&mut self, count: usize) {
        self.sums.clear();
        self.sums.resize(count, Sums::default());
        self.high.clear();
        self.moved.clear();
        self.samples = 0;
    }

    /// The number of pixels.
    pub(super) fn len(&self) -> usize {
        self.sums.len()
    }

    /// Counts a sample; call it before [`TilePixels::add`].
    #[inline(always)]
    pub(super) fn begin_sample(&mut self) {
        if self.samples >= MOST_SAMPLES {
            self.move_sums();
        }
        self.samples += 1;
    }

    #[cold]
    fn move_sums(&mut self) {
        self.moved.resize(self.sums.len(), [0; SUMS]);
        for pixel in 0..self.sums.len() {
            self.moved[pixel] = std::array::from_fn(|i| self.sum(pixel, i));
        }
        self.sums.fill(Sums::default());
        self.high.fill(Sums::default());
        self.samples = 0;
    }

    /// Adds a finite sample to a pixel, with a weight of -64..=64. A sample is added to a pixel at most once.
    #[inline(always)]
    pub(super) fn add(&mut self, pixel: usize, sample: &TileSample, weight: f32) {
        let weight = f64::from(weight);
        let squared = weight * weight;
        let products = sample.values.iter().enumerate();
        let products = products.map(|(i, value)| value * if i < SQUARES { weight } else { squared });
        if sample.is_bright || weight.abs() > 1.0 {
            return self.add_bright(pixel, products);
        }
        for (sum, product) in self.sums[pixel].0.iter_mut().zip(products) {
            *sum = sum.wrapping_add(round_small(product));
        }
    }

    #[inline(always)]
    fn add_bright(&mut self, pixel: usize, products: impl Iterator<Item = f64>) {
        if self.high.is_empty() {
            self.high.resize(self.sums.len(), Sums::default());
        }
        let sums = self.sums[pixel].0.iter_mut().zip(&mut self.high[pixel].0);
        for ((sum, high_sum), product) in sums.zip(products) {
            let product = product.clamp(-LIMIT, LIMIT);
            let high = product * (1.0 / HIGH);
            *high_sum = high_sum.wrapping_add(round_small(high));
            // The difference is exact: a multiple of the last place of the product, and of at most 2^31.
            *sum = sum.wrapping_add(round_small(product - whole(high) * HIGH));
        }
    }

    /// Marks a pixel: a non-finite sample was not added.
    pub(super) fn omit(&mut self, pixel: usize) {
        self.sums[pixel].0[OMITTED] |= 1;
    }

    #[inline]
    fn sum(&self, pixel: usize, i: usize) -> i128 {
        let moved = self.moved.get(pixel).map_or(0, |sums| sums[i]);
        let high = self.high.get(pixel).map_or(0, |sums| i128::from(sums.0[i]) << HIGH_BITS);
        moved.wrapping_add(high).wrapping_add(i128::from(self.sums[pixel].0[i]))
    }

    /// Whether 64 bits hold all sums, as [`TilePixels::add_to_words`] needs.
    pub(super) fn are_plain(&self) -> bool {
        self.high.is_empty() && self.moved.is_empty()
    }

    /// Adds the sums of a pixel to the film's words of that pixel, and the sums of the error estimate to `error`. The sums
    /// must be plain.
    #[inline(always)]
    pub(super) fn add_to_words(
        &self,
        pixel: usize,
        words: &mut [u32; PixelSum::WORDS],
        error: Option<&mut [[u32; 3]; ERROR_SUMS]>,
    ) {
        let sums = &self.sums[pixel].0;
        let [r, g, b, alpha, weight, ..] = *sums;
        PixelSum::add_to_words(words, [r, g, b, alpha, weight], sums[OMITTED] != 0);
        if let Some(error) = error {
            for (words, i) in error.iter_mut().zip(OF_ERROR) {
                Fixed96::add_to_words(words, sums[i]);
            }
        }
    }

    /// The sums of a pixel as a film holds them.
    pub(super) fn narrow(&self, pixel: usize) -> PixelSum {
        let sum = |i| self.sum(pixel, i);
        let rgb = [0, 1, 2].map(|i| Fixed96::from_i128(sum(i)));
        let omitted = i64::from(sum(OMITTED) != 0);
        PixelSum::new(rgb, sum(3) as i64, (sum(4) as i64).wrapping_mul(2) | omitted)
    }

    /// The sums of the error estimate of a pixel, in units of 2^-44.
    pub(super) fn error(&self, pixel: usize) -> [i128; ERROR_SUMS] {
        OF_ERROR.map(|i| self.sum(pixel, i))
    }
}

/// The sums of the error estimate for a pixel with one sample of weight 1.
pub(super) fn error_of_one(error: &ErrorSample) -> [i128; ERROR_SUMS] {
    error.terms().map(|v| round(v * COLOR))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(i: u32, k: u32) -> f32 {
        ((i * k + 17) % 1009) as f32 / 1009.0
    }

    #[test]
    fn sums_of_tiles_are_those_of_the_film() {
        let (mut wide, mut narrow) = (TilePixels::default(), PixelSum::default());
        wide.reset(2);
        for i in 0..400u32 {
            let scale = [1.0, 1e-7, 63.0, 65.0, 5e3, 3e8, 9e9, 1e-13][i as usize % 8];
            let color = Spectrum::new(scale * unit(i, 7919), -unit(i, 31), scale * unit(i, 104_729));
            let (alpha, weight) = (unit(i, 13), [1.0, 64.0, -0.3, unit(i, 271)][i as usize % 4]);
            wide.begin_sample();
            wide.add(1, &TileSample::new(color, alpha, &ErrorSample::new(color, i)), weight);
            narrow.add_weighted(color, alpha, weight);
            assert_eq!(wide.narrow(1), narrow, "{i}");
        }
        assert!(!wide.are_plain());
        wide.omit(1);
        narrow.omit();
        assert_eq!(wide.narrow(1), narrow);
        assert_eq!(wide.narrow(0), PixelSum::default());
        assert_eq!(wide.error(0), [0; ERROR_SUMS]);
    }

    #[test]
    fn plain_sums_are_added_to_words() {
        let mut words = PixelSum::default().to_words();
        let mut error = [[0; 3]; ERROR_SUMS];
        let (mut expected, mut expected_error) = (PixelSum::default(), [0i128; ERROR_SUMS]);
        for tile in 0..50u32 {
            let mut pixels = TilePixels::default();
            pixels.reset(1);
            for i in 20 * tile..20 * tile + 20 {
                let color = Spectrum::new(3.0 * unit(i, 7919), -unit(i, 31), 1e-9 * unit(i, 104_729));
                pixels.begin_sample();
                let sample = TileSample::new(color, unit(i, 13), &ErrorSample::new(color, i));
                pixels.add(0, &sample, 1.0 - 1.2 * unit(i, 271));
            }
            if tile == 30 {
                pixels.omit(0);
            }
            assert!(pixels.are_plain());
            pixels.add_to_words(0, &mut words, Some(&mut error));
            expected.merge(&pixels.narrow(0));
            expected_error.iter_mut().zip(pixels.error(0)).for_each(|(sum, v)| *sum += v);
            assert_eq!(PixelSum::from_words(&words), expected, "{tile}");
            assert_eq!(error.map(Fixed96::from_words), expected_error.map(Fixed96::from_i128), "{tile}");
        }
    }

    #[test]
    fn large_and_small_values_and_many_samples_are_exact() {
        let sample = |i: u32| {
            let scale = if i.is_multiple_of(100) { 1e2 } else { 1e-3 };
            let sign = if i.is_multiple_of(3) { -1.0 } else { 1.0 };
            (Spectrum::grey(scale * unit(i, 29)), sign * unit(i, 17))
        };
        let sums = |order: &mut dyn Iterator<Item = u32>| {
            let mut pixels = TilePixels::default();
            pixels.reset(2);
            for i in order {
                let (color, weight) = sample(i);
                pixels.begin_sample();
                pixels.add(1, &TileSample::new(color, 1.0, &ErrorSample::new(color, i)), weight);
            }
            (pixels.narrow(1), pixels.error(1))
        };
        let count = 3 * MOST_SAMPLES + 17;
        let (sum, error) = sums(&mut (0..count));
        assert_eq!((sum, error), sums(&mut (0..count).rev()));
        let exact = |term: &dyn Fn(f64, f64, bool) -> f64| {
            let terms = (0..count).map(|i| {
                let (color, weight) = sample(i);
                let is_in_half = (u32::BITS - i.leading_zeros()) % 2 == 1;
                term(f64::from(color.luminance()), f64::from(weight), is_in_half)
            });
            terms.sum::<f64>()
        };
        let half = |h: bool| f64::from(u8::from(h));
        let expected = [
            exact(&|l, w, _| w * w * l * l),
            exact(&|l, w, _| w * w * l),
            exact(&|_, w, _| w * w),
            exact(&|l, w, h| half(h) * w * l),
            exact(&|_, w, h| half(h) * w),
        ];
        for (found, expected) in error.map(|sum| Fixed96::from_i128(sum).mean(1.0)).into_iter().zip(expected)
        {
            // Each sample is rounded to half a unit.
            let most = f64::from(count) / COLOR + 1e-9 * expected.abs();
            assert!((found - expected).abs() < most, "{found} {expected}");
        }
        let weight = exact(&|_, w, _| w);
        assert!((sum.weight() - weight).abs() < f64::from(count) / ONE, "{} {weight}", sum.weight());
    }
}
