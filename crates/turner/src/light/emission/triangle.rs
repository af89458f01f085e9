//! Triangles that shine.

use super::{EmitterSample, NEAR, per_solid_angle};
use crate::light::LightBound;
use crate::math::DVec3;
use crate::math::elementary::{atan2, sin_cos};

/// A triangle; near ones are sampled by solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleEmitter {
    corners: [DVec3; 3],
    normal: DVec3,
    per_area: f64,
}

/// The triangle that the corners' directions span on the sphere around a point.
struct Spherical {
    a: DVec3,
    b: DVec3,
    c: DVec3,
    /// The angle at a, as sine and cosine.
    alpha: (f64, f64),
    /// The sum of the angles.
    angles: f64,
    solid_angle: f64,
}

impl TriangleEmitter {
    /// From its corners; `None` without area. The normal is `side`, 1 or −1, times (b − a) × (c − a).
    pub fn new(corners: [DVec3; 3], side: f64) -> Option<TriangleEmitter> {
        let [a, b, c] = corners;
        let across = (b - a).cross(c - a);
        let per_area = 2.0 / across.length();
        let normal = side * across.try_normalize()?;
        (per_area > 0.0 && per_area.is_finite()).then_some(TriangleEmitter { corners, normal, per_area })
    }

    /// Its normal, unit.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        1.0 / self.per_area
    }

    /// Its bounds, for a power per steradian along the normal.
    pub fn bound(&self, two_sided: bool, power: f64) -> LightBound {
        let [a, b, c] = self.corners;
        let center = 0.5 * (a.min(b).min(c) + a.max(b).max(c));
        let radius = [a, b, c].map(|p| p.distance(center)).into_iter().fold(0.0, f64::max);
        LightBound::flat(center, radius, self.normal, two_sided, power)
    }

    fn spherical(&self, p: DVec3) -> Option<Spherical> {
        let [a, b, c] = self.corners;
        let size2 = a.distance_squared(b).max(a.distance_squared(c));
        let middle = (a + b + c) / 3.0;
        if size2 < NEAR * p.distance_squared(middle) {
            return None;
        }
        let [a, b, c] = [a - p, b - p, c - p].map(|v| v.normalize());
        let (ab, bc, ca) = (a.cross(b), b.cross(c), c.cross(a));
        let (ab, bc, ca) = (ab.try_normalize()?, bc.try_normalize()?, ca.try_normalize()?);
        let angle = |m: DVec3, n: DVec3| atan2(m.cross(n).length(), m.dot(n));
        let alpha = angle(ab, -ca);
        let angles = alpha + angle(bc, -ab) + angle(ca, -bc);
        let solid_angle = angles - std::f64::consts::PI;
        // Thin and tiny ones lose their digits.
        (solid_angle > 1e-3 && solid_angle < std::f64::consts::TAU).then(|| Spherical {
            a,
            b,
            c,
            alpha: sin_cos(alpha),
            angles,
            solid_angle,
        })
    }

    /// The point that `u` chooses, seen from `p`: by area, or by solid angle (Arvo 1995, "Stratified sampling of spherical
    /// triangles").
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let [a, b, c] = self.corners;
        let Some(s) = self.spherical(p) else {
            let root = u[0].sqrt();
            let (v, w) = (root * (1.0 - u[1]), root * u[1]);
            let q = (1.0 - v - w) * a + v * b + w * c;
            let pdf = per_solid_angle(self.per_area, p, q, self.normal)?;
            return Some(EmitterSample { q, n: self.normal, u: v, v: w, pdf });
        };
        let (sin_alpha, cos_alpha) = s.alpha;
        // The sub-triangle a, b, c' with the share u[0] of the solid angle.
        let part = std::f64::consts::PI + u[0] * (s.angles - std::f64::consts::PI);
        let (sin, cos) = sin_cos(part);
        let (sin_phi, cos_phi) = (sin * cos_alpha - cos * sin_alpha, cos * cos_alpha + sin * sin_alpha);
        let k1 = cos_phi + cos_alpha;
        let k2 = sin_phi - sin_alpha * s.a.dot(s.b);
        let denominator = (k2 * sin_phi + k1 * cos_phi) * sin_alpha;
        let cos_b = ((k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / denominator).clamp(-1.0, 1.0);
        let cos_b = if cos_b.is_nan() { 1.0 } else { cos_b };
        let sin_b = (1.0 - cos_b * cos_b).max(0.0).sqrt();
        let c_moved = cos_b * s.a + sin_b * (s.c - s.c.dot(s.a) * s.a).normalize_or_zero();
        let cos_theta = 1.0 - u[1] * (1.0 - c_moved.dot(s.b));
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let w = cos_theta * s.b + sin_theta * (c_moved - c_moved.dot(s.b) * s.b).normalize_or_zero();
        // Where that direction meets the triangle (Möller & Trumbore 1997).
        let (e1, e2) = (b - a, c - a);
        let across = w.cross(e2);
        let det = e1.dot(across);
        let from = p - a;
        let v = from.dot(across) / det;
        let w = w.dot(from.cross(e1)) / det;
        if !(v.is_finite() && w.is_finite()) {
            return None;
        }
        let v = v.clamp(0.0, 1.0);
        let w = w.clamp(0.0, 1.0 - v);
        let q = (1.0 - v - w) * a + v * b + w * c;
        Some(EmitterSample { q, n: self.normal, u: v, v: w, pdf: 1.0 / s.solid_angle })
    }

    /// The density of the direction from `p` to `q` on it.
    pub fn pdf(&self, p: DVec3, q: DVec3) -> f64 {
        match self.spherical(p) {
            Some(s) => 1.0 / s.solid_angle,
            None => per_solid_angle(self.per_area, p, q, self.normal).unwrap_or(0.0),
        }
    }
}
