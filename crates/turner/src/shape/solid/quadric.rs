//! Quadrics: surfaces of second degree.

use super::{PrepareSolid, Solid, SolidGeometry};
use crate::math::{Bounds, DMat3, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, SceneError, params};
use crate::shape::{MeshCache, ROUNDING, ShapeHit, Sphere, SurfacePoint};

params! {
    /// A quadric: all points with squared·[x², y², z²] + products·[xy, xz, yz] + linear·[x, y, z] + constant = 0.
    /// Paraboloids, hyperboloids, cones and cylinders without ends, ellipsoids. The inside is where the sum is
    /// negative. Quadrics may be unbounded: cut them with `intersection` or `clipped`. (u, v) are those of a sphere
    /// around the origin.
    pub struct QuadricDesc as "quadric" {
        /// Factors of x², y² and z².
        squared: DVec3 = DVec3::ONE;
        /// Factors of xy, xz and yz.
        products: DVec3 = DVec3::ZERO;
        /// Factors of x, y and z.
        linear: DVec3 = DVec3::ZERO;
        /// The number without a factor.
        constant: f64 = -1.0;
    }
    example r#"[[object]]
type = "clipped"
material = { color = "goldenrod" }

# A hyperboloid of one sheet, cut off at y = -1 and y = 1.
[[object.parts]]
type = "quadric"
squared = [1, -1, 1]
constant = -0.25

[[object.parts]]
type = "box"
size = [4, 2, 4]
"#
}

/// A quadric: p·(M p) + linear·p + constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadric {
    matrix: DMat3,
    linear: DVec3,
    constant: f64,
}

impl PrepareSolid for QuadricDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        let (s, p) = (self.squared, 0.5 * self.products);
        let matrix =
            DMat3::from_cols(DVec3::new(s.x, p.x, p.y), DVec3::new(p.x, s.y, p.z), DVec3::new(p.y, p.z, s.z));
        if s == DVec3::ZERO && p == DVec3::ZERO && self.linear == DVec3::ZERO {
            let message = "a quadric without x, y and z is no surface";
            return Err(
                SceneError::new(ErrorCode::OutOfRange, message).help("for example `squared = [1, 1, 1]`")
            );
        }
        Ok(Solid::Quadric(Quadric { matrix, linear: self.linear, constant: self.constant }))
    }
}

impl Quadric {
    /// The value at a point, its gradient, and the sum of the magnitudes of its terms.
    fn at(&self, p: DVec3) -> (f64, DVec3, f64) {
        let m = self.matrix * p;
        let value = p.dot(m) + self.linear.dot(p) + self.constant;
        let terms = p.abs().dot(m.abs()) + self.linear.abs().dot(p.abs()) + self.constant.abs();
        (value, 2.0 * m + self.linear, terms)
    }

    /// The coefficients a, b, c of a t² + 2 b t + c along a ray, with t from the point nearest to the origin.
    fn along(&self, ray: &Ray) -> Option<(f64, [f64; 3])> {
        let start = -ray.origin.dot(ray.direction) / ray.direction.length_squared();
        if !(ray.is_finite() && start.is_finite()) {
            return None;
        }
        let (o, d) = (ray.at(start), ray.direction);
        let m = self.matrix * d;
        Some((start, [d.dot(m), o.dot(m) + 0.5 * self.linear.dot(d), self.at(o).0]))
    }
}

impl SolidGeometry for Quadric {
    fn bounds(&self) -> Option<Bounds> {
        // An ellipsoid with its axes along x, y and z is the one that is common and bounded.
        let m = self.matrix;
        let s = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
        let diagonal = m == DMat3::from_diagonal(s);
        let sign = s.x.signum();
        if !(diagonal && (s * sign).cmpgt(DVec3::ZERO).all() && sign > 0.0) {
            return None;
        }
        let center = -0.5 * self.linear / s;
        let level = center.dot(s * center) - self.constant;
        if level < 0.0 {
            return Some(Bounds::EMPTY);
        }
        let reach = (level / s).map(f64::sqrt) * (1.0 + 1e-9) + ROUNDING * center.abs();
        Some(Bounds::new(center - reach, center + reach))
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (start, [a, b, c]) = self.along(ray)?;
        let discriminant = b * b - a * c;
        if !(discriminant >= 0.0) {
            return None;
        }
        let q = -b - discriminant.sqrt().copysign(b);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        // A linear equation has one root: the other is infinite.
        let (near, far) = if t1 < t0 { (t1, t0) } else { (t0, t1) };
        let t = [near, far].map(|t| t + start).into_iter().find(|t| ray.contains(*t))?;
        ray.at(t).is_finite().then_some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let mut p = ray.at(hit.t);
        for _ in 0..2 {
            let (value, gradient, _) = self.at(p);
            let step = value * gradient / gradient.length_squared();
            p -= if step.is_finite() { step } else { DVec3::ZERO };
        }
        let (_, gradient, terms) = self.at(p);
        let n = gradient.try_normalize().unwrap_or(-ray.direction.normalize());
        let error = ROUNDING * (p.abs().max_element() + terms / gradient.length().max(1e-300));
        SurfacePoint { p, error, ng: n, ns: n }
    }

    fn uv(&self, _: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        Sphere::uv(point.p.normalize_or(DVec3::Y))
    }

    fn curvature(&self, _: &ShapeHit) -> f64 {
        self.bounds().filter(|b| !b.is_empty()).map_or(0.0, |b| 2.0 / b.size().max_element())
    }

    fn contains_far_end(&self, ray: &Ray) -> bool {
        let Some((_, [a, b, c])) = self.along(ray) else { return false };
        let sign = |v: f64| if v == 0.0 { None } else { Some(v < 0.0) };
        sign(a).or(sign(b)).unwrap_or(c < 0.0)
    }
}
