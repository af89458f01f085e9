//! The fit of a window: light = a + b · (x, y, albedo, normal, distance), by weighted least squares.
//!
//! The sums of a fit are of products of two of its terms, and of terms and light. Each pixel has a row of them, so that the
//! sums of a window are weighted sums of rows.

use super::light::luminance;
use super::{GUIDES, Rgb};

/// Terms: 1, x, y and the guides.
pub(super) const TERMS: usize = 3 + GUIDES;

/// Products of two terms.
pub(super) const PAIRS: usize = TERMS * (TERMS + 1) / 2;

/// Where a row has the variance of the light.
pub(super) const VARIANCE: usize = PAIRS + 3 * TERMS;

/// Length of a row: products, terms times light and the variance of the light, filled up to whole vectors.
pub(super) const ROW: usize = (VARIANCE + 1).next_multiple_of(16);

/// Added to the variance of each term, so that terms that hardly change in the window are left out.
const RIDGE: f64 = 1e-4;

/// Added likewise: this part of the variance of the mean of the window, relative to the square of the mean. Where there is
/// much noise, slopes need more evidence.
const DOUBT: f64 = 0.3;

/// Less than this is left of the variance of a term by rounding alone.
const LEAST: f64 = 0.1 * RIDGE;

/// A row of products.
pub(super) type Row = [f32; ROW];

/// Coefficients of the terms for red, green and blue.
pub(super) type Coefficients = [[f32; TERMS]; 3];

/// The products of a pixel.
#[inline(always)]
pub(super) fn fill(row: &mut Row, terms: &[f32; TERMS], light: &Rgb, variance: f32) {
    let mut k = 0;
    for (i, a) in terms.iter().enumerate() {
        for b in &terms[i..] {
            row[k] = a * b;
            k += 1;
        }
    }
    for term in terms {
        for v in light {
            row[k] = term * v;
            k += 1;
        }
    }
    row[VARIANCE] = variance;
}

/// The coefficients from the weighted sums of a window, whose first is the sum of weights. Sums are single precision; the
/// solution is double.
#[inline(always)]
pub(super) fn solve(sums: &Row) -> Coefficients {
    const N: usize = TERMS - 1;
    let scale = 1.0 / f64::from(sums[0]);
    let at = |k: usize| f64::from(sums[k]) * scale;
    // The product of terms i and j, i <= j, has this index.
    let pair = |i: usize, j: usize| i * TERMS - i * (i + 1) / 2 + j;
    let mean: [f64; TERMS] = std::array::from_fn(at);
    let light: [f64; 3] = std::array::from_fn(|c| at(PAIRS + c));
    let bright = luminance(&light.map(|v| v as f32));
    let noise = at(VARIANCE) / f64::from(bright * bright + 1e-8);
    let ridge = RIDGE + DOUBT * noise * scale;
    let (mut a, mut b) = ([[0.0f64; N]; N], [[0.0f64; 3]; N]);
    for i in 0..N {
        for j in i..N {
            a[j][i] = at(pair(i + 1, j + 1)) - mean[i + 1] * mean[j + 1];
        }
        a[i][i] = a[i][i].max(0.0) + ridge;
        for c in 0..3 {
            b[i][c] = at(PAIRS + 3 * (i + 1) + c) - mean[i + 1] * light[c];
        }
    }
    // Cholesky: a = L · Lᵀ, column by column. The diagonal holds the inverse of L's.
    for k in 0..N {
        // A term that the others explain, but for rounding, is left out.
        let inverse = if a[k][k] > LEAST { 1.0 / a[k][k].sqrt() } else { 0.0 };
        a[k][k] = inverse;
        for i in k + 1..N {
            a[i][k] *= inverse;
        }
        for i in k + 1..N {
            for j in k + 1..=i {
                a[i][j] -= a[i][k] * a[j][k];
            }
        }
        for c in 0..3 {
            b[k][c] *= inverse;
        }
        for i in k + 1..N {
            for c in 0..3 {
                b[i][c] -= a[i][k] * b[k][c];
            }
        }
    }
    for i in (0..N).rev() {
        for c in 0..3 {
            b[i][c] *= a[i][i];
        }
        for k in 0..i {
            for c in 0..3 {
                b[k][c] -= a[i][k] * b[i][c];
            }
        }
    }
    std::array::from_fn(|c| {
        let moved: f64 = (0..N).map(|i| b[i][c] * mean[i + 1]).sum();
        std::array::from_fn(|k| if k == 0 { (light[c] - moved) as f32 } else { b[k - 1][c] as f32 })
    })
}
