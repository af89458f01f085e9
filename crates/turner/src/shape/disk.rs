//! Flat disks and rings.

use std::f64::consts::TAU;

use super::plane::{crossing, flat_point, tangents};
use super::{ROUNDING, ShapeHit, SurfacePoint, direction};
use crate::math::elementary::atan2;
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// A flat disk, or a ring if `inner_radius` is above 0. (u, v) covers the square around the disk: the
    /// centre is (0.5, 0.5), and the rim touches 0 and 1. u runs to the right and v up, as seen from the side
    /// that the normal points to; with the normal +y, u runs along +x and v along −z (see "plane"). With
    /// `polar`, u is the azimuth, counter-clockwise from the right, and v grows from the rim to the inner radius.
    pub struct DiskDesc as "disk" {
        /// Centre.
        center: DVec3 = DVec3::ZERO;
        /// Normal: the direction perpendicular to the disk, of any length.
        normal: DVec3 = DVec3::Y;
        /// Outer radius.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// Radius of the hole, less than `radius`; 0 is a full disk.
        inner_radius: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Whether (u, v) are azimuth and radius, as in pbrt.
        polar: bool = false;
    }
    example r#"[[object]]
type = "disk"
radius = 2
inner_radius = 1
material = { color = "khaki" }
"#
}

/// A flat disk or ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    center: DVec3,
    normal: DVec3,
    radius: f64,
    inner_radius: f64,
    polar: bool,
}

impl DiskDesc {
    /// Converts it to the form that rays are intersected with.
    pub fn prepare(&self) -> Result<Disk, SceneError> {
        let (radius, inner_radius) = (self.radius, self.inner_radius);
        if inner_radius >= radius {
            let message =
                format!("`inner_radius` ({inner_radius}) of a disk must be less than `radius` ({radius})");
            return Err(SceneError::new(ErrorCode::OutOfRange, message).help("make the hole smaller"));
        }
        let normal = direction(self.normal, "disk", "normal")?;
        Ok(Disk { center: self.center, normal, radius, inner_radius, polar: self.polar })
    }
}

/// Bounding box of a disk.
pub(super) fn disk_bounds(center: DVec3, n: DVec3, radius: f64) -> Bounds {
    // The extent of a disk along axis i is radius · sqrt(1 − n_i²).
    let reach = radius * (DVec3::ONE - n * n).max(DVec3::ZERO).map(f64::sqrt);
    let reach = reach + ROUNDING * (center.abs() + radius);
    Bounds::new(center - reach, center + reach)
}

impl Disk {
    /// Bounding box.
    pub fn bounds(&self) -> Bounds {
        disk_bounds(self.center, self.normal, self.radius)
    }

    /// Centre, two perpendicular radii x and y with y × x along the normal, and inner radius / outer radius.
    pub(crate) fn center_and_radii(&self) -> (DVec3, DVec3, DVec3, f64) {
        let (right, up) = tangents(self.normal);
        (self.center, up * self.radius, right * self.radius, self.inner_radius / self.radius)
    }

    /// The intersection with the plane, if between the two radii.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let t = crossing(ray, self.center, self.normal)?;
        let d2 = ray.at(t).distance_squared(self.center);
        let inside = d2 <= self.radius * self.radius && d2 >= self.inner_radius * self.inner_radius;
        inside.then_some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    /// The surface point at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        flat_point(ray.at(hit.t), self.center, self.normal)
    }

    /// Whether u wraps around.
    pub(super) fn is_polar(&self) -> bool {
        self.polar
    }

    /// (u, v) at a point of the disk.
    pub fn uv(&self, p: DVec3) -> DVec2 {
        let (right, up) = tangents(self.normal);
        let f = (p - self.center) / self.radius;
        if self.polar {
            let (x, y) = (f.dot(right), f.dot(up));
            let v = (1.0 - (x * x + y * y).sqrt()) / (1.0 - self.inner_radius / self.radius);
            return DVec2::new((atan2(y, x) / TAU).rem_euclid(1.0), v.clamp(0.0, 1.0));
        }
        DVec2::new(0.5 * f.dot(right) + 0.5, 0.5 * f.dot(up) + 0.5).clamp(DVec2::ZERO, DVec2::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_have_holes() {
        let desc = DiskDesc { normal: DVec3::Y, radius: 2.0, inner_radius: 1.0, ..DiskDesc::default() };
        let ring = desc.prepare().unwrap();
        let hit = |x: f64| ring.intersect(&Ray::new(DVec3::new(x, 5.0, 0.0), DVec3::NEG_Y)).map(|h| h.t);
        assert_eq!([0.9, 1.0, 1.5, 2.0, 2.1].map(hit), [None, Some(5.0), Some(5.0), Some(5.0), None]);
        assert_eq!(ring.uv(DVec3::new(2.0, 0.0, -1.0)), DVec2::new(1.0, 0.75));
        let polar = DiskDesc { polar: true, ..desc.clone() }.prepare().unwrap();
        // Right is +x and up −z.
        for (p, u, v) in [
            (DVec3::new(2.0, 0.0, 0.0), 0.0, 0.0),
            (DVec3::new(0.0, 0.0, -1.5), 0.25, 0.5),
            (DVec3::new(-1.0, 0.0, 0.0), 0.5, 1.0),
            (DVec3::new(0.0, 0.0, 1.25), 0.75, 0.75),
        ] {
            assert!((polar.uv(p) - DVec2::new(u, v)).length() < 1e-12, "{p}");
        }
        assert!(DiskDesc { inner_radius: 2.0, ..desc.clone() }.prepare().is_err());
        assert!(DiskDesc { normal: DVec3::ZERO, ..desc }.prepare().is_err());
    }
}
