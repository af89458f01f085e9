//! Whether two noisy pictures estimate the same one: by the mean of the picture, of blocks, and of single pixels.
//!
//! The means of the picture and of blocks of pixels are compared by Welch's test, which holds for few runs and
//! unequal variances. Single pixels have distributions that are too skewed for exact p-values. Therefore, as in
//! Mitsuba's tests, their fraction counts: at most a quarter of a percent of them may differ at a level at
//! which hardly one of the entire picture would by chance alone. Their variances are pooled over neighbours.

use super::moments::{Moments, difference};
use super::runs::Estimate;
use super::tails::{sidak_level, smallest_of};
use crate::film::PixelRect;

/// Options of [`compare`].
#[derive(Clone, Copy, Debug)]
pub struct CompareOptions {
    /// Edge of the blocks in pixels.
    pub block: u32,
    /// Relative difference that is ignored, as a fraction of the larger value: for rounding, or for physics
    /// that is known to differ.
    pub tolerance: f64,
    /// Absolute difference that is ignored.
    pub absolute: f64,
    /// Largest fraction of pixels that may differ.
    pub share: f64,
}

impl Default for CompareOptions {
    fn default() -> CompareOptions {
        // Sums of colours have single precision.
        CompareOptions { block: 8, tolerance: 2e-6, absolute: 1e-12, share: 0.0025 }
    }
}

/// The pixels that differ most, in one colour channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// The rectangle.
    pub pixels: PixelRect,
    /// 0 red, 1 green, 2 blue.
    pub band: usize,
    /// In the first picture.
    pub a: Moments,
    /// In the second.
    pub b: Moments,
    /// The difference in standard errors.
    pub t: f64,
}

/// The result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean of the first picture divided by that of the second, over all channels; 1 if both are black.
    pub ratio: f64,
    /// The standard error of the ratio, which is the resolution of the test.
    pub ratio_error: f64,
    /// The p-value of the means: the smallest of three channels, corrected for their number.
    pub p_mean: f64,
    /// The p-value of the blocks: the smallest of all blocks and channels, corrected for their number.
    pub p_blocks: f64,
    /// Fraction of pixels with a channel that differs significantly.
    pub beyond: f64,
    /// Whether that fraction is too large.
    pub too_many: bool,
    /// The p-value of means and blocks together; 0 if too many pixels differ.
    pub p_value: f64,
    /// The block that differs most.
    pub worst: Option<Worst>,
}

/// Compares two pictures. The p-value is 0 if their sizes differ.
pub fn compare(a: &dyn Estimate, b: &dyn Estimate, options: &CompareOptions) -> Comparison {
    let (width, height) = a.size();
    let mut out = Comparison {
        ratio: f64::NAN,
        ratio_error: f64::INFINITY,
        p_mean: 0.0,
        p_blocks: 0.0,
        beyond: 1.0,
        too_many: true,
        p_value: 0.0,
        worst: None,
    };
    if (width, height) != b.size() || width == 0 || height == 0 {
        return out;
    }
    let test = |ma: &Moments, mb: &Moments| {
        difference(ma, mb, options.tolerance * ma.mean.abs().max(mb.mean.abs()) + options.absolute)
    };
    let whole = PixelRect { x: 0, y: 0, width, height };
    let means = [0, 1, 2].map(|band| (a.moments(&whole, band), b.moments(&whole, band)));
    out.p_mean = smallest_of(means.iter().map(|(ma, mb)| test(ma, mb).1).fold(1.0, f64::min), 3);
    (out.ratio, out.ratio_error) = ratio(&means);

    let (mut least, mut tests) = (1.0f64, 0);
    for y in (0..height).step_by(options.block.max(1) as usize) {
        for x in (0..width).step_by(options.block.max(1) as usize) {
            let (w, h) = (options.block.min(width - x), options.block.min(height - y));
            let pixels = PixelRect { x, y, width: w, height: h };
            for band in 0..3 {
                let (ma, mb) = (a.moments(&pixels, band), b.moments(&pixels, band));
                let (t, p) = test(&ma, &mb);
                tests += 1;
                least = least.min(p);
                if out.worst.is_none_or(|w| t > w.t) {
                    out.worst = Some(Worst { pixels, band, a: ma, b: mb, t });
                }
            }
        }
    }
    out.p_blocks = smallest_of(least, tests);
    out.beyond = share_beyond(a, b, options);
    out.too_many = out.beyond > options.share;
    out.p_value = if out.too_many { 0.0 } else { smallest_of(out.p_mean.min(out.p_blocks), 2) };
    out
}

fn ratio(means: &[(Moments, Moments); 3]) -> (f64, f64) {
    let sum = |f: &dyn Fn(&(Moments, Moments)) -> f64| means.iter().map(f).sum::<f64>();
    let (a, b) = (sum(&|m| m.0.mean), sum(&|m| m.1.mean));
    if b == 0.0 {
        return (if a == 0.0 { 1.0 } else { f64::INFINITY }, 0.0);
    }
    // Bands go up and down together: their errors add up, not the squares.
    let (ea, eb) = (sum(&|m| m.0.error()), sum(&|m| m.1.error()));
    (a / b, (ea * ea + eb * eb * (a / b) * (a / b)).sqrt() / b.abs())
}

