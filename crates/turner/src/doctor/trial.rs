//! The same pixels with a setting changed, to see whether that setting is the cause.

use super::grid::Pixel;
use super::subject::Subject;
use super::{Options, threads};
use crate::render::sample;

/// The light before and after a change.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Trial {
    /// All light after over before; infinite where there was none.
    pub(super) ratio: f64,
    /// The fraction of pixels that get brighter by more than a quarter.
    pub(super) brighter: f64,
}

/// The mean luminance of a few samples of each pixel; NaN where a sample is.
pub(super) fn light(scene: &Subject, pixels: &[Pixel], samples: u32, options: &Options<'_>) -> Vec<f64> {
    let of = |pixel: &Pixel| {
        let one = |i| {
            sample(&scene.prepared, pixel.x, pixel.y, i).map_or(f64::NAN, |r| f64::from(r.color.luminance()))
        };
        (0..samples).map(one).sum::<f64>() / f64::from(samples.max(1))
    };
    let light = threads::map(pixels, options.threads, &|| false, of);
    light.into_iter().map(|l| l.unwrap_or(f64::NAN)).collect()
}

/// Compares the light of pixels before and after a change.
pub(super) fn compare(before: &[f64], after: &[f64]) -> Trial {
    let sound = || before.iter().zip(after).filter(|(a, b)| a.is_finite() && b.is_finite());
    let (sum_before, sum_after) = sound().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let n = sound().count().max(1) as f64;
    let least = 1e-3 * sum_after / n;
    let brighter = sound().filter(|(a, b)| **b > 1.25 * **a + least).count() as f64 / n;
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
