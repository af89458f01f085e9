//! Structural similarity: Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error Visibility
//! to Structural Similarity", IEEE Transactions on Image Processing 13 (4), 2004, equation 13.
//!
//! SSIM compares neighbourhoods instead of single pixels. Two windows are similar if their means (luminance),
//! their variances (contrast) and their correlation (structure) agree. Noise lowers it even where the mean is
//! right, while a small change of brightness hardly matters.
//!
//! With μ, σ² and σ_ab the means, variances and covariance under a Gaussian window of 11 x 11 pixels with a
//! standard deviation of 1.5,
//!
//! ```text
//! SSIM = (2 μ_a μ_b + C₁)(2 σ_ab + C₂) / ((μ_a² + μ_b² + C₁)(σ_a² + σ_b² + C₂)),   C₁ = 0.01², C₂ = 0.03²
//! ```
//!
//! of display values from 0 to 1. A pixel has the mean over red, green and blue. The image has the mean over
//! all pixels whose window lies inside it, or over all pixels if a side has fewer than 11. Beyond its edges the
//! image is mirrored. Transparent images are compared on black and on white, and the lower value counts. The
//! constants C₁ and C₂ avoid a division by zero in dark or flat windows. All means under the window are
//! separable convolutions, so that a pixel costs 22 products per mean.

use super::kernel::{Border, Kernel, Plane};
use super::{Measured, Pair, strips};
use crate::math::elementary::exp;

const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean structural similarity of a pair; the map holds 1 − SSIM.
pub fn ssim(pair: &Pair, threads: usize) -> Measured {
    let size @ (width, height) = (pair.width as usize, pair.height as usize);
    let window = Kernel::new(RADIUS, |i| exp(-i * i / (2.0 * SIGMA * SIGMA))).normalised();
    let map = strips::map((pair.width, pair.height), threads, |first, out| {
        let rows = first..first + out.len() / width.max(1);
        for &background in pair.backgrounds() {
            let mut of_strip = vec![0.0; out.len()];
            for band in 0..3 {
                let plane = |picture: usize| {
                    Plane::new(size, rows.clone(), RADIUS, Border::Mirror, |x, y| {
                        f64::from(pair.shown(picture, y * width + x, background)[band])
                    })
                };
                add(&plane(0), &plane(1), &window, &mut of_strip);
            }
            out.iter_mut().zip(&of_strip).for_each(|(o, s)| *o = o.max((1.0 - s / 3.0) as f32));
        }
    });
    let inner = |side: usize| if side > 2 * RADIUS { RADIUS..side - RADIUS } else { 0..side };
    let (rows, columns) = if width > 2 * RADIUS && height > 2 * RADIUS {
        (inner(height), inner(width))
    } else {
        (0..height, 0..width)
    };
    let count = rows.len() * columns.len();
    let lines = rows.filter_map(|y| map.get(y * width + columns.start..y * width + columns.end));
    let sum: f64 = lines.flatten().map(|v| f64::from(*v)).sum();
    Measured::new(pair, 1.0 - sum / count.max(1) as f64, map)
}

/// Adds the similarity of one colour channel in a strip.
fn add(a: &Plane, b: &Plane, window: &Kernel, out: &mut [f64]) {
    let mean = |p: &Plane| p.along_x(window, Border::Mirror).along_y(window, RADIUS).values;
    let product = |p: &Plane, q: &Plane| Plane {
        width: p.width,
        values: p.values.iter().zip(&q.values).map(|(v, w)| v * w).collect(),
    };
    let (ma, mb) = (mean(a), mean(b));
    let (aa, bb, ab) = (mean(&product(a, a)), mean(&product(b, b)), mean(&product(a, b)));
    for (i, out) in out.iter_mut().enumerate() {
        let (ma, mb) = (ma[i], mb[i]);
        let (va, vb, vab) = (aa[i] - ma * ma, bb[i] - mb * mb, ab[i] - ma * mb);
        let above = (2.0 * ma * mb + C1) * (2.0 * vab + C2);
        *out += above / ((ma * ma + mb * mb + C1) * (va + vb + C2));
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::pair;
    use super::*;

    #[test]
    fn equal_pictures_are_alike_and_negatives_are_not() {
        let batch = |x: u32, y: u32| [((x * 5 + y * 3) % 7) as f32 / 6.0; 3];
        let same = pair(20, 16, false, batch, batch);
        assert!((ssim(&same, 1).value - 1.0).abs() < 1e-12);
        let negative = pair(20, 16, false, batch, |x, y| batch(x, y).map(|v| 1.0 - v));
        assert!(ssim(&negative, 2).value < -0.5);
    }

    /// Without structure only the means remain: (2 a b + C₁) / (a² + b² + C₁).
    #[test]
    fn flat_pictures_by_formula() {
        for (w, h) in [(12, 12), (3, 200), (1, 1)] {
            let flat = pair(w, h, false, |_, _| [0.25; 3], |_, _| [0.75; 3]);
            let expected = (2.0 * 0.1875 + C1) / (0.0625 + 0.5625 + C1);
            assert!((ssim(&flat, 3).value - expected).abs() < 1e-7);
        }
    }

    #[test]
    fn threads_change_nothing() {
        let a = |x: u32, y: u32| [((x * 31 + y * 17) % 23) as f32 / 22.0; 3];
        let b = |x: u32, y: u32| [((x * 29 + y * 17) % 19) as f32 / 18.0; 3];
        let pair = pair(13, 200, false, a, b);
        assert_eq!(ssim(&pair, 1), ssim(&pair, 4));
    }
}
