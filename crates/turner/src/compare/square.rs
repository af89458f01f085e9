//! Mean square differences.

use super::{Measured, Pair, absolute};
use crate::math::elementary::ln;

/// √(mean((a − b)²)) of the stored values, over pixels and channels: colours times alpha, and alpha if there is any.
pub fn rmse(pair: &Pair) -> Measured {
    let n = pair.channels();
    let square = |(p, q): (&[f32; 4], &[f32; 4])| (0..n).map(|c| squared(p[c], q[c])).sum::<f64>();
    let count = n * pair.width as usize * pair.height as usize;
    let mean = pair.both().map(square).sum::<f64>() / count.max(1) as f64;
    Measured::new(pair, mean.sqrt(), absolute::map(pair))
}

/// −10·log₁₀(mean((a − b)²)) in decibels, of display values from 0 to 1: about 50 for hardly visible
/// differences, 30 for clearly visible ones; infinite for equal images. Transparent images are compared on
/// black and on white.
pub fn psnr(pair: &Pair) -> Measured {
    let pixels = pair.width as usize * pair.height as usize;
    let (mut sum, mut map) = (0.0, vec![0.0f32; pixels]);
    for &background in pair.backgrounds() {
        for (i, most) in map.iter_mut().enumerate() {
            let (p, q) = (pair.shown(0, i, background), pair.shown(1, i, background));
            for (a, b) in p.into_iter().zip(q) {
                sum += squared(a, b);
                *most = most.max((a - b).abs());
            }
        }
    }
    let mean = sum / (3 * pixels * pair.backgrounds().len()).max(1) as f64;
    let value = if mean > 0.0 { -10.0 * ln(mean) / std::f64::consts::LN_10 } else { f64::INFINITY };
    Measured::new(pair, value, map)
}

fn squared(a: f32, b: f32) -> f64 {
    let d = f64::from(a) - f64::from(b);
    d * d
}

#[cfg(test)]
mod tests {
    use super::super::testing::{canvas, pair};
    use super::super::{Canvas, Pair};
    use super::*;

    #[test]
    fn roots_of_mean_squares() {
        let pair = pair(2, 2, true, |_, _| [3.0; 3], |x, _| [3.0 + x as f32, 3.0, 3.0]);
        // Two of twelve values are off by one.
        assert!((rmse(&pair).value - (2.0f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!(rmse(&pair).worst.x, 1);
    }

    #[test]
    fn decibels() {
        let off = pair(4, 4, false, |_, _| [0.25; 3], |_, _| [0.375; 3]);
        // A square of 1/64.
        assert!((psnr(&off).value - 18.061_799_739_838_87).abs() < 1e-9);
        let equal = pair(4, 4, false, |_, _| [0.25; 3], |_, _| [0.25; 3]);
        assert_eq!(psnr(&equal).value, f64::INFINITY);
        // Linear light is compared as displayed: 0.25 becomes 0.537, 0.375 becomes 0.6461; values above 1 are equal.
        let light = pair(4, 4, true, |_, _| [0.25; 3], |_, _| [0.375; 3]);
        assert!((psnr(&light).value - 19.25).abs() < 0.05, "{}", psnr(&light).value);
        let bright = pair(4, 4, true, |_, _| [1.5; 3], |_, _| [7.0; 3]);
        assert_eq!(psnr(&bright).value, f64::INFINITY);
    }

    #[test]
    fn transparency_is_seen_on_black_and_on_white() {
        // White with two coverages: equal on white, different by a quarter on black.
        let half = |a: f32| {
            let c = canvas(1, 1, |_, _| [a; 3]);
            Canvas { pixels: vec![[a; 4]], has_alpha: true, ..c }
        };
        let pair = Pair::new(half(0.5), half(0.75)).unwrap();
        let mean = 0.25f64 * 0.25 / 2.0;
        assert!((psnr(&pair).value + 10.0 * ln(mean) / std::f64::consts::LN_10).abs() < 1e-6);
        assert_eq!(rmse(&pair).value, 0.25);
    }
}
