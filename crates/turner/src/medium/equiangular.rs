//! Places along a ray by the angle at which a point beside it sees them: light that weakens with the square of the distance is then
//! found evenly (Kulla & Fajardo 2012, "Importance sampling techniques for path tracing in participating media", section 4).

use crate::math::DVec3;
use crate::math::elementary::{atan2, tan};

/// A part of a ray seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct Equiangular {
    /// Where along the ray the point is nearest.
    middle: f64,
    /// How far the point is from the ray.
    distance: f64,
    /// Angles of the two ends, from the nearest place.
    from: f64,
    to: f64,
}

impl Equiangular {
    /// For the places 0 to `end` (which may be infinite) of the ray from `origin` in the unit direction; `None` where the point lies so near the
    /// ray that there is no angle to speak of.
    pub fn new(origin: DVec3, direction: DVec3, end: f64, point: DVec3) -> Option<Equiangular> {
        let way = point - origin;
        let middle = way.dot(direction);
        let distance = way.cross(direction).length();
        if !(distance > 1e-9 * way.length() && distance > 1e-30 && distance < 1e30) {
            return None;
        }
        let (from, to) = (atan2(-middle, distance), atan2(end - middle, distance));
        (to - from > 1e-9).then_some(Equiangular { middle, distance, from, to })
    }

    /// A place by `u` in 0..1.
    pub fn sample(&self, u: f64) -> f64 {
        let angle = self.from + u * (self.to - self.from);
        self.middle + self.distance * tan(angle)
    }

    /// Density of a place, per unit of length.
    pub fn pdf(&self, t: f64) -> f64 {
        let beside = t - self.middle;
        self.distance / ((self.to - self.from) * (self.distance * self.distance + beside * beside))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_on_the_part_and_their_shares_are_those_of_the_density() {
        for (end, point) in [
            (4.0, DVec3::new(0.5, 1.0, 0.0)),
            (f64::INFINITY, DVec3::new(0.1, 2.0, -1.0)),
            (3.0, DVec3::new(0.01, -5.0, 0.0)),
            (3.0, DVec3::new(0.0, 9.0, 0.3)),
        ] {
            let e = Equiangular::new(DVec3::ZERO, DVec3::Y, end, point).unwrap();
            // The integral of the density between two samples is the difference of their numbers.
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
