//! Cylinders, with or without caps.
//!
//! A capped cylinder is the intersection of an infinite cylinder with the slab between its end planes. Both are
//! convex: the ray is inside each for one interval of t, and the hit is the nearest end in range of the common
//! interval. No ray can pass between side and cap at the rim.

use std::f64::consts::{PI, TAU};

use super::disk::disk_bounds;
use super::plane::tangents;
use super::{
    AreaPoint, ROUNDING, ShapeHit, SurfacePoint, axis_of, cap_uv, convex_hit, disk_point, unit_angle,
};
use crate::math::elementary::sin_cos;
use crate::math::{Bounds, DVec2, DVec3, Frame, Ray};
use crate::schema::{Range, SceneError, params};

params! {
    /// A cylinder between two points. Side: u runs once around the axis, counter-clockwise as seen from `to`,
    /// and v from 0 at `from` to 1 at `to`. With the axis along +y, u is the same as on a sphere: 0 at −z, 0.25
    /// at −x, 0.5 at +z, 0.75 at +x. The caps have the (u, v) of a disk that faces outwards. Normals point
    /// outwards.
    pub struct CylinderDesc as "cylinder" {
        /// Centre of one end.
        from: DVec3 = DVec3::NEG_Y;
        /// Centre of the other end.
        to: DVec3 = DVec3::Y;
        /// Radius.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// Whether disks close the ends; `false` is an open tube.
        capped: bool = true;
    }
    example r#"[[object]]
type = "cylinder"
from = [0, 0, 0]
to = [0, 2, 0]
radius = 0.5
material = { color = "seagreen" }
"#
}

/// A cylinder. Parts: 0 is the side, 1 the cap at `from`, 2 the cap at `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    from: DVec3,
    /// z runs from `from` to `to`.
    frame: Frame,
    height: f64,
    radius: f64,
    capped: bool,
    error: f64,
}

impl CylinderDesc {
    /// Converts it to the form that rays are intersected with.
    pub fn prepare(&self) -> Result<Cylinder, SceneError> {
        let (axis, height) = axis_of(self.from, self.to, "cylinder")?;
        let (x, y) = tangents(axis);
        let scale = self.from.abs().max(self.to.abs()).max_element() + self.radius + height;
        Ok(Cylinder {
            from: self.from,
            frame: Frame { x, y, z: axis },
            height,
            radius: self.radius,
            capped: self.capped,
            error: ROUNDING * scale,
        })
    }
}

impl Cylinder {
    /// The circles at both ends: centre and two perpendicular radii.
    pub(super) fn rims(&self) -> [[DVec3; 3]; 2] {
        let rim =
            |z: f64| [self.from + z * self.frame.z, self.radius * self.frame.x, self.radius * self.frame.y];
        [rim(0.0), rim(self.height)]
    }

    /// Radius.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// Whether disks close its ends.
    pub(super) fn is_capped(&self) -> bool {
        self.capped
    }

    /// Bounding box.
    pub fn bounds(&self) -> Bounds {
        let to = self.from + self.height * self.frame.z;
        let both = disk_bounds(self.from, self.frame.z, self.radius).union(&disk_bounds(
            to,
            self.frame.z,
            self.radius,
        ));
        Bounds::new(both.min - self.error, both.max + self.error)
    }

    /// Nearest hit: see the module documentation. Discriminant and roots are computed as for the sphere, in the
    /// plane perpendicular to the axis.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (o, d) = (self.frame.to_local(ray.origin - self.from), self.frame.to_local(ray.direction));
        let a = d.x * d.x + d.y * d.y;
        let cross = o.x * d.y - o.y * d.x;
        let r2 = self.radius * self.radius;
        let discriminant = a * r2 - cross * cross;
        if !(discriminant >= 0.0) {
            return None;
        }
        let b = -(o.x * d.x + o.y * d.y);
        let c = o.x * o.x + o.y * o.y - r2;
        let q = b + discriminant.sqrt().copysign(b);
        let (t0, t1) = if a == 0.0 {
            // Parallel to the axis: inside for all t or for none.
            if c <= 0.0 { (f64::NEG_INFINITY, f64::INFINITY) } else { return None }
        } else if q == 0.0 {
            (0.0, 0.0)
        } else {
            (c / q, q / a)
        };
        let side = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        let (slab, near, far) = slab(o.z, d.z, self.height)?;
        let hit = if self.capped {
            let enter = if slab.0 > side.0 { (slab.0, near) } else { (side.0, 0) };
            let exit = if slab.1 < side.1 { (slab.1, far) } else { (side.1, 0) };
            convex_hit(ray, enter, exit)
        } else {
            [side.0, side.1]
                .into_iter()
                .find(|&t| ray.contains(t) && t >= slab.0 && t <= slab.1)
                .map(|t| ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
        };
        hit.filter(|_| ray.is_finite())
    }

