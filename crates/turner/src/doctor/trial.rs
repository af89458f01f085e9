//! Trials: the effect of a setting on the picture, measured by tracing the same pixels with the setting changed.
//!
//! A setting such as a depth limit or a clamp removes an amount of light that depends on the scene, so it cannot be
//! judged by its value. A trial traces a few samples per pixel before and after a change. Sample i of a pixel has the
//! same random numbers both times, so the two paths agree up to where the setting takes effect, and most of their noise
//! cancels in the comparison. Two numbers summarise it, over all pixels that are finite both times:
//!
//! - `ratio`: Σ after / Σ before, the gain in light. A few bright pixels may dominate it.
//! - `brighter`: the fraction of pixels that gain more than a quarter (plus 0.1 % of the mean, so that noise in black
//!   pixels does not count), the extent of the effect in the picture.

use super::grid::Pixel;
use super::subject::Subject;
use super::{Options, threads};
use crate::render::sample;

/// The light before and after a change.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Trial {
    /// The sum of the luminance after the change over that before; infinite if it was 0 before, 1 if it is 0 after.
    pub(super) ratio: f64,
    /// The fraction of pixels that gain more than a quarter.
    pub(super) brighter: f64,
}

/// The mean luminance of `samples` samples of each pixel; NaN if one of them is.
pub(super) fn mean_luminances(
    scene: &Subject,
    pixels: &[Pixel],
    samples: u32,
    options: &Options<'_>,
) -> Vec<f64> {
    let of = |pixel: &Pixel| {
        let one = |i| {
            sample(&scene.prepared, pixel.x, pixel.y, i).map_or(f64::NAN, |r| f64::from(r.color.luminance()))
        };
        (0..samples).map(one).sum::<f64>() / f64::from(samples.max(1))
    };
    let light = threads::map(pixels, options.threads, &|| false, of);
    light.into_iter().map(|l| l.unwrap_or(f64::NAN)).collect()
}

/// Compares the mean luminances of pixels before and after a change.
pub(super) fn compare(before: &[f64], after: &[f64]) -> Trial {
    let finite = || before.iter().zip(after).filter(|(a, b)| a.is_finite() && b.is_finite());
    let (sum_before, sum_after) = finite().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let n = finite().count().max(1) as f64;
    let least = 1e-3 * sum_after / n;
    let brighter = finite().filter(|(a, b)| **b > 1.25 * **a + least).count() as f64 / n;
    let ratio = if sum_after <= 0.0 { 1.0 } else { sum_after / sum_before };
    Trial { ratio, brighter }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_compares_finite_pixels() {
        let t = compare(&[1.0, 0.0, f64::NAN, 2.0], &[1.0, 1.0, 5.0, 4.0]);
        assert_eq!(t.ratio, 2.0);
        assert!((t.brighter - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!(compare(&[0.0], &[0.0]).ratio, 1.0);
        assert_eq!(compare(&[0.0], &[1.0]).ratio, f64::INFINITY);
    }
}
