//! Equiangular sampling of a ray: distances chosen by the angle at which a point sees them (Kulla and Fajardo 2012,
//! "Importance sampling techniques for path tracing in participating media", §4).
//!
//! ```text
//!              light
//!                o
//!              / | \
//!            /   |θ  \        distance D from the light to the ray
//!          / a   | b   \
//!    -----*------+------*----> ray
//!       t = 0    Δ      end    Δ: the closest point
//! ```
//!
//! Single scattering of a point light falls off as 1/(D² + (t − Δ)²) along the ray, a narrow peak where the ray passes
//! close to the light. t = Δ + D tan θ with θ uniform between the angles of the two ends gives the density pdf(t) = D /
//! ((θmax − θmin)(D² + (t − Δ)²)), which cancels the peak. What remains (transmittance, phase function, visibility) is
//! bounded, so the noise near lights disappears. The estimator is unbiased, since the density is positive on the
//! complete segment.

use crate::math::DVec3;
use crate::math::elementary::{atan2, tan};

/// A segment of a ray, seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct Equiangular {
    /// Δ: distance along the ray of its closest point.
    closest: f64,
    /// D: distance of the point from the ray.
    distance: f64,
    /// Angles of the two ends, from the closest point.
    theta_min: f64,
    theta_max: f64,
}

impl Equiangular {
    /// For the distances 0 to `end` (possibly infinite) along the ray from `origin` in the unit direction. `None` if
    /// the point is too close to the ray, or the angle too small.
    pub fn new(origin: DVec3, direction: DVec3, end: f64, point: DVec3) -> Option<Equiangular> {
        let to_point = point - origin;
        let closest = to_point.dot(direction);
        let distance = to_point.cross(direction).length();
        if !(distance > 1e-9 * to_point.length() && distance > 1e-30 && distance < 1e30) {
            return None;
        }
        let (theta_min, theta_max) = (atan2(-closest, distance), atan2(end - closest, distance));
        (theta_max - theta_min > 1e-9).then_some(Equiangular { closest, distance, theta_min, theta_max })
    }

    /// A distance; `u` in 0..1.
    pub fn sample(&self, u: f64) -> f64 {
        let angle = self.theta_min + u * (self.theta_max - self.theta_min);
        self.closest + self.distance * tan(angle)
    }

    /// Density of a distance, per unit of length.
    pub fn pdf(&self, t: f64) -> f64 {
        let offset = t - self.closest;
        self.distance
            / ((self.theta_max - self.theta_min) * (self.distance * self.distance + offset * offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_lie_on_the_segment_and_follow_the_density() {
        for (end, point) in [
            (4.0, DVec3::new(0.5, 1.0, 0.0)),
            (f64::INFINITY, DVec3::new(0.1, 2.0, -1.0)),
            (3.0, DVec3::new(0.01, -5.0, 0.0)),
            (3.0, DVec3::new(0.0, 9.0, 0.3)),
        ] {
            let e = Equiangular::new(DVec3::ZERO, DVec3::Y, end, point).unwrap();
            // The integral of the density between two samples is the difference of their random numbers.
            for i in 0..40 {
                let (a, b) = (f64::from(i) / 41.0, f64::from(i + 1) / 41.0);
                let (ta, tb) = (e.sample(a), e.sample(b));
                assert!(ta >= -1e-9 && tb <= end + 1e-9 && ta < tb, "{ta} {tb}");
                let n = 2000;
                let step = (tb - ta) / f64::from(n);
                let sum: f64 = (0..n).map(|k| e.pdf(ta + (f64::from(k) + 0.5) * step) * step).sum();
                assert!((sum - (b - a)).abs() < 1e-5, "{sum} {}", b - a);
            }
        }
        assert!(Equiangular::new(DVec3::ZERO, DVec3::Y, 1.0, 3.0 * DVec3::Y).is_none());
    }
}
