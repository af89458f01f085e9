//! Exposure and auto-exposure.
//!
//! Auto-exposure maps the logarithmic mean of the luminance to middle grey. The mean is taken from a histogram
//! over the leading bits of floats, so it does not depend on the order of pixels.

use crate::color::Spectrum;
use crate::math::elementary::{ln, pow};

/// The luminance to which auto-exposure maps the mean of a picture.
const MIDDLE_GREY: f64 = 0.18;

/// Fraction of the pixels ignored at either end.
const CLIPPED: f64 = 0.05;

/// Mantissa bits of a luminance that are dropped: bin centres are within a relative error of 2⁻¹².
const DROPPED: u32 = 12;

/// Bins for all positive finite floats.
const BINS: usize = (f32::MAX.to_bits() >> DROPPED) as usize + 1;

/// 2^stops.
pub(super) fn factor(stops: f64) -> f32 {
    pow(2.0, stops.clamp(-120.0, 120.0)) as f32
}

/// The exposure in stops that maps the logarithmic mean of the luminance to middle grey, 0.18: `auto_exposure` of the
/// film. Pixels are premultiplied; the darkest and the brightest 5 % are left out, as are pixels that are black,
/// non-finite or without coverage. 0 without light.
pub fn auto_exposure(linear: &[[f32; 4]]) -> f64 {
    let mut luminances = Luminances::default();
    linear.iter().for_each(|pixel| luminances.add(*pixel));
    luminances.exposure()
}

/// A histogram of pixel luminances.
#[derive(Default)]
pub(super) struct Luminances {
    /// Empty until the first pixel.
    bins: Vec<u64>,
    count: u64,
}

impl Luminances {
    /// Adds a pixel (colour times coverage, and coverage) by the luminance of its colour. Pixels that are black,
    /// non-finite or without coverage are ignored.
    pub(super) fn add(&mut self, [r, g, b, a]: [f32; 4]) {
        if a <= 0.0 || a.is_nan() {
            return;
        }
        let luminance = Spectrum::new(r, g, b).luminance() / a;
        if luminance > 0.0 && luminance.is_finite() {
            if self.bins.is_empty() {
                self.bins = vec![0; BINS];
            }
            self.bins[(luminance.to_bits() >> DROPPED) as usize] += 1;
            self.count += 1;
        }
    }

    /// The stops that map the logarithmic mean to [`MIDDLE_GREY`], without the darkest and the brightest pixels;
    /// 0 without light.
    pub(super) fn exposure(&self) -> f64 {
        let mean = self.mean_of_logarithms();
        mean.map_or(0.0, |mean| (ln(MIDDLE_GREY) - mean) * std::f64::consts::LOG2_E)
    }

    fn mean_of_logarithms(&self) -> Option<f64> {
        let (first, last) = (self.count as f64 * CLIPPED, self.count as f64 * (1.0 - CLIPPED));
        let (mut sum, mut weight, mut below) = (0.0, 0.0, 0.0);
        for (i, count) in self.bins.iter().enumerate().filter(|(_, count)| **count > 0) {
            let above = below + *count as f64;
            // The part of the bin between the two ends.
            let weight_in_range = above.min(last) - f64::max(below, first);
            if weight_in_range > 0.0 {
                let center = f32::from_bits(((i as u32) << DROPPED) + (1 << (DROPPED - 1)));
                sum += weight_in_range * ln(f64::from(center));
                weight += weight_in_range;
            }
            below = above;
        }
        (weight > 0.0).then(|| sum / weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exposure(pixels: impl IntoIterator<Item = [f32; 4]>) -> f64 {
        let mut luminances = Luminances::default();
        pixels.into_iter().for_each(|p| luminances.add(p));
        luminances.exposure()
    }

    fn grey(v: f32) -> [f32; 4] {
        [v, v, v, 1.0]
    }

    #[test]
    fn a_constant_becomes_middle_grey() {
        for v in [1e-30, 0.003, 0.18, 0.5, 1000.0, 1e30f32] {
            let shown = f64::from(v) * pow(2.0, exposure(vec![grey(v); 7]));
            assert!((shown / 0.18 - 1.0).abs() < 3e-4, "{v}: {shown}");
        }
        assert_eq!(factor(3.0), 8.0);
        assert_eq!(factor(-2.0), 0.25);
    }

    #[test]
    fn the_mean_is_that_of_logarithms_in_any_order() {
        let mut pixels: Vec<_> = (0..=1000).map(|i| grey(pow(2.0, f64::from(i) / 100.0) as f32)).collect();
        let found = exposure(pixels.clone());
        // Symmetric around 2⁵.
        assert!((found - (ln(0.18) * std::f64::consts::LOG2_E - 5.0)).abs() < 1e-3, "{found}");
        pixels.reverse();
        assert_eq!(exposure(pixels), found);
    }

    #[test]
    fn few_pixels_do_not_decide() {
        let mut pixels = vec![grey(0.18); 960];
        pixels.extend([grey(1e30); 40]);
        assert!(exposure(pixels).abs() < 1e-3);
    }

    #[test]
    fn only_covered_pixels_with_light_count() {
        let odd = [
            [0.0, 0.0, 0.0, 1.0],
            [f32::NAN, 1.0, 1.0, 1.0],
            [f32::INFINITY, 1.0, 1.0, 1.0],
            [9.0, 9.0, 9.0, 0.0],
            [-1.0, -1.0, -1.0, 1.0],
            [1.0, 1.0, 1.0, f32::NAN],
        ];
        assert_eq!(exposure(odd), 0.0);
        assert_eq!(exposure([]), 0.0);
        // Colours are stored times coverage.
        let covered = exposure([[0.09, 0.09, 0.09, 0.5]].into_iter().chain(odd));
        assert!(covered.abs() < 1e-3, "{covered}");
    }
}
