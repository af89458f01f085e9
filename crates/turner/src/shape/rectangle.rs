//! Rectangles and parallelograms.

use super::plane::{crossing, flat_point};
use super::{ROUNDING, ShapeHit, SurfacePoint};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, SceneError, params};

params! {
    /// A flat rectangle, or a parallelogram if the edges are not perpendicular. u runs from 0 to 1 along
    /// `edge_u` and v along `edge_v`; the centre is (0.5, 0.5). The normal is edge_u × edge_v: seen from its
    /// side, `edge_v` is counter-clockwise from `edge_u`.
    pub struct RectangleDesc as "rectangle" {
        /// Centre.
        center: DVec3 = DVec3::ZERO;
        /// One edge, as a vector from corner to corner.
        edge_u: DVec3 = DVec3::new(2.0, 0.0, 0.0);
        /// The other edge.
        edge_v: DVec3 = DVec3::new(0.0, 2.0, 0.0);
    }
    example r#"[[object]]
type = "rectangle"
center = [0, 1, -2]
edge_u = [4, 0, 0]
edge_v = [0, 2, 0]
material = { color = "skyblue" }
"#
}

/// A parallelogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    pub(crate) center: DVec3,
    edge_u: DVec3,
    edge_v: DVec3,
    pub(crate) normal: DVec3,
    /// Vectors in the plane whose dot product with an offset from the centre gives u − 0.5 and v − 0.5.
    pub(crate) to_u: DVec3,
    pub(crate) to_v: DVec3,
}

impl RectangleDesc {
    /// Converts it to the form that rays are intersected with.
    pub fn prepare(&self) -> Result<Rectangle, SceneError> {
        let (u, v) = (self.edge_u, self.edge_v);
        let degenerate = || {
            let message = "the edges of a rectangle must not be zero, parallel or too large";
            SceneError::new(ErrorCode::OutOfRange, message).help("give two edges that span an area")
        };
        let (nu, nv) = (u.try_normalize(), v.try_normalize());
        let (Some(nu), Some(nv)) = (nu, nv) else { return Err(degenerate()) };
        let cross = nu.cross(nv);
        if !(cross.length() > 1e-9) {
            return Err(degenerate());
        }
        let normal = cross.normalize();
        let (to_u, to_v) = (v.cross(normal), normal.cross(u));
        let (to_u, to_v) = (to_u / to_u.dot(u), to_v / to_v.dot(v));
        if !(to_u.is_finite() && to_v.is_finite()) {
            return Err(degenerate());
        }
        Ok(Rectangle { center: self.center, edge_u: u, edge_v: v, normal, to_u, to_v })
    }
}

impl Rectangle {
    /// Bounding box.
    pub fn bounds(&self) -> Bounds {
        let reach = 0.5 * (self.edge_u.abs() + self.edge_v.abs());
        let reach = reach + ROUNDING * (reach.max_element() + self.center.abs().max_element());
        Bounds::new(self.center - reach, self.center + reach)
    }

    /// The corner with u = v = 0, and the edges; the normal is along edge_u × edge_v, unless the rectangle is turned over.
    pub(crate) fn corner_and_edges(&self) -> (DVec3, DVec3, DVec3) {
        (self.center - 0.5 * (self.edge_u + self.edge_v), self.edge_u, self.edge_v)
    }

    /// The same with the opposite normal.
    pub(super) fn turned_over(self) -> Rectangle {
        Rectangle { normal: -self.normal, ..self }
    }

    /// The intersection with the plane, if between the edges.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let t = crossing(ray, self.center, self.normal)?;
        let f = ray.at(t) - self.center;
        let (u, v) = (f.dot(self.to_u), f.dot(self.to_v));
        (u.abs() <= 0.5 && v.abs() <= 0.5).then_some(ShapeHit { t, part: 0, u: u + 0.5, v: v + 0.5 })
    }

    /// A point of it, and its normal.
    #[inline]
    pub(crate) fn place(&self) -> (DVec3, DVec3) {
        (self.center, self.normal)
    }

    /// The surface point at a hit.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        flat_point(ray.at(hit.t), self.center, self.normal)
    }

    /// The derivative of (u, v) along a vector in its plane.
    pub(super) fn uv_along(&self, d: DVec3) -> DVec2 {
        DVec2::new(d.dot(self.to_u), d.dot(self.to_v))
    }

    /// (u, v) of a hit.
    pub fn uv(&self, hit: &ShapeHit) -> DVec2 {
        DVec2::new(hit.u, hit.v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_belong_and_uv_follows_them() {
        let desc =
            RectangleDesc { center: DVec3::ZERO, edge_u: DVec3::X * 4.0, edge_v: DVec3::new(1.0, 2.0, 0.0) };
        let r = desc.prepare().unwrap();
        let hit =
            |x: f64, y: f64| r.intersect(&Ray::new(DVec3::new(x, y, 1.0), DVec3::NEG_Z)).map(|h| r.uv(&h));
        assert_eq!(hit(0.0, 0.0), Some(DVec2::splat(0.5)));
        assert_eq!(hit(2.0, 0.0), Some(DVec2::new(1.0, 0.5)));
        assert_eq!(hit(-2.5, -1.0), Some(DVec2::new(0.0, 0.0)));
        assert_eq!(hit(2.001, 0.0), None);
        assert_eq!(hit(-2.5, 1.0), None);
        assert_eq!(r.normal, DVec3::Z);
        assert!(RectangleDesc { edge_v: DVec3::X * -3.0, ..desc.clone() }.prepare().is_err());
        assert!(RectangleDesc { edge_v: DVec3::ZERO, ..desc.clone() }.prepare().is_err());
        assert!(RectangleDesc { edge_v: DVec3::Y * 1e300, ..desc }.prepare().is_err());
    }
}
