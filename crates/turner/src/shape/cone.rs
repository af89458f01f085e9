//! Cones and truncated cones (frustums), with or without caps.
//!
//! Local space has its origin at the centre of the narrow end, with z towards the wide end:
//!
//! ```text
//!      z = 0       ___        radius r₀ (0 for a pointed cone)
//!                 /   \
//!                /     \      radius at z: r(z) = r₀ + slope · z
//!               /       \
//!      z = h   /_________\    radius r₁
//! ```
//!
//! Inside the side surface x² + y² <= r(z)². With p = o + t d this is a quadratic inequality in t. Its
//! solutions include the mirrored second nappe above the apex, so the interval of t is intersected with the
//! slab 0 <= z <= h. Between its ends the cone is convex, so one interval of t remains; its two ends are the
//! candidate hits. The discriminant is computed by Lagrange's identity, which avoids the cancellation of b² − a
//! c for thin cones and distant rays.

use std::f64::consts::{PI, TAU};

use super::cylinder::slab;
use super::disk::disk_bounds;
use super::plane::tangents;
use super::{
    AreaPoint, ROUNDING, ShapeHit, SurfacePoint, axis_of, cap_uv, convex_hit, disk_point, unit_angle,
};
use crate::math::elementary::sin_cos;
use crate::math::{Bounds, DVec2, DVec3, Frame, Ray};
use crate::schema::{Range, SceneError, params};

params! {
    /// A cone from the centre of its base (`from`) to its tip (`to`). With `tip_radius` above 0 it is a
    /// truncated cone. Side: u runs once around the axis, counter-clockwise as seen from the tip, and v from 0
    /// at the base to 1 at the tip. With the tip along +y, u is the same as on a sphere: 0 at −z, 0.25 at −x,
    /// 0.5 at +z, 0.75 at +x. The caps have the (u, v) of a disk that faces outwards. Normals point outwards.
    pub struct ConeDesc as "cone" {
        /// Centre of the base.
        from: DVec3 = DVec3::NEG_Y;
        /// The tip, or the centre of the other end if `tip_radius` is above 0.
        to: DVec3 = DVec3::Y;
        /// Radius of the base.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// Radius at `to`; 0 is a pointed tip.
        tip_radius: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Whether disks close the ends; `false` leaves a hollow shell.
        capped: bool = true;
    }
    example r#"[[object]]
type = "cone"
from = [0, 0, 0]
to = [0, 2, 0]
radius = 1
tip_radius = 0.25
material = { color = "orange" }
"#
}

/// A cone. Parts: 0 is the side, 1 the cap at `from`, 2 the cap at `to`.
///
/// Local z runs from the narrow end to the wide end. The radius at z is then a sum of non-negative numbers and
/// keeps full relative precision near the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    narrow: DVec3,
    frame: Frame,
    height: f64,
    narrow_radius: f64,
    wide_radius: f64,
    /// Growth of the radius per unit of z, >= 0.
    slope: f64,
    /// Whether the narrow end is `to`.
    narrow_is_to: bool,
    capped: bool,
    error: f64,
}

impl ConeDesc {
    /// Converts it to the form that rays are intersected with.
    pub fn prepare(&self) -> Result<Cone, SceneError> {
        let (_, height) = axis_of(self.from, self.to, "cone")?;
        let narrow_is_to = self.tip_radius <= self.radius;
        let (narrow, wide) = if narrow_is_to { (self.to, self.from) } else { (self.from, self.to) };
        let z = (wide - narrow).normalize();
        let (x, y) = tangents(z);
        let (small, large) = (self.radius.min(self.tip_radius), self.radius.max(self.tip_radius));
        let scale = self.from.abs().max(self.to.abs()).max_element() + large + height;
        Ok(Cone {
            narrow,
            frame: Frame { x, y, z },
            height,
            narrow_radius: small,
            wide_radius: large,
            slope: (large - small) / height,
            narrow_is_to,
            capped: self.capped,
            error: ROUNDING * scale,
        })
    }
}

impl Cone {
    /// The circles at both ends: centre and two perpendicular radii.
    pub(super) fn rims(&self) -> [[DVec3; 3]; 2] {
        let rim = |z: f64, r: f64| [self.narrow + z * self.frame.z, r * self.frame.x, r * self.frame.y];
        [rim(0.0, self.narrow_radius), rim(self.height, self.wide_radius)]
    }

    /// The mean of the two end radii.
    pub(super) fn mean_radius(&self) -> f64 {
        0.5 * (self.narrow_radius + self.wide_radius)
    }

    /// Whether disks close its ends.
    pub(super) fn is_capped(&self) -> bool {
        self.capped
    }

    /// Bounding box.
    pub fn bounds(&self) -> Bounds {
        let n = self.frame.z;
        let wide = disk_bounds(self.narrow + self.height * n, n, self.wide_radius);
        let both = disk_bounds(self.narrow, n, self.narrow_radius).union(&wide);
        Bounds::new(both.min - self.error, both.max + self.error)
    }

