//! Means.

use turner::math::elementary::{exp, ln};

/// The geometric mean of positive values; `None` for no values.
pub(crate) fn geometric_mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    // Turner's own logarithm gives the same digits on every platform.
    let (mut sum, mut count) = (0.0, 0);
    for value in values {
        sum += ln(value);
        count += 1;
    }
    (count > 0).then(|| exp(sum / f64::from(count)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_half_and_two_is_one() {
        assert!((geometric_mean([0.5, 2.0].into_iter()).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(geometric_mean(std::iter::empty()), None);
    }
}
