//! The exposures of HDR-FLIP: section 3 of the paper of 2021.

use super::super::Pair;
use crate::math::elementary::ln;

/// The tone mapping (k₀x² + k₁x + k₂) / (k₃x² + k₄x + k₅), which K. Narkowicz fitted to ACES, with light scaled
/// by 0.6.
const K: [f64; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

/// The tone-mapped value of the largest luminance at the first exposure and of the median at the last.
const TARGET: f64 = 0.85;

/// Smallest luminance, 2⁻²³: it bounds the number of exposures.
const DARKEST: f64 = f32::EPSILON as f64;

/// Tone-mapped light, before it is clamped to 0..=1.
pub(super) fn tone_mapped(x: f64) -> f64 {
    if x > 1e150 {
        return K[0] / K[3];
    }
    ((K[0] * x + K[1]) * x + K[2]) / ((K[3] * x + K[4]) * x + K[5])
}

/// The light that is mapped to [`TARGET`]: the larger root of a quadratic.
fn light_of_target() -> f64 {
    let (a, b, c) = (K[0] - TARGET * K[3], K[1] - TARGET * K[4], K[2] - TARGET * K[5]);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// Exposures in stops, evenly spaced: from the one that maps the reference's brightest pixel to 0.85 to the one
/// that maps its median to 0.85; at most one stop apart, and at least two. A black reference has the single
/// exposure 0.
pub fn exposures(pair: &Pair) -> Vec<f64> {
    let background = pair.backgrounds()[0];
    let luminance = |i: usize| {
        let [r, g, b] = pair.on(0, i, background).map(|v| f64::from(v.max(0.0)));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let mut all: Vec<f64> = (0..pair.width as usize * pair.height as usize).map(luminance).collect();
    let most = all.iter().copied().fold(0.0, f64::max);
    if most <= 0.0 {
        return vec![0.0];
    }
    let middle = all.len() / 2;
    let median = *all.select_nth_unstable_by(middle, f64::total_cmp).1;
    let stops = |luminance: f64| ln(light_of_target() / luminance.max(DARKEST)) * std::f64::consts::LOG2_E;
    let (first, last) = (stops(most), stops(median));
    let count = (last - first).ceil().max(2.0) as usize;
    let step = (last - first) / (count - 1) as f64;
    if step <= 0.0 {
        return vec![first];
    }
    (0..count).map(|i| first + step * i as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::testing::pair;
    use super::*;

    #[test]
    fn the_target_is_met() {
        assert!((tone_mapped(light_of_target()) - TARGET).abs() < 1e-12);
        assert!((tone_mapped(f64::MAX) - tone_mapped(1e100)).abs() < 1e-12);
    }

    #[test]
    fn from_the_brightest_to_the_median() {
        let light = |x: u32, _: u32| [if x == 0 { 32.0 } else { 1.0 }; 3];
        let stops = exposures(&pair(5, 3, true, light, light));
        let last = ln(light_of_target()) * std::f64::consts::LOG2_E;
        assert_eq!(stops.len(), 5);
        assert!((stops[0] - (last - 5.0)).abs() < 1e-9 && (stops[4] - last).abs() < 1e-9, "{stops:?}");
        assert_eq!(exposures(&pair(2, 2, true, |_, _| [0.0; 3], light)), [0.0]);
        assert_eq!(exposures(&pair(2, 2, true, |_, _| [3.0; 3], light)).len(), 1);
        // Mostly black: down to 2⁻²³ and no further.
        let spark = |x: u32, _: u32| [if x == 0 { 1.0 } else { 0.0 }; 3];
        assert_eq!(exposures(&pair(9, 3, true, spark, spark)).len(), 23);
    }
}