    /// Nearest hit: see the module documentation.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        if !ray.is_finite() {
            return None;
        }
        let (mut o, d) = (self.frame.to_local(ray.origin - self.narrow), self.frame.to_local(ray.direction));
        // Move a distant origin close to the cone first: the square of the distance would swamp the square of
        // the radius.
        let reach = self.height + self.wide_radius;
        let mut start = 0.0;
        if o.length_squared() > 16.0 * reach * reach {
            let a = d.length_squared();
            start = -o.dot(d) / a;
            o += start * d;
            if !(o.length_squared() <= 4.0 * reach * reach) {
                return None;
            }
        }
        let (slab, low, high) = slab(o.z, d.z, self.height)?;
        let side = self.inside_side(o, d, slab)?;
        let (narrow, wide) = self.cap_parts();
        let part = |end: u32| if end == 1 { narrow } else { wide };
        if self.capped {
            let enter = if slab.0 > side.0 { (slab.0 + start, part(low)) } else { (side.0 + start, 0) };
            let exit = if slab.1 < side.1 { (slab.1 + start, part(high)) } else { (side.1 + start, 0) };
            return convex_hit(ray, enter, exit);
        }
        [side.0, side.1]
            .into_iter()
            .find(|&t| t >= slab.0 && t <= slab.1 && ray.contains(t + start))
            .map(|t| ShapeHit { t: t + start, part: 0, u: 0.0, v: 0.0 })
    }

    /// The interval of t inside the infinite cone; of the two nappes, the one within the slab.
    fn inside_side(&self, o: DVec3, d: DVec3, slab: (f64, f64)) -> Option<(f64, f64)> {
        let (r, dr) = (self.narrow_radius + self.slope * o.z, self.slope * d.z);
        // Inside: a t² − 2 b t + c <= 0.
        let a = d.x * d.x + d.y * d.y - dr * dr;
        let b = r * dr - o.x * d.x - o.y * d.y;
        let c = o.x * o.x + o.y * o.y - r * r;
        if a == 0.0 {
            return match b {
                b if b > 0.0 => Some((c / (2.0 * b), f64::INFINITY)),
                b if b < 0.0 => Some((f64::NEG_INFINITY, c / (2.0 * b))),
                _ => (c <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY)),
            };
        }
        // b² − a c by Lagrange's identity, without the cancellation of large equal terms.
        let cross = o.x * d.y - o.y * d.x;
        let (mx, my) = (r * d.x - dr * o.x, r * d.y - dr * o.y);
        let discriminant = mx * mx + my * my - cross * cross;
        if a > 0.0 && !(discriminant >= 0.0) {
            return None;
        }
        let q = b + discriminant.max(0.0).sqrt().copysign(b);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let (t0, t1) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        if a > 0.0 {
            return Some((t0, t1));
        }
        // The ray is steeper than the side: it is inside one nappe before t0 and inside the other after t1.
        let before = t0.min(slab.1) - slab.0;
        let after = slab.1 - t1.max(slab.0);
        Some(if before > after { (f64::NEG_INFINITY, t0) } else { (t1, f64::INFINITY) })
    }

    /// Part numbers of the caps at the narrow and the wide end.
    fn cap_parts(&self) -> (u32, u32) {
        if self.narrow_is_to { (2, 1) } else { (1, 2) }
    }

    /// The surface point at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let mut p = self.frame.to_local(ray.at(hit.t) - self.narrow);
        let n = if hit.part == 0 {
            p.z = p.z.clamp(0.0, self.height);
            let out = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X);
            let r = self.narrow_radius + self.slope * p.z;
            p = DVec3::new(r * out.x, r * out.y, p.z);
            self.frame.to_world(DVec3::new(out.x, out.y, -self.slope).normalize())
        } else if hit.part == self.cap_parts().0 {
            p.z = 0.0;
            -self.frame.z
        } else {
            p.z = self.height;
            self.frame.z
        };
        SurfacePoint { p: self.narrow + self.frame.to_world(p), error: self.error, ng: n, ns: n }
    }

    /// Areas of the side, the narrow cap and the wide cap.
    fn areas(&self) -> [f64; 3] {
        let (r, wide) = (self.narrow_radius, self.wide_radius);
        let slant = (self.height * self.height + (wide - r) * (wide - r)).sqrt();
        let cap = |r: f64| if self.capped { PI * r * r } else { 0.0 };
        [PI * (r + wide) * slant, cap(r), cap(wide)]
    }

    /// Total surface area.
    pub fn area(&self) -> f64 {
        self.areas().iter().sum()
    }

    /// Samples a point uniformly by area from two random numbers in [0, 1).
    pub fn point_by_area(&self, u: [f64; 2]) -> AreaPoint {
        let [side, narrow, wide] = self.areas();
        let at = |part: u32, p: DVec3, n: DVec3| AreaPoint {
            p: self.narrow + self.frame.to_world(p),
            n: self.frame.to_world(n),
            part,
        };
        let target = u[0] * (side + narrow + wide);
        if target < side || narrow + wide == 0.0 {
            let (s, c) = sin_cos(TAU * u[1]);
            let fraction = (target / side).min(1.0);
            // The area of the side up to radius r is proportional to r² − r₀²: sample r² uniformly.
            let (r0, r1) = (self.narrow_radius, self.wide_radius);
            let r = (r0 * r0 + fraction * (r1 - r0) * (r1 + r0)).sqrt();
            let z = if r + r0 > 0.0 { fraction * (r1 + r0) / (r + r0) * self.height } else { 0.0 };
            let n = DVec3::new(c, s, -self.slope).normalize();
            return at(0, DVec3::new(r * c, r * s, z), n);
        }
        let target = target - side;
        let (narrow_part, wide_part) = self.cap_parts();
        if target < narrow {
            return at(narrow_part, disk_point(self.narrow_radius, [target / narrow, u[1]]), -DVec3::Z);
        }
        let p = disk_point(self.wide_radius, [((target - narrow) / wide).clamp(0.0, 1.0), u[1]]);
        at(wide_part, p + self.height * DVec3::Z, DVec3::Z)
    }

    /// (u, v) on the part that was hit.
    pub fn uv(&self, part: u32, p: DVec3) -> DVec2 {
        let local = self.frame.to_local(p - self.narrow);
        let to_tip = if self.narrow_is_to { -self.frame.z } else { self.frame.z };
        let (right, up) = tangents(to_tip);
        if part == 0 {
            let f = p - self.narrow;
            let v = (local.z / self.height).clamp(0.0, 1.0);
            let v = if self.narrow_is_to { 1.0 - v } else { v };
            return DVec2::new(unit_angle(f.dot(right), -f.dot(up)), v);
        }
        let narrow = part == self.cap_parts().0;
        let radius = if narrow { self.narrow_radius } else { self.wide_radius };
        let outward = if narrow { -self.frame.z } else { self.frame.z };
        cap_uv(&self.frame, outward, local, radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn desc() -> ConeDesc {
        ConeDesc { from: DVec3::ZERO, to: DVec3::Y, radius: 1.0, tip_radius: 0.0, capped: true }
    }

    fn hit(c: &ConeDesc, o: [f64; 3], d: [f64; 3]) -> Option<(f64, u32)> {
        c.prepare().unwrap().intersect(&Ray::new(o.into(), d.into())).map(|h| (h.t, h.part))
    }

    #[test]
    fn side_base_tip_and_generator() {
        let near = |a: Option<(f64, u32)>, t: f64, part: u32| {
            let (found, p) = a.expect("a hit");
            assert!((found - t).abs() < 1e-12 && p == part, "{found} {p}, expected {t} {part}");
        };
        near(hit(&desc(), [-3.0, 0.5, 0.0], [1.0, 0.0, 0.0]), 2.5, 0);
        near(hit(&desc(), [0.0, 0.5, 0.0], [1.0, 0.0, 0.0]), 0.5, 0);
        near(hit(&desc(), [0.25, -2.0, 0.0], [0.0, 1.0, 0.0]), 2.0, 1);
        near(hit(&desc(), [0.25, 2.0, 0.0], [0.0, -1.0, 0.0]), 1.25, 0);
        near(hit(&desc(), [0.0, 2.0, 0.0], [0.0, -1.0, 0.0]), 1.0, 0);
        // Parallel to a generator, from inside: leaves through the base only.
        near(hit(&desc(), [0.0, 0.5, 0.0], [0.5, -0.5, 0.0]), 1.0, 1);
        assert_eq!(hit(&desc(), [-3.0, 1.1, 0.0], [1.0, 0.0, 0.0]), None);
        // The second nappe is not part of the cone.
        assert_eq!(hit(&desc(), [0.0, 3.0, 0.0], [1.0, 0.1, 0.0]), None);
        let cut = ConeDesc { tip_radius: 0.5, ..desc() };
        near(hit(&cut, [0.25, 2.0, 0.0], [0.0, -1.0, 0.0]), 1.0, 2);
        let open = ConeDesc { capped: false, ..cut.clone() };
        // In through the open end, onto the inner side where −0.25 + 0.65 t = t / 2.
        near(hit(&open, [-0.25, 2.0, 0.0], [0.65, -1.0, 0.0]), 5.0 / 3.0, 0);
        let wide = ConeDesc { radius: 0.5, tip_radius: 1.0, ..desc() };
        near(hit(&wide, [0.75, 2.0, 0.0], [0.0, -1.0, 0.0]), 1.0, 2);
        near(hit(&wide, [-3.0, 0.5, 0.0], [1.0, 0.0, 0.0]), 2.25, 0);
    }

    #[test]
    fn v_runs_from_base_to_tip_for_either_slope() {
        for (radius, tip_radius) in [(1.0, 0.5), (0.5, 1.0), (1.0, 1.0)] {
            let c = ConeDesc { radius, tip_radius, ..desc() }.prepare().unwrap();
            let uv = c.uv(0, DVec3::new(0.9, 0.25, 0.0));
            assert!((uv - DVec2::new(0.75, 0.25)).length() < 1e-12, "{uv}");
            assert_eq!(c.uv(2, DVec3::new(0.0, 1.0, 0.0)), DVec2::splat(0.5));
        }
        assert!(ConeDesc { to: DVec3::ZERO, ..desc() }.prepare().is_err());
    }
}
