//! Means with their standard errors, and the test whether two of them estimate the same value (Welch 1947).
//!
//! A render has noise, so two renders are never equal. Several runs with different seeds give a mean m and,
//! from their spread, its variance v. If two means estimate the same value, then
//!
//! ```text
//! t = |m_a − m_b| / √(v_a + v_b),      ν = (v_a + v_b)² / (v_a² / ν_a + v_b² / ν_b)
//! ```
//!
//! follows Student's t distribution with ν degrees of freedom, approximately, where ν_a and ν_b are the numbers
//! of runs minus one. The tail of that distribution is the p-value. Unlike Student's own test it allows
//! different variances, which is the normal case: two integrators differ in their noise. A known value has the
//! variance 0 and infinite ν.

use super::tails::student_tails;

/// A mean with its variance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// The mean.
    pub mean: f64,
    /// The variance of the mean: the square of its standard error.
    pub variance: f64,
    /// Degrees of freedom of the variance; infinite if it is known exactly.
    pub freedom: f64,
}

impl Moments {
    /// A value without error.
    pub fn exact(mean: f64) -> Moments {
        Moments { mean, variance: 0.0, freedom: f64::INFINITY }
    }

    /// The mean of independent values of one distribution. With fewer than two values the variance is infinite.
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Moments {
        let n = values.clone().count() as f64;
        let mean = values.clone().sum::<f64>() / n;
        let squares: f64 = values.map(|v| (v - mean) * (v - mean)).sum();
        let variance = if n > 1.0 { squares / (n - 1.0) / n } else { f64::INFINITY };
        Moments { mean, variance, freedom: (n - 1.0).max(1.0) }
    }

    /// The standard error.
    pub fn error(&self) -> f64 {
        self.variance.sqrt()
    }
}

/// Tests whether two means differ by more than `tolerance` (for rounding, or for what is known to differ).
/// Returns the excess in standard errors and the probability of one at least as large. If neither mean has an
/// error, only the tolerance counts.
pub fn difference(a: &Moments, b: &Moments, tolerance: f64) -> (f64, f64) {
    let off = (a.mean - b.mean).abs() - tolerance;
    let variance = a.variance + b.variance;
    if off <= 0.0 {
        return (0.0, 1.0);
    }
    // A NaN is no estimate.
    if off.is_nan() || variance.is_nan() || variance <= 0.0 {
        return (f64::INFINITY, 0.0);
    }
    let part = |m: &Moments| m.variance * m.variance / m.freedom;
    let freedom = variance * variance / (part(a) + part(b));
    let t = off / variance.sqrt();
    (t, if t.is_nan() { 0.0 } else { student_tails(t, freedom) })
}

#[cfg(test)]
mod tests {
    use super::super::Random;
    use super::*;

    #[test]
    fn means_and_their_errors() {
        let m = Moments::of([1.0, 2.0, 3.0, 6.0].into_iter());
        assert!((m.mean - 3.0).abs() < 1e-15 && (m.variance - 14.0 / 12.0).abs() < 1e-15 && m.freedom == 3.0);
        assert_eq!(Moments::of([1.0].into_iter()).variance, f64::INFINITY);
        assert_eq!(difference(&Moments::exact(1.0), &Moments::exact(1.5), 0.5), (0.0, 1.0));
        assert_eq!(difference(&Moments::exact(1.0), &Moments::exact(1.6), 0.5).1, 0.0);
        assert_eq!(difference(&Moments::exact(f64::NAN), &Moments::exact(1.0), 0.5).1, 0.0);
        // Against a known value this is Student's test: t = 2 · √(12/14).
        let (t, p) = difference(&m, &Moments::exact(1.0), 0.0);
        assert!((t - 1.8516).abs() < 1e-4 && (p - 0.1612).abs() < 1e-3, "{t} {p}");
    }

    /// Also with few values and unequal variances.
    #[test]
    fn false_alarms_are_as_rare_as_promised() {
        let mut random = Random::new(5);
        let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let mut alarms = 0;
        for _ in 0..4000 {
            let a: Vec<f64> = (0..6).map(|_| normal()).collect();
            let b: Vec<f64> = (0..10).map(|_| 5.0 * normal()).collect();
            let (a, b) = (Moments::of(a.into_iter()), Moments::of(b.into_iter()));
            alarms += u32::from(difference(&a, &b, 0.0).1 < 0.01);
        }
        assert!((18..68).contains(&alarms), "{alarms} of 4000 at 1 %");
    }
}
