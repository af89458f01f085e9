//! The sums of one pixel.

use super::Fixed96;
use super::fixed::{ONE, round};
use crate::color::Spectrum;

/// Sums of weighted values and of weights for one pixel. They are integers, so the order of samples does not
/// matter. 52 bytes on the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelSum {
    /// Weight times colour times coverage.
    rgb: [Fixed96; 3],
    /// Weight times coverage, in units of 2^-32.
    alpha: i64,
    /// Twice the weight, in units of 2^-32. The lowest bit is set if a non-finite sample was not added. Weights
    /// add up to at most 2^30: 2^24 samples of weights up to 64.
    weight: i64,
}

impl PixelSum {
    /// Size on the film in bytes.
    pub const BYTES: usize = 52;

    /// Size on the film in 32-bit words.
    pub(super) const WORDS: usize = PixelSum::BYTES / 4;

    /// A pixel of these sums: weight times colour times coverage; weight times coverage; twice the weight, and the mark
    /// of a sample that was not added.
    pub(super) fn new(rgb: [Fixed96; 3], alpha: i64, weight: i64) -> PixelSum {
        PixelSum { rgb, alpha, weight }
    }

    pub(super) fn to_words(self) -> [u32; PixelSum::WORDS] {
        let [r, g, b] = self.rgb.map(Fixed96::to_words);
        let [a, w] = [self.alpha, self.weight].map(|v| [v as u32, (v >> 32) as u32]);
        [r[0], r[1], r[2], g[0], g[1], g[2], b[0], b[1], b[2], a[0], a[1], w[0], w[1]]
    }

    pub(super) fn from_words(w: &[u32; PixelSum::WORDS]) -> PixelSum {
        let long = |low: u32, high: u32| (u64::from(high) << 32 | u64::from(low)) as i64;
        PixelSum {
            rgb: [[w[0], w[1], w[2]], [w[3], w[4], w[5]], [w[6], w[7], w[8]]].map(Fixed96::from_words),
            alpha: long(w[9], w[10]),
            weight: long(w[11], w[12]),
        }
    }

    /// Adds the sums of another pixel to the words of this one: red, green and blue in units of 2^-44, coverage and weight
    /// in units of 2^-32. `omitted` marks a sample that was not finite.
    #[inline(always)]
    pub(super) fn add_to_words(
        words: &mut [u32; PixelSum::WORDS],
        [r, g, b, alpha, weight]: [i64; 5],
        omitted: bool,
    ) {
        let (colors, rest) = words.split_at_mut(9);
        for (words, v) in colors.as_chunks_mut::<3>().0.iter_mut().zip([r, g, b]) {
            Fixed96::add_to_words(words, v);
        }
        let doubled = weight.wrapping_mul(2);
        for (words, v) in rest.as_chunks_mut::<2>().0.iter_mut().zip([alpha, doubled]) {
            let sum = (u64::from(words[1]) << 32 | u64::from(words[0])).wrapping_add(v as u64);
            *words = [sum as u32, (sum >> 32) as u32];
        }
        // Where the lowest bit of the weight is.
        rest[2] |= u32::from(omitted);
    }

    /// Adds a finite sample with weight 1: colour times coverage, and coverage 0..=1.
    #[inline]
    pub fn add(&mut self, color: Spectrum, alpha: f32) {
        for (sum, v) in self.rgb.iter_mut().zip(color.to_array()) {
            *sum = sum.plus(Fixed96::from_f32(v));
        }
        self.alpha = self.alpha.wrapping_add(round(f64::from(alpha) * ONE) as i64);
        self.weight = self.weight.wrapping_add(2 * ONE as i64);
    }

    /// Adds a finite sample with a weight of -64..=64.
    #[inline]
    pub fn add_weighted(&mut self, color: Spectrum, alpha: f32, weight: f32) {
        let weight = f64::from(weight);
        for (sum, v) in self.rgb.iter_mut().zip(color.to_array()) {
            *sum = sum.plus(Fixed96::from_f64(f64::from(v) * weight));
        }
        self.alpha = self.alpha.wrapping_add(round(f64::from(alpha) * ONE * weight) as i64);
        self.weight = self.weight.wrapping_add((round(ONE * weight) as i64).wrapping_mul(2));
    }