fn share_beyond(a: &dyn Estimate, b: &dyn Estimate, options: &CompareOptions) -> f64 {
    let (width, height) = a.size();
    let n = width as usize * height as usize;
    let level = sidak_level(0.01, 3 * n);
    let mut bad = vec![false; n];
    for band in 0..3 {
        let all = |e: &dyn Estimate| -> Vec<Moments> {
            (0..n as u32)
                .map(|i| e.moments(&PixelRect { x: i % width, y: i / width, width: 1, height: 1 }, band))
                .collect()
        };
        let (mut ma, mut mb) = (all(a), all(b));
        pool(&mut ma, width, height);
        pool(&mut mb, width, height);
        for ((bad, ma), mb) in bad.iter_mut().zip(&ma).zip(&mb) {
            let tolerance = options.tolerance * ma.mean.abs().max(mb.mean.abs()) + options.absolute;
            *bad |= difference(ma, mb, tolerance).1 < level;
        }
    }
    bad.iter().filter(|b| **b).count() as f64 / n as f64
}

/// A variance from a few runs is itself noisy: the mean of the neighbourhood takes its place where it is larger.
fn pool(pixels: &mut [Moments], width: u32, height: u32) {
    let variances: Vec<f64> = pixels.iter().map(|m| m.variance).collect();
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut n) = (0.0, 0.0);
            for ny in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                for nx in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                    sum += variances[(ny * width + nx) as usize];
                    n += 1.0;
                }
            }
            let m = &mut pixels[(y * width + x) as usize];
            m.variance = m.variance.max(sum / n);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Random, Reference, Runs};
    use super::*;

    /// Pictures of a ramp with noise, some of it rare and bright.
    fn runs(seed: u64, count: usize, change: impl Fn(u32, u32) -> f64) -> Runs {
        let mut random = Random::new(seed);
        let picture = |_| {
            (0..32 * 24u32)
                .map(|i| {
                    let (x, y) = (i % 32, i / 32);
                    let mut sum = 0.0;
                    for _ in 0..64 {
                        let bright = if random.unit() < 0.05 { 20.0 } else { 0.0 };
                        sum += (random.unit() * 2.0 + bright) * change(x, y) * (1.0 + f64::from(x) / 32.0);
                    }
                    [1.0, 0.5, 0.25].map(|c| (sum / 64.0 * c) as f32)
                })
                .collect()
        };
        let pictures = (0..count).map(picture).collect();
        Runs { width: 32, height: 24, pictures, alpha: 1.0, non_finite: Default::default() }
    }

    #[test]
    fn pictures_of_one_thing_agree_and_others_do_not() {
        let options = CompareOptions::default();
        let a = runs(1, 12, |_, _| 1.0);
        let same = compare(&a, &runs(2, 8, |_, _| 1.0), &options);
        assert!(same.p_value > 0.01 && same.beyond == 0.0, "{same:?}");
        assert!((same.ratio - 1.0).abs() < 3.0 * same.ratio_error && same.ratio_error < 0.01, "{same:?}");
        let brighter = compare(&a, &runs(3, 8, |_, _| 1.06), &options);
        assert!(brighter.p_mean < 1e-4, "{brighter:?}");
        // A spot that the mean does not show.
        let spot = |x, y| if (8..16).contains(&x) && (8..16).contains(&y) { 1.3 } else { 0.97 };
        let spot = compare(&a, &runs(4, 8, spot), &options);
        assert!(spot.p_blocks < 1e-4 && spot.p_blocks < spot.p_mean, "{spot:?}");
        assert_eq!(spot.worst.map(|w| (w.pixels.x, w.pixels.y)), Some((8, 8)));
        // Single pixels.
        let dots = |x, y| if x % 8 == 3 && y % 6 == 2 { 5.0 } else { 1.0 };
        let dots = compare(&a, &runs(5, 8, dots), &options);
        assert!(dots.too_many && dots.p_value == 0.0, "{dots:?}");
    }

    #[test]
    fn against_a_formula() {
        let a = runs(6, 12, |_, _| 1.0);
        let mean = (0..32 * 24).map(|i| [2.0, 1.0, 0.5].map(|c| c * (1.0 + f64::from(i % 32) / 32.0)));
        let exact =
            Reference { width: 32, height: 24, mean: mean.collect(), variance: vec![[0.0; 3]; 32 * 24] };
        let right = compare(&a, &exact, &CompareOptions::default());
        assert!(right.p_value > 0.01, "{right:?}");
        let wrong = compare(&a, &Reference::constant(32, 24, [3.0, 1.5, 0.75]), &CompareOptions::default());
        assert_eq!(wrong.p_value, 0.0);
        assert_eq!(compare(&a, &Reference::constant(24, 32, [0.0; 3]), &Default::default()).p_value, 0.0);
        // Blocks have the mean of their pixels, and a quarter of the variance.
        let small = Reference::with_noise(32, 24, exact.mean, 0.04).reduced(2);
        assert_eq!((small.width, small.height, small.mean.len()), (16, 12, 192));
        assert!((small.mean[0][0] - 2.03125).abs() < 1e-12 && small.variance[0][0] < 0.0103 * 4.2);
    }
}
