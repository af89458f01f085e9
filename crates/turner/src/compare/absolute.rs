//! Absolute differences |a − b| of the stored values: of colours times alpha, and of alpha if there is any.

use super::{Measured, Pair};

/// The largest over all channels and pixels.
pub fn max(pair: &Pair) -> Measured {
    let found = Measured::new(pair, 0.0, map(pair));
    Measured { value: f64::from(found.worst.value), ..found }
}

/// The mean over all channels and pixels.
pub fn mean(pair: &Pair) -> Measured {
    let n = pair.channels();
    let sum: f64 = pair.both().map(|(p, q)| (0..n).map(|c| distance(p[c], q[c])).sum::<f64>()).sum();
    let count = n * pair.width as usize * pair.height as usize;
    Measured::new(pair, sum / count.max(1) as f64, map(pair))
}

/// The largest of each pixel.
pub(super) fn map(pair: &Pair) -> Vec<f32> {
    let n = pair.channels();
    pair.both().map(|(p, q)| (0..n).map(|c| distance(p[c], q[c])).fold(0.0, f64::max) as f32).collect()
}

fn distance(a: f32, b: f32) -> f64 {
    (f64::from(a) - f64::from(b)).abs()
}

#[cfg(test)]
mod tests {
    use super::super::testing::pair;
    use super::*;

    #[test]
    fn by_hand() {
        let b = |x: u32, y: u32| if (x, y) == (1, 2) { [0.25, 1.0, 0.5] } else { [0.5; 3] };
        let pair = pair(2, 3, true, |_, _| [0.5; 3], b);
        let most = max(&pair);
        assert_eq!((most.value, most.worst.x, most.worst.y), (0.5, 1, 2));
        // 0.25 + 0.5 over 18 numbers.
        assert!((mean(&pair).value - 0.75 / 18.0).abs() < 1e-15);
        assert_eq!(mean(&pair).map, [0.0, 0.0, 0.0, 0.0, 0.0, 0.5]);
    }
}
