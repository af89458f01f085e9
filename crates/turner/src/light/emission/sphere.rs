//! Spheres that shine.

use std::f64::consts::{PI, TAU};

use super::{EmitterSample, per_solid_angle};
use crate::math::elementary::sin_cos;
use crate::math::{DVec3, Frame};
use crate::sampler::uniform_sphere;

/// A sphere. From outside, the cone it fills is sampled evenly (Shirley et al. 1996, "Monte Carlo techniques for direct
/// lighting calculations"); from inside, its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereEmitter {
    /// The middle.
    pub center: DVec3,
    /// The radius.
    pub radius: f64,
}

impl SphereEmitter {
    /// 1 − cos of the half angle it fills; `None` from inside or too near to tell.
    #[inline]
    fn cap(&self, distance2: f64) -> Option<f64> {
        let sin2 = self.radius * self.radius / distance2;
        (sin2 < 1.0 - 1e-9).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
    }

    /// The point that `u` chooses, seen from `p`.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let to_center = self.center - p;
        let d2 = to_center.length_squared();
        let Some(cap) = self.cap(d2) else {
            let n = uniform_sphere(u.into());
            let q = self.center + self.radius * n;
            let pdf = per_solid_angle(self.per_area(), p, q, n)?;
            return Some(EmitterSample { q, n, u: 0.0, v: 0.0, pdf });
        };
        let d = d2.sqrt();
        let x = u[0] * cap;
        let (cos, sin2) = (1.0 - x, x * (2.0 - x));
        let (s, c) = sin_cos(TAU * u[1]);
        let sin = sin2.sqrt();
        let w = Frame::from_z(to_center / d).to_world(DVec3::new(sin * c, sin * s, cos));
        let t = d * cos - (self.radius * self.radius - d2 * sin2).max(0.0).sqrt();
        let n = (p + t * w - self.center).try_normalize()?;
        let pdf = 1.0 / (TAU * cap);
        Some(EmitterSample { q: self.center + self.radius * n, n, u: 0.0, v: 0.0, pdf })
    }

    /// The density of the direction from `p` to `q` on it, where the normal is `n`.
    pub fn pdf(&self, p: DVec3, q: DVec3, n: DVec3) -> f64 {
        match self.cap(p.distance_squared(self.center)) {
            Some(cap) => 1.0 / (TAU * cap),
            None => per_solid_angle(self.per_area(), p, q, n).unwrap_or(0.0),
        }
    }

    fn per_area(&self) -> f64 {
        1.0 / self.area()
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }
}
