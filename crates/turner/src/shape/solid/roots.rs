//! Real roots of polynomials in an interval.
//!
//! Between neighbouring roots of its derivative a polynomial is monotone, so a change of sign brackets exactly one
//! root. The roots of the derivative are found in the same way, down to the linear one. Each root is refined by
//! Newton's method with bisection until neighbouring numbers bracket it. Double roots without a change of sign are no
//! crossings and are not reported.

/// The highest degree.
pub(super) const MAX_DEGREE: usize = 8;

/// Roots in ascending order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Roots {
    values: [f64; MAX_DEGREE + 1],
    count: usize,
}

impl Roots {
    /// The roots.
    pub(super) fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }

    fn push(&mut self, root: f64) {
        if let Some(slot) = self.values.get_mut(self.count) {
            *slot = root;
            self.count += 1;
        }
    }
}

/// The value of a polynomial with ascending coefficients.
pub(super) fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The roots between `low` and `high` of a polynomial with ascending coefficients, of degree [`MAX_DEGREE`] at most.
pub(super) fn roots(coefficients: &[f64], low: f64, high: f64) -> Roots {
    let below = [low, high].map(|x| value(coefficients, x) < 0.0);
    roots_with_signs(coefficients, low, high, below)
}

/// The same where it is given whether the polynomial is negative at `low` and at `high`: pieces that meet there agree
/// on it, whatever the rounding.
pub(super) fn roots_with_signs(coefficients: &[f64], low: f64, high: f64, negative: [bool; 2]) -> Roots {
    let degree = coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0).min(MAX_DEGREE);
    // All derivatives: the k-th has degree − k.
    let mut derivatives = [[0.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
    derivatives[0][..=degree].copy_from_slice(&coefficients[..=degree]);
    for k in 0..degree {
        for i in 1..=degree - k {
            derivatives[k + 1][i - 1] = derivatives[k][i] * i as f64;
        }
    }
    let mut found = Roots::default();
    for k in (0..degree).rev() {
        let (own, slope) = (&derivatives[k][..=degree - k], &derivatives[k + 1][..degree - k]);
        let between = found;
        found = Roots::default();
        let ends = if k == 0 { negative } else { [low, high].map(|x| value(own, x) < 0.0) };
        let (mut from, mut below) = (low, ends[0]);
        let turns = between.as_slice();
        for (i, to) in turns.iter().copied().chain([high]).enumerate() {
            let next = if i == turns.len() { ends[1] } else { value(own, to) < 0.0 };
            if next != below && from < to {
                found.push(refine(from, to, below, |x| (value(own, x), value(slope, x))));
            }
            (from, below) = (to, next);
        }
    }
    found
}

/// The crossing between `low` and `high` of a function that is negative at `low` if `below`, and has the other sign at
/// `high`. `at` gives its value and derivative.
pub(super) fn refine(mut low: f64, mut high: f64, below: bool, at: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut x = 0.5 * (low + high);
    for i in 0..100 {
        if !(x > low && x < high) {
            break;
        }
        let (value, slope) = at(x);
        if (value < 0.0) == below {
            low = x
        } else {
            high = x
        }
        let step = x - value / slope;
        let middle = 0.5 * (low + high);
        // Newton's method may creep along one end: every fourth step halves the interval.
        let newton = step > low && step < high && i % 4 != 3;
        let next = if newton { step } else { middle };
        // A step that no longer moves x has converged: look at its neighbour on the other side.
        x = if next == x { if (value < 0.0) == below { x.next_up() } else { x.next_down() } } else { next };
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn products_of_linear_factors() {
        let mut random = Random::new(2);
        for degree in 1..=MAX_DEGREE {
            for _ in 0..200 {
                let mut expected: Vec<f64> = (0..degree).map(|_| 4.0 * random.unit() - 2.0).collect();
                expected.sort_by(f64::total_cmp);
                if expected.windows(2).any(|pair| pair[1] - pair[0] < 0.05) {
                    continue;
                }
                let mut polynomial = vec![1.0];
                for root in &expected {
                    let mut next = vec![0.0; polynomial.len() + 1];
                    for (i, c) in polynomial.iter().enumerate() {
                        next[i + 1] += c;
                        next[i] -= root * c;
                    }
                    polynomial = next;
                }
                let found = roots(&polynomial, -1.0, 1.5);
                expected.retain(|root| (-1.0..1.5).contains(root));
                assert_eq!(found.as_slice().len(), expected.len(), "{polynomial:?}");
                for (a, b) in found.as_slice().iter().zip(&expected) {
                    assert!((a - b).abs() < 1e-7, "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn exact_and_degenerate() {
        assert_eq!(roots(&[-2.0, 0.0, 1.0], 0.0, 2.0).as_slice(), [2.0f64.sqrt()]);
        assert!(roots(&[1.0, -2.0, 1.0], 0.0, 2.0).as_slice().is_empty(), "a double root is no crossing");
        assert!(roots(&[0.0; 5], 0.0, 2.0).as_slice().is_empty());
        assert!(roots(&[1.0], 0.0, 2.0).as_slice().is_empty());
        assert_eq!(roots(&[-1.0, 2.0, 0.0, 0.0], 0.0, 2.0).as_slice(), [0.5]);
        assert!(roots(&[f64::NAN, 1.0], 0.0, 2.0).as_slice().is_empty());
    }
}
