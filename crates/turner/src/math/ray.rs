//! Rays in world space or object space.

use super::{DAffine3, DVec3};

/// The segment origin + t · direction for t in `t_min..=t_max`. The direction may have any length other than 0: a ray
/// transformed to object space keeps its t.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// The point at t = 0.
    pub origin: DVec3,
    /// Change of position per unit of t.
    pub direction: DVec3,
    /// Smallest t that counts as a hit.
    pub t_min: f64,
    /// Largest t that counts as a hit.
    pub t_max: f64,
    /// Time within the shutter, 0..=1.
    pub time: f32,
}

impl Ray {
    /// A ray from `origin` towards `direction`, from t = 0 to infinity.
    pub fn new(origin: DVec3, direction: DVec3) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY, time: 0.0 }
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// Whether a hit at `t` counts: `t_min <= t <= t_max` and finite. NaN does not count.
    #[inline]
    pub fn contains(&self, t: f64) -> bool {
        t >= self.t_min && t <= self.t_max && t < f64::INFINITY
    }

    /// Whether origin and direction are finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        // x * 0 is 0 for finite x and NaN otherwise: one sum instead of six classifications.
        let zero = self.origin * 0.0 + self.direction * 0.0;
        zero.x + zero.y + zero.z == 0.0
    }

    /// The ray in another space; t keeps its meaning.
    pub fn transformed(&self, to: &DAffine3) -> Ray {
        Ray {
            origin: to.transform_point3(self.origin),
            direction: to.transform_vector3(self.direction),
            ..*self
        }
    }
}
