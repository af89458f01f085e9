//! Means of pictures and how sure they are.

use crate::common::render;

/// The mean of a picture's pixels, and its standard error: pixels are independent samples of one value if all of them
/// look at the same thing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mean {
    pub(crate) value: [f64; 3],
    pub(crate) error: [f64; 3],
    pub(crate) alpha: f64,
}

/// Of a scene without film; 16 × 16 pixels.
pub(crate) fn mean(samples: u32, text: &str) -> Mean {
    mean_of(16, samples, text)
}

pub(crate) fn mean_of(size: u32, samples: u32, text: &str) -> Mean {
    let film = format!(
        "film.width = {size}\nfilm.height = {size}\nfilm.antialias = \"monte-carlo\"\nfilm.samples = {samples}\n"
    );
    let picture = render(&(film + text)).0;
    let n = picture.linear.len() as f64;
    let mut out = Mean { value: [0.0; 3], error: [0.0; 3], alpha: 0.0 };
    for i in 0..3 {
        let sum: f64 = picture.linear.iter().map(|p| f64::from(p[i])).sum();
        let mean = sum / n;
        let spread: f64 = picture.linear.iter().map(|p| (f64::from(p[i]) - mean).powi(2)).sum();
        out.value[i] = mean;
        out.error[i] = (spread / (n - 1.0) / n).sqrt();
    }
    out.alpha = picture.linear.iter().map(|p| f64::from(p[3])).sum::<f64>() / n;
    out
}

impl Mean {
    /// Within four standard errors, which must not be more than `cap` times the value: a noisy test cannot pass.
    #[track_caller]
    pub(crate) fn is(&self, expected: [f64; 3], cap: f64) {
        for i in 0..3 {
            let (got, error, e) = (self.value[i], self.error[i], expected[i]);
            assert!(error <= (cap + 1e-6) * e.abs() + 1e-12, "too noisy: {self:?}, expected {expected:?}");
            // Sums of colours are of single precision.
            assert!(
                (got - e).abs() <= 4.0 * error + 2e-6 * e.abs() + 1e-9,
                "{self:?}, expected {expected:?}"
            );
        }
    }

    #[track_caller]
    pub(crate) fn is_grey(&self, expected: f64, cap: f64) {
        self.is([expected; 3], cap);
    }

    /// Two estimates of one value.
    #[track_caller]
    pub(crate) fn agrees(&self, other: &Mean, cap: f64) {
        for i in 0..3 {
            let error = self.error[i].hypot(other.error[i]);
            assert!(error <= cap * self.value[i].abs(), "too noisy: {self:?} {other:?}");
            assert!((self.value[i] - other.value[i]).abs() <= 4.0 * error + 1e-9, "{self:?} and {other:?}");
        }
    }
}
