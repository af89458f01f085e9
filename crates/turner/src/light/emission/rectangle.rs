//! Rectangles and parallelograms that shine.

use std::f64::consts::PI;

use super::{EmitterSample, NEAR, per_solid_angle};
use crate::math::DVec3;
use crate::math::elementary::{arc_cosine, sin_cos_turns};

/// A parallelogram; near ones with right angles are sampled by solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleEmitter {
    corner: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    per_area: f64,
    /// Lengths of the edges and their directions, if these are at right angles.
    right_angled: Option<([f64; 2], [DVec3; 2])>,
}

/// What the sphere around a point sees of a rectangle (Ureña et al. 2013, "An area-preserving parametrization for
/// spherical rectangles"); names as there.
struct Spherical {
    x: DVec3,
    y: DVec3,
    z: DVec3,
    x0: f64,
    x1: f64,
    y0: f64,
    y1: f64,
    z0: f64,
    b0: f64,
    b1: f64,
    k: f64,
    solid_angle: f64,
}

impl RectangleEmitter {
    /// From a corner and the edges that meet there; `None` without area. The normal is `side`, 1 or −1, times u × v.
    pub fn new(corner: DVec3, u: DVec3, v: DVec3, side: f64) -> Option<RectangleEmitter> {
        let across = u.cross(v);
        let per_area = 1.0 / across.length();
        let normal = side * across.try_normalize()?;
        let (lu, lv) = (u.length(), v.length());
        let right_angled = (u.dot(v).abs() <= 1e-9 * lu * lv).then(|| ([lu, lv], [u / lu, v / lv]));
        (per_area > 0.0 && per_area.is_finite()).then_some(RectangleEmitter {
            corner,
            u,
            v,
            normal,
            per_area,
            right_angled,
        })
    }

    fn spherical(&self, p: DVec3) -> Option<Spherical> {
        let ([lu, lv], [x, y]) = self.right_angled?;
        let diagonal2 = lu * lu + lv * lv;
        let middle = self.corner + 0.5 * (self.u + self.v);
        if diagonal2 < NEAR * p.distance_squared(middle) {
            return None;
        }
        let mut z = self.normal;
        let d = self.corner - p;
        let mut z0 = d.dot(z);
        if z0 > 0.0 {
            z = -z;
            z0 = -z0;
        }
        let (x0, y0) = (d.dot(x), d.dot(y));
        let (x1, y1) = (x0 + lu, y0 + lv);
        // Normals of the planes through the edges lie in planes of two axes.
        let side = |a: f64| a / (a * a + z0 * z0).sqrt();
        let (n0, n1, n2, n3) = (-side(y0), side(x1), side(y1), -side(x0));
        let g0 = arc_cosine((-n0 * n1).clamp(-1.0, 1.0));
        let g1 = arc_cosine((-n1 * n2).clamp(-1.0, 1.0));
        let g2 = arc_cosine((-n2 * n3).clamp(-1.0, 1.0));
        let g3 = arc_cosine((-n3 * n0).clamp(-1.0, 1.0));
        let k = 2.0 * PI - g2 - g3;
        let solid_angle = g0 + g1 - k;
        (solid_angle > 1e-4 && solid_angle.is_finite()).then_some(Spherical {
            x,
            y,
            z,
            x0,
            x1,
            y0,
            y1,
            z0,
            b0: n0,
            b1: n2,
            k,
            solid_angle,
        })
    }

    /// The point that `u` chooses, seen from `p`.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let Some(s) = self.spherical(p) else {
            let q = self.corner + u[0] * self.u + u[1] * self.v;
            let pdf = per_solid_angle(self.per_area, p, q, self.normal)?;
            return Some(EmitterSample { q, n: self.normal, u: u[0], v: u[1], pdf });
        };
        let (sin, cos) = sin_cos_turns((u[0] * s.solid_angle + s.k) * (0.5 / PI));
        let fu = (cos * s.b0 - s.b1) / sin;
        let cu = (1.0f64.copysign(fu) / (fu * fu + s.b0 * s.b0).sqrt()).clamp(-1.0, 1.0);
        let xu = (-(cu * s.z0) / (1.0 - cu * cu).max(1e-300).sqrt()).clamp(s.x0, s.x1);
        let d2 = xu * xu + s.z0 * s.z0;
        let h0 = s.y0 / (d2 + s.y0 * s.y0).sqrt();
        let h1 = s.y1 / (d2 + s.y1 * s.y1).sqrt();
        let hv = h0 + u[1] * (h1 - h0);
        let yv = if hv * hv < 1.0 - 1e-12 { hv * (d2 / (1.0 - hv * hv)).sqrt() } else { s.y1 };
        let yv = yv.clamp(s.y0, s.y1);
        let q = p + xu * s.x + yv * s.y + s.z0 * s.z;
        if !q.is_finite() {
            return None;
        }
        let (lu, lv) = (s.x1 - s.x0, s.y1 - s.y0);
        let (u, v) = ((xu - s.x0) / lu, (yv - s.y0) / lv);
        Some(EmitterSample { q, n: self.normal, u, v, pdf: 1.0 / s.solid_angle })
    }

    /// The density of the direction from `p` to `q` on it.
    pub fn pdf(&self, p: DVec3, q: DVec3) -> f64 {
        match self.spherical(p) {
            Some(s) => 1.0 / s.solid_angle,
            None => per_solid_angle(self.per_area, p, q, self.normal).unwrap_or(0.0),
        }
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        1.0 / self.per_area
    }
}
