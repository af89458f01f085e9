//! Infinite planes.

use super::{ROUNDING, ShapeHit, SurfacePoint, direction};
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{SceneError, params};

params! {
    /// An infinite plane. (u, v) are unbounded: 2u − 1 and 2v − 1 are the distances from `point` in scene
    /// units. u runs to the right and v up, as seen from the side that the normal points to, with +y up. On a
    /// horizontal plane u runs along +x; with the normal +y, 2u − 1 = x − point.x and 2v − 1 = point.z − z.
    pub struct PlaneDesc as "plane" {
        /// A point on the plane.
        point: DVec3 = DVec3::ZERO;
        /// Normal: the direction perpendicular to the plane, of any length.
        normal: DVec3 = DVec3::Y;
    }
    example r#"[[object]]
type = "plane"
point = [0, -1, 0]
normal = [0, 1, 0]
material = { color = "ivory" }
"#
}

/// An infinite plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point on it.
    pub point: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

impl PlaneDesc {
    /// Converts it to the form that rays are intersected with.
    pub fn prepare(&self) -> Result<Plane, SceneError> {
        Ok(Plane { point: self.point, normal: direction(self.normal, "plane", "normal")? })
    }
}

/// Two unit tangents (right, up) of the unit normal `n`, with right × up = n. As seen from the side `n` points
/// to, with +y up, `right` is horizontal and `up` points upwards. Where `n` is vertical they are +x and n × x.
pub(super) fn tangents(n: DVec3) -> (DVec3, DVec3) {
    let right = DVec3::new(n.z, 0.0, -n.x);
    let length = right.length();
    let right = if length > 1e-9 { right / length } else { DVec3::X };
    // If n is vertical only to within rounding, X is not exactly perpendicular to it.
    let right = (right - right.dot(n) * n).normalize();
    (right, n.cross(right))
}

/// The t at which a ray crosses the plane through `point` with unit normal `n`, if in the ray's range.
#[inline]
pub(super) fn crossing(ray: &Ray, point: DVec3, n: DVec3) -> Option<f64> {
    let speed = ray.direction.dot(n);
    let t = (point - ray.origin).dot(n) / speed;
    // A ray parallel to the plane divides by 0; a ray with an infinite direction would give t = 0.
    (ray.contains(t) && speed.abs() < f64::INFINITY).then_some(t)
}

/// The surface point of a flat shape: `p` projected onto the plane along its normal.
#[inline]
pub(super) fn flat_point(p: DVec3, point: DVec3, n: DVec3) -> SurfacePoint {
    let p = p - (p - point).dot(n) * n;
    let error = ROUNDING * (p.abs().max_element() + point.abs().max_element());
    SurfacePoint { p, error, ng: n, ns: n }
}

impl Plane {
    /// The intersection, if in range.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let t = crossing(ray, self.point, self.normal)?;
        // Beyond the range of f64 there is no point to shade.
        ray.at(t).is_finite().then_some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    /// A point of it, and its normal.
    #[inline]
    pub(crate) fn place(&self) -> (DVec3, DVec3) {
        (self.point, self.normal)
    }

    /// The surface point at a hit.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        flat_point(ray.at(hit.t), self.point, self.normal)
    }

    /// Whether a ray ends on the side that the normal points away from.
    pub(super) fn contains_far_end(&self, ray: &Ray) -> bool {
        let along = ray.direction.dot(self.normal);
        along < 0.0 || (along == 0.0 && (ray.origin - self.point).dot(self.normal) < 0.0)
    }

    /// (u, v) at a point of the plane.
    pub fn uv(&self, p: DVec3) -> DVec2 {
        let (right, up) = tangents(self.normal);
        let f = p - self.point;
        DVec2::new(0.5 * f.dot(right) + 0.5, 0.5 * f.dot(up) + 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangents_follow_the_documented_directions() {
        assert_eq!(tangents(DVec3::Y), (DVec3::X, DVec3::NEG_Z));
        assert_eq!(tangents(DVec3::NEG_Y), (DVec3::X, DVec3::Z));
        assert_eq!(tangents(DVec3::Z), (DVec3::X, DVec3::Y));
        assert_eq!(tangents(DVec3::X), (DVec3::NEG_Z, DVec3::Y));
        for n in [DVec3::new(1.0, 2.0, -3.0), DVec3::new(1e-10, 1.0, 0.0), DVec3::new(1e-8, -1.0, 1e-9)] {
            let n = n.normalize();
            let (a, b) = tangents(n);
            assert!((a.cross(b) - n).length() < 1e-15 && a.dot(n).abs() < 1e-15, "{n}");
        }
    }

    #[test]
    fn coordinates_are_distances() {
        let plane = PlaneDesc { point: DVec3::new(1.0, 2.0, 3.0), normal: DVec3::Y * 7.0 }.prepare().unwrap();
        let uv = plane.uv(DVec3::new(5.0, 2.0, 1.0));
        assert_eq!((2.0 * uv.x - 1.0, 2.0 * uv.y - 1.0), (4.0, 2.0));
    }

    #[test]
    fn crossings() {
        let plane = PlaneDesc { point: DVec3::ZERO, normal: DVec3::Y }.prepare().unwrap();
        let hit = |o: [f64; 3], d: [f64; 3]| plane.intersect(&Ray::new(o.into(), d.into())).map(|h| h.t);
        assert_eq!(hit([0.0, 3.0, 0.0], [0.0, -2.0, 0.0]), Some(1.5));
        assert_eq!(hit([0.0, -3.0, 0.0], [1.0, 2.0, 0.0]), Some(1.5));
        assert_eq!(hit([0.0, 3.0, 0.0], [0.0, 2.0, 0.0]), None);
        assert_eq!(hit([0.0, 3.0, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([0.0, 3.0, 0.0], [0.0, f64::NEG_INFINITY, 0.0]), None);
        assert!(PlaneDesc { point: DVec3::ZERO, normal: DVec3::ZERO }.prepare().is_err());
    }
}
