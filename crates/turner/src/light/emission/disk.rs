//! Emissive disks, rings and ellipses.

use std::f64::consts::{PI, TAU};

use super::{EmitterSample, per_solid_angle};
use crate::light::LightBound;
use crate::math::DVec3;
use crate::math::elementary::sin_cos;

/// A disk under an affine transform; sampled by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskEmitter {
    center: DVec3,
    /// Two vectors from the centre to the edge, perpendicular in object space.
    x: DVec3,
    y: DVec3,
    /// Squared ratio of inner to outer radius.
    hole2: f64,
    normal: DVec3,
    per_area: f64,
}

impl DiskEmitter {
    /// From its centre, two perpendicular radii in object space, and the ratio of inner to outer radius; `None`
    /// without area. The normal is y × x.
    pub fn new(center: DVec3, x: DVec3, y: DVec3, hole: f64) -> Option<DiskEmitter> {
        let across = y.cross(x);
        let per_area = 1.0 / (PI * across.length() * (1.0 - hole * hole));
        let normal = across.try_normalize()?;
        (per_area > 0.0 && per_area.is_finite()).then_some(DiskEmitter {
            center,
            x,
            y,
            hole2: hole * hole,
            normal,
            per_area,
        })
    }

    /// Its bounds, for a power per steradian along the normal.
    pub fn bound(&self, two_sided: bool, power: f64) -> LightBound {
        // No point of an ellipse is farther from the centre than the root of the sum of the squares of two conjugate
        // radii.
        let radius = (self.x.length_squared() + self.y.length_squared()).sqrt();
        LightBound::flat(self.center, radius, self.normal, two_sided, power)
    }

    /// The point that `u` chooses, seen from `p`.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let r = (self.hole2 + (1.0 - self.hole2) * u[0]).sqrt();
        let (s, c) = sin_cos(TAU * u[1]);
        let q = self.center + r * (c * self.x + s * self.y);
        let pdf = per_solid_angle(self.per_area, p, q, self.normal)?;
        Some(EmitterSample { q, n: self.normal, u: 0.0, v: 0.0, pdf })
    }

    /// The pdf of the direction from `p` to the point `q` on it.
    pub fn pdf(&self, p: DVec3, q: DVec3) -> f64 {
        per_solid_angle(self.per_area, p, q, self.normal).unwrap_or(0.0)
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        1.0 / self.per_area
    }
}
