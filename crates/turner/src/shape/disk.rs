//! Flat disks and rings.

use super::plane::{crossing, flat_point, tangents};
use super::{ROUNDING, ShapeHit, SurfacePoint, direction};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// A flat disk, or a ring with an inner radius. (u, v) is a square around it: 2u − 1 and 2v − 1 are distances from the
    /// middle over the radius, to the right and up as seen from the side the normal points to (see plane: with the normal
    /// +y, u runs along +x and v along −z).
    pub struct DiskDesc as "disk" {
        /// The middle.
        center: DVec3 = DVec3::ZERO;
        /// The direction at right angles to it; its length does not matter.
        normal: DVec3 = DVec3::Y;
        /// The radius.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// The radius of the hole in the middle, less than `radius`.
        inner_radius: f64 = 0.0, in Range::NON_NEGATIVE;
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
}

impl DiskDesc {
    /// Makes it traceable.
    pub fn prepare(&self) -> Result<Disk, SceneError> {
        let (radius, inner_radius) = (self.radius, self.inner_radius);
        if inner_radius >= radius {
            let message =
                format!("`inner_radius` ({inner_radius}) of a disk must be less than `radius` ({radius})");
            return Err(SceneError::new(ErrorCode::OutOfRange, message).help("make the hole smaller"));
        }
        let normal = direction(self.normal, "disk", "normal")?;
        Ok(Disk { center: self.center, normal, radius, inner_radius })
    }
}

/// The box around a disk.
pub(super) fn disk_bounds(center: DVec3, n: DVec3, radius: f64) -> Bounds {
    // Along an axis a disk reaches as far as the axis lies in its plane: sqrt(1 - n_i^2).
    let reach = radius * (DVec3::ONE - n * n).max(DVec3::ZERO).map(f64::sqrt);
    let reach = reach + ROUNDING * (center.abs() + radius);
    Bounds::new(center - reach, center + reach)
}

impl Disk {
    /// The box around it.
    pub fn bounds(&self) -> Bounds {
        disk_bounds(self.center, self.normal, self.radius)
    }

    /// The middle, two radii x and y at right angles with y × x along the normal, and the hole's radius over that of the rim.
    pub(crate) fn center_and_radii(&self) -> (DVec3, DVec3, DVec3, f64) {
        let (right, up) = tangents(self.normal);
        (self.center, up * self.radius, right * self.radius, self.inner_radius / self.radius)
    }

    /// The crossing with its plane, if between the radii.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let t = crossing(ray, self.center, self.normal)?;
        let d2 = ray.at(t).distance_squared(self.center);
        let inside = d2 <= self.radius * self.radius && d2 >= self.inner_radius * self.inner_radius;
        inside.then_some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    /// The surface at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        flat_point(ray.at(hit.t), self.center, self.normal)
    }

    /// (u, v) at a point of the disk.
    pub fn uv(&self, p: DVec3) -> DVec2 {
        let (right, up) = tangents(self.normal);
        let f = (p - self.center) / self.radius;
        DVec2::new(0.5 * f.dot(right) + 0.5, 0.5 * f.dot(up) + 0.5).clamp(DVec2::ZERO, DVec2::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_have_holes() {
        let desc = DiskDesc { center: DVec3::ZERO, normal: DVec3::Y, radius: 2.0, inner_radius: 1.0 };
        let ring = desc.prepare().unwrap();
        let hit = |x: f64| ring.intersect(&Ray::new(DVec3::new(x, 5.0, 0.0), DVec3::NEG_Y)).map(|h| h.t);
        assert_eq!([0.9, 1.0, 1.5, 2.0, 2.1].map(hit), [None, Some(5.0), Some(5.0), Some(5.0), None]);
        assert_eq!(ring.uv(DVec3::new(2.0, 0.0, -1.0)), DVec2::new(1.0, 0.75));
        assert!(DiskDesc { inner_radius: 2.0, ..desc.clone() }.prepare().is_err());
        assert!(DiskDesc { normal: DVec3::ZERO, ..desc }.prepare().is_err());
    }
}