    /// Adds a sample with weight 1 if it is finite, otherwise only marks the pixel. Returns whether it is finite.
    #[inline]
    pub fn add_or_omit(&mut self, color: Spectrum, alpha: f32) -> bool {
        let finite = color.is_finite() && alpha.is_finite();
        if finite {
            self.add(color, alpha);
        } else {
            self.omit();
        }
        finite
    }

    /// Adds the samples of another sum.
    #[inline]
    pub fn merge(&mut self, other: &PixelSum) {
        for (a, b) in self.rgb.iter_mut().zip(&other.rgb) {
            *a = a.plus(*b);
        }
        self.alpha = self.alpha.wrapping_add(other.alpha);
        let left_out = (self.weight | other.weight) & 1;
        self.weight = (self.weight & !1).wrapping_add(other.weight & !1) | left_out;
    }

    /// Marks the pixel: a non-finite sample was not added.
    pub fn omit(&mut self) {
        self.weight |= 1;
    }

    /// Weighted mean of colour times coverage, and of coverage; NaN if no sample was finite, `None` without
    /// samples.
    pub fn mean(&self) -> Option<[f32; 4]> {
        let weight = self.weight();
        if weight == 0.0 {
            return (self.weight & 1 == 1).then_some([f32::NAN, f32::NAN, f32::NAN, 1.0]);
        }
        let [r, g, b] = self.rgb.map(|c| c.mean(weight) as f32);
        Some([r, g, b, (self.alpha as f64 / (ONE * weight)) as f32])
    }

    /// The sum of weights: the number of finite samples if each has weight 1.
    pub fn weight(&self) -> f64 {
        (self.weight >> 1) as f64 / ONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (colour, alpha, weight) of some samples; weights have both signs.
    fn samples() -> Vec<(Spectrum, f32, f32)> {
        let unit = |i: u32, k: u32| ((i * k + 17) % 1009) as f32 / 1009.0;
        (0..500)
            .map(|i| {
                let color = Spectrum::new(9.0 * unit(i, 7919), unit(i, 104_729), -unit(i, 31));
                (color, unit(i, 13), 1.3 * unit(i, 271) - 0.2)
            })
            .collect()
    }

    #[test]
    fn weighted_sums_have_the_same_bits_in_any_order_and_the_right_mean() {
        let all = samples();
        let sum = |order: &mut dyn Iterator<Item = usize>| {
            order.fold(PixelSum::default(), |mut sum, i| {
                sum.add_weighted(all[i].0, all[i].1, all[i].2);
                sum
            })
        };
        let forward = sum(&mut (0..500));
        assert_eq!(forward, sum(&mut (0..500).rev()));
        assert_eq!(forward, sum(&mut (0..500).map(|i| i * 209 % 500)));
        let mut halves = sum(&mut (0..123));
        halves.merge(&sum(&mut (123..500)));
        assert_eq!(forward, halves);
        assert_eq!(PixelSum::from_words(&forward.to_words()), forward);

        let total: f64 = all.iter().map(|s| f64::from(s.2)).sum();
        assert!((forward.weight() - total).abs() < 1e-6);
        let mean = forward.mean().unwrap();
        for (channel, shown) in mean.into_iter().enumerate() {
            let value = |s: &(Spectrum, f32, f32)| if channel < 3 { s.0.to_array()[channel] } else { s.1 };
            let exact = all.iter().map(|s| f64::from(value(s)) * f64::from(s.2)).sum::<f64>() / total;
            assert!((f64::from(shown) - exact).abs() < 1e-6, "{channel}: {shown} {exact}");
        }
    }

    #[test]
    fn weight_one_equals_no_weight() {
        let (mut plain, mut weighted) = (PixelSum::default(), PixelSum::default());
        for (color, alpha, _) in samples() {
            plain.add(color, alpha);
            weighted.add_weighted(color, alpha, 1.0);
        }
        assert_eq!(plain, weighted);
        assert_eq!(plain.weight(), 500.0);
    }

    #[test]
    fn non_finite_samples_show_only_in_pixels_without_finite_ones() {
        let (mut bad, mut good) = (PixelSum::default(), PixelSum::default());
        assert_eq!(bad.mean(), None);
        assert!(!bad.add_or_omit(Spectrum::new(0.0, f32::NAN, 0.0), 1.0));
        assert!(bad.mean().unwrap()[0].is_nan());
        good.add(Spectrum::WHITE, 0.5);
        let mut both = bad;
        both.merge(&good);
        both.merge(&bad);
        assert_eq!((both.mean(), both.weight()), (good.mean(), 1.0));
    }
}
