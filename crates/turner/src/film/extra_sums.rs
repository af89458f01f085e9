//! Sums of the AOVs of a tile's pixels.
//!
//! Values of at most [`MOST`] are added to 64-bit integers, larger ones to 128-bit integers.

use super::fixed::{COLOR, round, round_small};
use super::tile_pixels::{MOST, MOST_SAMPLES};

/// Adds `values` times `weight`, rounded, to `sums`.
#[inline]
fn add_all(sums: &mut [i64], values: &[f64], weight: f64) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum = sum.wrapping_add(round_small(value * weight));
    }
}

/// Adds a value of any size, rounded, to a sum.
#[inline]
fn add_to(sum: &mut i128, value: f64) {
    *sum = sum.wrapping_add(round(value));
}

/// Sums of the AOVs of the pixels of a tile.
#[derive(Clone, Debug, Default)]
pub(super) struct ExtraSums {
    /// `channels` per pixel.
    sums: Vec<i128>,
    /// What is to be added to them.
    recent: Vec<i64>,
    /// Number of samples in `recent`.
    samples: u32,
    /// Sums per pixel.
    channels: usize,
    /// The sample that is added: its values in units of 2^-44, with 0 in place of large ones.
    scaled: Vec<f64>,
    /// Its large values in the same units, with their channels.
    large: Vec<(usize, f64)>,
}

impl ExtraSums {
    /// Clears the sums of `pixels` pixels, for samples with `channels` values.
    pub(super) fn reset(&mut self, pixels: usize, channels: usize) {
        self.channels = channels;
        self.samples = 0;
        self.sums.clear();
        self.sums.resize(pixels * self.channels, 0);
        self.recent.clear();
        self.recent.resize(pixels * self.channels, 0);
    }

    /// The sums of a pixel, in units of 2^-44.
    pub(super) fn of_pixel(&self, pixel: usize) -> impl Iterator<Item = i128> + '_ {
        let range = pixel * self.channels..(pixel + 1) * self.channels;
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
        self.scaled.extend(values.iter().map(|v| f64::from(*v) * COLOR));
        for (channel, scaled) in self.scaled.iter_mut().enumerate() {
            if scaled.abs() > MOST * COLOR {
                self.large.push((channel, *scaled));
                *scaled = 0.0;
            }
        }
    }

    /// Adds the sample to a pixel, at most once to each.
    #[inline]
    pub(super) fn add(&mut self, pixel: usize, weight: f64) {
        if self.channels == 0 {
            return;
        }
        let range = pixel * self.channels..(pixel + 1) * self.channels;
        let recent = &mut self.recent[range.clone()];
        if weight.abs() <= 1.0 {
            add_all(recent, &self.scaled, weight);
        } else {
            let sums = self.sums[range.clone()].iter_mut().zip(&self.scaled);
            sums.for_each(|(sum, v)| add_to(sum, v * weight));
        }
        for (channel, value) in &self.large {
            add_to(&mut self.sums[range.start + channel], value * weight);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
            sums.reset(2, 6);
            for i in order {
                let (values, weight) = sample(i);
                sums.begin_sample(&values);
                sums.add(1, weight);
            }
            assert!(sums.of_pixel(0).all(|v| v == 0));
            sums.of_pixel(1).collect::<Vec<_>>()
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
        sums.reset(1, 1);
        sums.begin_sample(&[60.0]);
        sums.add(0, 64.0);
        assert_eq!(Fixed96::from_i128(sums.of_pixel(0).sum()).mean(1.0), 3840.0);
    }
}
