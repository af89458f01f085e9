//! Directions of multiple scattering between facets.

use std::f64::consts::PI;

use crate::math::DVec3;
use crate::math::elementary::{exp, ln, sin_cos_turns};

/// Directions of the multiple-scattering lobes, on either side. Narrow GGX lobes lose most at grazing angles: the
/// density is proportional to µ / (µ² + 4α²).
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    pub(super) k: f64,
    /// ln(1 + 1/k).
    pub(super) log: f64,
}

impl Spread {
    pub(super) fn new(alpha: f64) -> Spread {
        let k = 4.0 * alpha * alpha;
        Spread { k, log: ln(1.0 + 1.0 / k) }
    }

    /// Density per solid angle at the cosine `mu`.
    pub(super) fn pdf(&self, mu: f64) -> f64 {
        mu / (PI * (mu * mu + self.k) * self.log)
    }

    /// A direction in the upper hemisphere.
    pub(super) fn sample(&self, u: [f64; 2]) -> DVec3 {
        let mu2 = (self.k * (exp(u[0] * self.log) - 1.0)).clamp(0.0, 1.0);
        let (sin, cos) = sin_cos_turns(u[1]);
        let r = (1.0 - mu2).sqrt();
        DVec3::new(r * cos, r * sin, mu2.sqrt())
    }
}