    /// The surface point at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let mut p = self.frame.to_local(ray.at(hit.t) - self.from);
        let n = match hit.part {
            0 => {
                let n = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X);
                p = DVec3::new(self.radius * n.x, self.radius * n.y, p.z.clamp(0.0, self.height));
                self.frame.to_world(n)
            }
            1 => {
                p.z = 0.0;
                -self.frame.z
            }
            _ => {
                p.z = self.height;
                self.frame.z
            }
        };
        SurfacePoint { p: self.from + self.frame.to_world(p), error: self.error, ng: n, ns: n }
    }

    /// Total surface area.
    pub fn area(&self) -> f64 {
        let caps = if self.capped { 2.0 * PI * self.radius * self.radius } else { 0.0 };
        TAU * self.radius * self.height + caps
    }

    /// Samples a point uniformly by area from two random numbers in [0, 1).
    pub fn point_by_area(&self, u: [f64; 2]) -> AreaPoint {
        let side = TAU * self.radius * self.height / self.area();
        let at = |part: u32, p: DVec3, n: DVec3| AreaPoint {
            p: self.from + self.frame.to_world(p),
            n: self.frame.to_world(n),
            part,
        };
        if u[0] < side || !self.capped {
            let (s, c) = sin_cos(TAU * u[1]);
            let z = (u[0] / side).min(1.0) * self.height;
            return at(0, DVec3::new(self.radius * c, self.radius * s, z), DVec3::new(c, s, 0.0));
        }
        let cap = (u[0] - side) / (1.0 - side) * 2.0;
        let p = disk_point(self.radius, [cap.fract(), u[1]]);
        if cap < 1.0 { at(1, p, -DVec3::Z) } else { at(2, p + self.height * DVec3::Z, DVec3::Z) }
    }

    /// (u, v) on the part that was hit.
    pub fn uv(&self, part: u32, p: DVec3) -> DVec2 {
        let p = self.frame.to_local(p - self.from);
        match part {
            0 => DVec2::new(unit_angle(p.x, -p.y), (p.z / self.height).clamp(0.0, 1.0)),
            1 => cap_uv(&self.frame, -self.frame.z, p, self.radius),
            _ => cap_uv(&self.frame, self.frame.z, p, self.radius),
        }
    }
}

/// The interval of t in which 0 <= o + t d <= height, and the caps (1 below, 2 above) at its ends.
#[inline]
pub(super) fn slab(o: f64, d: f64, height: f64) -> Option<((f64, f64), u32, u32)> {
    if d == 0.0 {
        return (o >= 0.0 && o <= height).then_some(((f64::NEG_INFINITY, f64::INFINITY), 1, 2));
    }
    let (lower, upper) = (-o / d, (height - o) / d);
    Some(if d > 0.0 { ((lower, upper), 1, 2) } else { ((upper, lower), 2, 1) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn desc() -> CylinderDesc {
        CylinderDesc { from: DVec3::NEG_Y, to: DVec3::Y, radius: 1.0, capped: true }
    }

    #[test]
    fn side_caps_and_axis_parallel_rays() {
        let solid = desc().prepare().unwrap();
        let tube = CylinderDesc { capped: false, ..desc() }.prepare().unwrap();
        let hit = |c: &Cylinder, o: [f64; 3], d: [f64; 3]| {
            c.intersect(&Ray::new(o.into(), d.into())).map(|h| (h.t, h.part))
        };
        assert_eq!(hit(&solid, [-3.0, 0.5, 0.0], [2.0, 0.0, 0.0]), Some((1.0, 0)));
        assert_eq!(hit(&solid, [0.0, 0.5, 0.0], [2.0, 0.0, 0.0]), Some((0.5, 0)));
        assert_eq!(hit(&solid, [0.2, 5.0, 0.0], [0.0, -1.0, 0.0]), Some((4.0, 2)));
        assert_eq!(hit(&solid, [0.2, -5.0, 0.0], [0.0, 1.0, 0.0]), Some((4.0, 1)));
        assert_eq!(hit(&tube, [0.2, 5.0, 0.0], [0.0, -1.0, 0.0]), None);
        // Through the open top onto the inner side.
        assert_eq!(hit(&tube, [-1.0, 2.0, 0.0], [1.0, -1.0, 0.0]), Some((2.0, 0)));
        assert_eq!(hit(&solid, [-1.0, 2.0, 0.0], [1.0, -1.0, 0.0]), Some((1.0, 2)));
        // Along the side and along the rim.
        assert_eq!(hit(&solid, [1.0, 3.0, 0.0], [0.0, -1.0, 0.0]), Some((2.0, 2)));
        assert!(hit(&solid, [-3.0, 1.0, 0.0], [1.0, 0.0, 0.0]).is_some());
        assert_eq!(hit(&solid, [-3.0, 1.0 + 1e-12, 0.0], [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn coordinates_agree_with_the_sphere() {
        let c = desc().prepare().unwrap();
        for (p, u) in [(DVec3::X, 0.75), (DVec3::Z, 0.5), (DVec3::NEG_X, 0.25)] {
            assert!((c.uv(0, p) - DVec2::new(u, 0.5)).length() < 1e-15, "{p}");
        }
        assert_eq!(c.uv(2, DVec3::new(0.5, 1.0, -0.5)), DVec2::splat(0.75));
        assert_eq!(c.uv(1, DVec3::new(0.5, -1.0, 0.5)), DVec2::splat(0.75));
        assert!(CylinderDesc { to: DVec3::NEG_Y, ..desc() }.prepare().is_err());
    }
}
