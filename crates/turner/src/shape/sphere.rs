//! Spheres.
//!
//! The discriminant is r² |d|² − |f × d|², with f from the centre to the ray's origin: it compares the radius
//! with the distance of the ray's line from the centre. Unlike b² − a c it does not cancel, and it needs no
//! division before a miss is known. The roots come from the stable form of the quadratic formula (Haines et al.
//! 2019, "Precision improvements for ray/sphere intersection", Ray Tracing Gems ch. 7): exact enough for a
//! sphere of radius 5000 seen from one unit away.

use super::{ROUNDING, ShapeHit, SurfacePoint};
use crate::math::elementary::{acos, atan2};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{Range, params};

params! {
    /// A sphere. u runs once around the vertical (y) axis, counter-clockwise as seen from above: 0 at −z, 0.25
    /// at −x, 0.5 at +z, 0.75 at +x. v runs from 0 at the south pole (−y) to 1 at the north pole (+y), in
    /// proportion to the angle. Normals point outwards.
    pub struct SphereDesc as "sphere" {
        /// Centre.
        center: DVec3 = DVec3::ZERO;
        /// Radius.
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
    /// Centre.
    pub center: DVec3,
    /// Radius, greater than 0.
    pub radius: f64,
}

impl Sphere {
    /// Bounding box.
    pub fn bounds(&self) -> Bounds {
        Bounds::new(self.center - self.radius, self.center + self.radius)
    }

    /// The nearest of the two roots in range.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let f = ray.origin - self.center;
        let d = ray.direction;
        let a = d.length_squared();
        let r2 = self.radius * self.radius;
        let discriminant = a * r2 - f.cross(d).length_squared();
        // Also rejects NaN and infinities.
        if !(discriminant >= 0.0) {
            return None;
        }
        let b = -f.dot(d);
        let c = f.length_squared() - r2;
        if b < 0.0 && c > 0.0 && ray.t_min >= 0.0 {
            return None;
        }
        let q = b + discriminant.sqrt().copysign(b);
        // c / q is the nearer root if the ray approaches the centre, the farther one if it moves away.
        let t0 = if q == 0.0 { 0.0 } else { c / q };
        let t = if b > 0.0 && ray.contains(t0) {
            t0
        } else {
            let t1 = q / a;
            // Otherwise the larger root; written out so that the version for eight rays does the same.
            if (b <= 0.0 && ray.contains(t1)) || t1 > t0 || t0.is_nan() { t1 } else { t0 }
        };
        (ray.contains(t) && a > 0.0).then_some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    /// The surface point at a hit.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let n = (ray.at(hit.t) - self.center).normalize();
        let p = self.center + self.radius * n;
        let scale = self.radius + self.center.abs().max_element();
        SurfacePoint { p, error: scale * ROUNDING, ng: n, ns: n }
    }

    /// (u, v) at a unit normal.
    pub fn uv(n: DVec3) -> DVec2 {
        use std::f64::consts::{PI, TAU};
        DVec2::new(0.5 + atan2(n.x, n.z) / TAU, 1.0 - acos(n.y) / PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::testing::Random;

    #[test]
    fn a_huge_sphere_seen_from_nearby_is_exact_at_every_scale() {
        let mut random = Random::new(1);
        for scale in [1.0, 1e-4, 1e5] {
            let sphere = Sphere { center: DVec3::new(0.0, -5001.0, 0.0) * scale, radius: 5000.0 * scale };
            let mut hits = 0;
            for _ in 0..100_000 {
                let origin = scale * DVec3::new(random.unit(), 0.0, random.unit());
                let mut d = random.direction();
                d.y = -d.y.abs() * random.unit();
                let ray = Ray::new(origin, d * (0.01 + random.unit()));
                let Some(hit) = sphere.intersect(&ray) else { continue };
                hits += 1;
                let s = sphere.surface(&ray, &hit);
                let off = (s.p.distance(sphere.center) - sphere.radius).abs();
                assert!(off <= 1e-9 * scale && off <= s.error, "{off}");
                assert!(s.error < 1e-9 * scale, "{}", s.error);
                let out = random.direction();
                let out = if out.dot(s.ng) < 0.0 { -out } else { out };
                let away = Ray::new(s.p + s.error * s.ng, out);
                assert!(sphere.intersect(&away).is_none(), "{away:?}");
            }
            assert!(hits > 80_000, "{hits}");
        }
    }

    #[test]
    fn closed_forms() {
        let sphere = Sphere { center: DVec3::new(0.0, 0.0, 3.0), radius: 1.0 };
        let hit = |o: [f64; 3], d: [f64; 3]| sphere.intersect(&Ray::new(o.into(), d.into())).map(|h| h.t);
        assert_eq!(hit([0.0; 3], [0.0, 0.0, 1.0]), Some(2.0));
        assert_eq!(hit([0.0; 3], [0.0, 0.0, 0.5]), Some(4.0));
        assert_eq!(hit([0.0, 0.0, 3.0], [0.0, 2.0, 0.0]), Some(0.5));
        assert_eq!(hit([0.0; 3], [0.0, 0.0, -1.0]), None);
        assert_eq!(hit([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]), Some(3.0));
        assert_eq!(hit([0.0, 0.0, 3.0], [0.0; 3]), None);
        for (n, u, v) in
            [(DVec3::X, 0.75, 0.5), (DVec3::Z, 0.5, 0.5), (DVec3::NEG_X, 0.25, 0.5), (DVec3::Y, 0.5, 1.0)]
        {
            assert!((Sphere::uv(n) - DVec2::new(u, v)).length() < 1e-15);
        }
    }
}
