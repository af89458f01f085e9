//! Sums of one pixel while a tile is traced.

use super::{Fixed96, PixelSum};
use crate::color::Spectrum;

/// Fixed-point units of a colour of 1: those of [`Fixed96`].
pub(super) const COLOR: f64 = (1u64 << 44) as f64;

/// Fixed-point units of a weight or coverage of 1.
const ONE: f64 = 4_294_967_296.0;

/// Colours below this have sums that a conversion to 64 bits cannot overflow, with weights up to 64.
const MOST: f32 = 8191.0;

/// The same sums as [`PixelSum`], in integers that a processor adds quickly. Both hold the same values bit for bit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WideSum {
    rgb: [i128; 3],
    alpha: i64,
    weight: i64,
}

/// A sample, prepared to be added to several pixels.
pub(super) struct FixedSample {
    rgb: [f64; 3],
    alpha: f64,
    /// Whether no product with a weight overflows 64 bits.
    is_small: bool,
}

impl FixedSample {
    pub(super) fn new(color: Spectrum, alpha: f32) -> FixedSample {
        let is_small = color.to_array().iter().all(|v| v.abs() < MOST);
        FixedSample { rgb: color.to_array().map(f64::from), alpha: f64::from(alpha), is_small }
    }
}

impl WideSum {
    /// Adds a finite sample with a weight of -64..=64.
    #[inline]
    pub(super) fn add(&mut self, sample: &FixedSample, weight: f32) {
        let weight = f64::from(weight);
        for (sum, v) in self.rgb.iter_mut().zip(sample.rgb) {
            *sum = if sample.is_small {
                sum.wrapping_add(i128::from((v * weight * COLOR) as i64))
            } else {
                sum.wrapping_add(Fixed96::from_f64(v * weight).to_i128())
            };
        }
        self.alpha = self.alpha.wrapping_add((sample.alpha * weight * ONE) as i64);
        self.weight = self.weight.wrapping_add(((weight * ONE) as i64).wrapping_mul(2));
    }

    /// Adds a sample with weight 1 if it is finite, otherwise only marks the pixel. Returns whether it is finite.
    #[inline]
    pub(crate) fn add_or_omit(&mut self, color: Spectrum, alpha: f32) -> bool {
        let finite = color.is_finite() && alpha.is_finite();
        if finite {
            self.add(&FixedSample::new(color, alpha), 1.0);
        } else {
            self.omit();
        }
        finite
    }

    /// Marks the pixel: a non-finite sample was not added.
    pub(super) fn omit(&mut self) {
        self.weight |= 1;
    }

    /// The sums as a film holds them.
    pub(super) fn narrow(&self) -> PixelSum {
        PixelSum::new(self.rgb.map(Fixed96::from_i128), self.alpha, self.weight)
    }
}

/// Adds to a sum of a further value.
#[inline]
pub(super) fn add_to(sum: &mut i128, value: f64) {
    let scaled = value * COLOR;
    *sum = if scaled.abs() < 9e18 {
        sum.wrapping_add(i128::from(scaled as i64))
    } else {
        sum.wrapping_add(Fixed96::from_f64(value).to_i128())
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_sums_are_those_of_the_film() {
        let (mut wide, mut narrow) = (WideSum::default(), PixelSum::default());
        for i in 0..400u32 {
            let unit = |k: u32| ((i * k + 17) % 1009) as f32 / 1009.0;
            let scale = [1.0, 1e-7, 8190.0, 8200.0, 3e8, 9e9][i as usize % 6];
            let color = Spectrum::new(scale * unit(7919), -unit(31), scale * unit(104_729));
            let (alpha, weight) = (unit(13), [1.0, 64.0, -0.3, unit(271)][i as usize % 4]);
            wide.add(&FixedSample::new(color, alpha), weight);
            narrow.add_weighted(color, alpha, weight);
            assert_eq!(wide.narrow(), narrow, "{i}");
        }
        assert!(!wide.add_or_omit(Spectrum::grey(f32::NAN), 1.0));
        narrow.omit();
        assert_eq!(wide.narrow(), narrow);
        let (mut sum, mut fixed) = (0i128, Fixed96::default());
        for v in [0.1, -7e-9, 5e5, 6e5, 1e30, -1e30, 3.0] {
            add_to(&mut sum, v);
            fixed = fixed.plus(Fixed96::from_f64(v));
        }
        assert_eq!(Fixed96::from_i128(sum), fixed);
    }
}
