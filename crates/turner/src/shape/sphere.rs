//! Spheres.

use super::{ShapeHit, SurfacePoint};
use crate::math::elementary::{acos, atan2};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::scene::schema::{Range, params};

params! {
    /// A sphere. u runs once around the vertical (y) axis: 0 at −z, counter-clockwise seen from above, 0.25 at −x, 0.5 at +z,
    /// 0.75 at +x. v runs from 0 at the south pole (−y) to 1 at the north pole, in proportion to the angle.
    pub struct SphereDesc as "sphere" {
        /// The middle.
        center: DVec3 = DVec3::ZERO;
        /// The radius.
        radius: f64 = 1.0, in Range::POSITIVE;
    }
    example r#"[[object]]
type = "sphere"
center = [0, 1, 0]
radius = 1
material = { color = "tomato" }
"#
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The middle.
    pub center: DVec3,
    /// The radius, greater than 0.
    pub radius: f64,
}

impl Sphere {
    /// The box around it.
    pub fn bounds(&self) -> Bounds {
        Bounds::new(self.center - self.radius, self.center + self.radius)
    }

    /// The nearest of the two roots in range. The discriminant is taken from the distance of the centre to the
    /// ray's line, the roots by the stable form of the quadratic formula (Haines et al. 2019, "Precision
    /// improvements for ray/sphere intersection", Ray Tracing Gems ch. 7): exact enough for a sphere of radius
    /// 5000 seen from one unit away.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let f = ray.origin - self.center;
        let d = ray.direction;
        let a = d.length_squared();
        let b = -f.dot(d);
        let r2 = self.radius * self.radius;
        let nearest = f + (b / a) * d;
        let discriminant = r2 - nearest.length_squared();
        if !(discriminant >= 0.0) {
            return None;
        }
        let c = f.length_squared() - r2;
        let q = b + (a * discriminant).sqrt().copysign(b);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let (near, far) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        let inside = |t: f64| t >= ray.t_min && t <= ray.t_max;
        let t = if inside(near) {
            near
        } else if inside(far) {
            far
        } else {
            return None;
        };
        Some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    /// The surface at a hit.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let n = (ray.at(hit.t) - self.center).normalize();
        let p = self.center + self.radius * n;
        let scale = self.radius + self.center.abs().max_element();
        SurfacePoint { p, error: scale * 1e-15, ng: n, ns: n }
    }

    /// (u, v) at a unit normal.
    pub fn uv(n: DVec3) -> DVec2 {
        use std::f64::consts::{PI, TAU};
        DVec2::new(0.5 + atan2(n.x, n.z) / TAU, 1.0 - acos(n.y) / PI)
    }
}
