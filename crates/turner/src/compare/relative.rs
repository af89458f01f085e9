//! Square differences relative to the reference, so that dark and bright regions count alike: the usual measure
//! of noise (Rousselle, Knaus and Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error
//! Minimization", 2011, section 6).

use super::{Measured, Pair, mean_of};

/// Added to the square of the reference, so that errors in black regions are finite.
const EPSILON: f64 = 0.01;

/// (x − r)² / (r² + 0.01).
fn of_one(x: f64, r: f64) -> f64 {
    (x - r) * (x - r) / (r * r + EPSILON)
}

/// mean((x − r)² / (r² + 0.01)) over pixels and channels of the picture x and the reference r, which have the
/// same number of pixels. Noise in the reference adds to the result.
pub fn relative_mse(picture: &[[f64; 3]], reference: &[[f64; 3]]) -> f64 {
    let pairs = picture.iter().flatten().zip(reference.iter().flatten());
    let sum: f64 = pairs.map(|(x, r)| of_one(*x, *r)).sum();
    sum / (3 * picture.len().min(reference.len())).max(1) as f64
}

/// The same for a pair: over colours times alpha, and alpha if there is any. The map holds the mean over each
/// pixel's channels.
pub fn relmse(pair: &Pair) -> Measured {
    let n = pair.channels();
    let of_pixel = |(r, x): (&[f32; 4], &[f32; 4])| {
        let sum: f64 = (0..n).map(|c| of_one(f64::from(x[c]), f64::from(r[c]))).sum();
        (sum / n as f64) as f32
    };
    let map: Vec<f32> = pair.both().map(of_pixel).collect();
    Measured::new(pair, mean_of(&map), map)
}

#[cfg(test)]
mod tests {
    use super::super::testing::pair;
    use super::*;

    #[test]
    fn by_hand() {
        assert_eq!(relative_mse(&[[1.0, 0.0, 0.0]], &[[1.0, 0.0, 0.0]]), 0.0);
        assert!((relative_mse(&[[0.1, 0.0, 0.0]], &[[0.0; 3]]) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_first_of_a_pair_is_the_reference() {
        let pair = pair(2, 1, true, |_, _| [2.0, 2.0, 0.0], |x, _| [2.0, 2.0 + x as f32, 0.0]);
        let found = relmse(&pair);
        assert!((found.value - 1.0 / 4.01 / 6.0).abs() < 1e-8, "{}", found.value);
        assert_eq!((found.worst.x, found.map[0]), (1, 0.0));
    }
}
