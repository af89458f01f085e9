//! Sums of further values of the pixels of a tile: AOVs, and those of the error estimate.
//!
//! A sample adds to dozens of sums, with a wide filter in many pixels. So most additions are to 64-bit integers, without a
//! branch, in units of 2^-44: values of at most [`MOST`], which cannot overflow within [`MOST_SAMPLES`] samples. Then they
//! are moved to 128-bit integers, to which larger values are added at once. Which way a value takes depends on
//! its sample alone, and integer sums on no order.
//!
//! A float is rounded to an integer by adding 1.5 · 2^52, which shifts its fraction out of the mantissa: the bits of the sum
//! are those of 1.5 · 2^52 plus the integer. Unlike a conversion, compilers turn this into SIMD instructions.

use super::error::{ERROR_SUMS, ErrorSample};
use super::wide_sum::{COLOR, add_to};

/// The largest absolute value, times its weight, of the fast way: 2^6 units of 2^44.
const MOST: f64 = 64.0;

/// The largest number of samples before sums of such values are moved: 2^13 times 2^50 is 2^63.
const MOST_SAMPLES: u32 = 8000;

/// Rounds floats below 2^51 to integers.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// `values` times `weight`, rounded, added to `sums`.
#[inline]
fn add_all(sums: &mut [i64], values: &[f64], weight: f64) {
    const BITS: i64 = SHIFT.to_bits() as i64;
    for (sum, value) in sums.iter_mut().zip(values) {
        let rounded = ((value * weight + SHIFT).to_bits() as i64).wrapping_sub(BITS);
        *sum = sum.wrapping_add(rounded);
    }
}

/// Further sums of the pixels of a tile.
#[derive(Clone, Debug, Default)]
pub(super) struct ExtraSums {
    /// `channels` per pixel.
    sums: Vec<i128>,
    /// What is to be added to them.
    recent: Vec<i64>,
    /// Number of samples in `recent`.
    samples: u32,
    /// Sums per pixel: those of values and, behind them, of the error estimate.
    channels: usize,
    estimates_error: bool,
    /// The sample that is added: its values in units of 2^-44, with 0 in place of large ones.
    scaled: Vec<f64>,
    /// Its large values, with their channels.
    large: Vec<(usize, f64)>,
}

impl ExtraSums {
    /// Clears the sums of `pixels` pixels, for samples with `channels` values.
    pub(super) fn reset(&mut self, pixels: usize, channels: usize, estimates_error: bool) {
        self.channels = channels + if estimates_error { ERROR_SUMS } else { 0 };
        self.estimates_error = estimates_error;
        self.samples = 0;
        self.sums.clear();
        self.sums.resize(pixels * self.channels, 0);
        self.recent.clear();
        self.recent.resize(pixels * self.channels, 0);
    }

    /// The sums of some pixels, in units of 2^-44.
    pub(super) fn of_pixels(&self, pixels: std::ops::Range<usize>) -> impl Iterator<Item = i128> + '_ {
        let range = pixels.start * self.channels..pixels.end * self.channels;
        let sums = self.sums[range.clone()].iter().zip(&self.recent[range]);
        sums.map(|(sum, recent)| sum.wrapping_add(i128::from(*recent)))
    }

    /// Sets the sample that [`ExtraSums::add`] adds. Its values must be finite.
    #[inline]
    pub(super) fn begin_sample(&mut self, values: &[f32]) {
        if self.channels == 0 {
            return;
        }
        if self.samples >= MOST_SAMPLES {
            for (sum, recent) in self.sums.iter_mut().zip(&mut self.recent) {
                *sum = sum.wrapping_add(i128::from(std::mem::take(recent)));
            }
            self.samples = 0;
        }
        self.samples += 1;
        self.large.clear();
        self.scaled.clear();
        if values.is_empty() {
            return;
        }
        self.scaled.extend(values.iter().map(|v| f64::from(*v) * COLOR));
        for (channel, scaled) in self.scaled.iter_mut().enumerate() {
            if scaled.abs() > MOST * COLOR {
                self.large.push((channel, *scaled / COLOR));
                *scaled = 0.0;
            }
        }
    }

    /// Adds the sample to a pixel, at most once to each.
    #[inline]
    pub(super) fn add(&mut self, pixel: usize, error: &ErrorSample, weight: f64) {
        if self.channels == 0 {
            return;
        }
        let range = pixel * self.channels..(pixel + 1) * self.channels;
        let recent = &mut self.recent[range.clone()];
        if weight.abs() <= 1.0 {
            add_all(recent, &self.scaled, weight);
        } else {
            let sums = self.sums[range.clone()].iter_mut().zip(&self.scaled);
            sums.for_each(|(sum, v)| add_to(sum, v / COLOR * weight));
        }
        for (channel, value) in &self.large {
            add_to(&mut self.sums[range.start + channel], value * weight);
        }
        if self.estimates_error {
            let from = self.channels - ERROR_SUMS;
            add_error(&mut self.sums[range][from..], &mut recent[from..], error, weight);
        }
    }
}

/// Adds the terms of the error estimate to its sums.
#[inline]
fn add_error(sums: &mut [i128], recent: &mut [i64], error: &ErrorSample, weight: f64) {
    let terms = error.terms(weight);
    if terms.iter().all(|v| v.abs() <= MOST) {
        add_all(recent, &terms.map(|v| v * COLOR), 1.0);
    } else {
        sums.iter_mut().zip(terms).for_each(|(sum, v)| add_to(sum, v));
    }
}

/// The sums of the error estimate for a pixel with one sample of weight 1.
pub(super) fn error_of_one(error: &ErrorSample) -> [i128; ERROR_SUMS] {
    let (mut sums, mut recent) = ([0; ERROR_SUMS], [0; ERROR_SUMS]);
    add_error(&mut sums, &mut recent, error, 1.0);
    std::array::from_fn(|i| sums[i] + i128::from(recent[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Spectrum;
    use crate::film::Fixed96;

    #[test]
    fn large_and_small_values_and_many_samples_are_exact() {
        let random =
            |i: u32, k: u32| f64::from((i.wrapping_mul(2_654_435_761) >> 8).wrapping_mul(k) >> 4 & 0xffff);
        let sample = |i: u32| {
            let scales = [1e-9, 1e-4, 1e-3, 1.0, 1e4, -1e-4];
            let values: Vec<f32> =
                scales.iter().zip(1..).map(|(s, k)| (random(i, 2 * k + 1) * s) as f32).collect();
            (values, random(i, 17) / 65536.0 * if i.is_multiple_of(3) { -1.0 } else { 1.0 })
        };
        let add = |order: &mut dyn Iterator<Item = u32>| {
            let mut sums = ExtraSums::default();
            sums.reset(2, 6, true);
            for i in order {
                let (values, weight) = sample(i);
                sums.begin_sample(&values);
                let color =
                    Spectrum::grey((random(i, 29) * if i.is_multiple_of(100) { 1e3 } else { 1e-4 }) as f32);
                sums.add(1, &ErrorSample::new(color, i), weight);
            }
            assert!(sums.of_pixels(0..1).all(|v| v == 0));
            sums.of_pixels(1..2).collect::<Vec<_>>()
        };
        let count = 3 * MOST_SAMPLES + 17;
        let sums = add(&mut (0..count));
        assert_eq!(sums, add(&mut (0..count).rev()));
        for (channel, sum) in sums.iter().take(6).enumerate() {
            let exact: f64 = (0..count).map(sample).map(|(v, w)| f64::from(v[channel]) * w).sum();
            let found = Fixed96::from_i128(*sum).mean(1.0);
            // Each sample is rounded to half a unit.
            let most = f64::from(count) / COLOR + 1e-9 * exact.abs();
            assert!((found - exact).abs() < most, "{channel}: {found} {exact}");
        }
        // Weights above 1, as of a filter of another kind.
        let mut sums = ExtraSums::default();
        sums.reset(1, 1, false);
        sums.begin_sample(&[60.0]);
        sums.add(0, &ErrorSample::new(Spectrum::BLACK, 0), 64.0);
        assert_eq!(Fixed96::from_i128(sums.of_pixels(0..1).sum()).mean(1.0), 3840.0);
    }
}
