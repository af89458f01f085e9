//! Superellipsoids (Barr 1981, "Superquadrics and Angle-Preserving Transformations").
//!
//! The function (|x|^p + |y|^p)^(q/p) + |z|^q with exponents of at least 1 is convex. So a ray is inside in one
//! interval at most: bisection of the slope finds the lowest point of the function along the ray, or any point inside
//! before, and one root lies on either side of it.

use super::line::Line;
use super::roots::refine;
use super::{PrepareSolid, Solid, SolidGeometry};
use crate::math::elementary::pow;
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, params};
use crate::shape::{MeshCache, ShapeHit, Sphere, SurfacePoint};

params! {
    /// A superellipsoid: a rounded box, cylinder, sphere or octahedron that reaches from −1 to 1 on each axis, with +y as
    /// the north pole. Of its two exponents, 1 is round, towards 0 a square with round corners, and 2 a square that
    /// stands on a corner. (u, v) are those of a sphere.
    pub struct SuperellipsoidDesc as "superellipsoid" {
        /// The east–west exponent: the form of horizontal cross-sections.
        east_west: f64 = 0.4, in Range::closed(0.05, 2.0);
        /// The north–south exponent: the form of the outline seen from the side.
        north_south: f64 = 0.4, in Range::closed(0.05, 2.0);
    }
    example r#"[[object]]
type = "superellipsoid"
east_west = 0.3
north_south = 0.3
material = { color = "mediumseagreen" }
"#
}

/// A superellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Superellipsoid {
    /// The exponent of x and z.
    across: f64,
    /// The exponent of y.
    up: f64,
}

/// Steps of the search for a point inside: each halves the interval.
const STEPS: usize = 60;

impl PrepareSolid for SuperellipsoidDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        Ok(Solid::Superellipsoid(Superellipsoid { across: 2.0 / self.east_west, up: 2.0 / self.north_south }))
    }
}

impl Superellipsoid {
    fn value(&self, p: DVec3) -> f64 {
        let a = p.abs();
        let across = pow(a.x, self.across) + pow(a.z, self.across);
        pow(across, self.up / self.across) + pow(a.y, self.up) - 1.0
    }

    /// The value and its gradient.
    fn at(&self, p: DVec3) -> (f64, DVec3) {
        let a = p.abs();
        let powers = DVec3::new(pow(a.x, self.across), pow(a.y, self.up), pow(a.z, self.across));
        let across = powers.x + powers.z;
        let rounded = pow(across, self.up / self.across);
        // d|x|^p/dx = p |x|^p / x; 0 at 0.
        let part = |v: f64, power: f64| if v == 0.0 { 0.0 } else { power / v };
        let outer = if across > 0.0 { self.up * rounded / across } else { 0.0 };
        let gradient = DVec3::new(
            outer * part(p.x, powers.x),
            self.up * part(p.y, powers.y),
            outer * part(p.z, powers.z),
        );
        (rounded + powers.y - 1.0, gradient)
    }

    /// A point of the line that is inside.
    fn inside(&self, line: &Line) -> Option<f64> {
        let (mut low, mut high) = (line.enter, line.exit);
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            let (value, gradient) = self.at(line.at(middle));
            if value < 0.0 {
                return Some(middle);
            }
            let slope = gradient.dot(line.direction);
            if slope > 0.0 {
                high = middle
            } else {
                low = middle
            }
            // The tangent bounds a convex function from below: nothing is inside if it stays positive.
            let end = if slope > 0.0 { low } else { high };
            if value + slope * (end - middle) > 0.0 || slope == 0.0 {
                return None;
            }
        }
        None
    }
}

impl SolidGeometry for Superellipsoid {
    fn bounds(&self) -> Option<Bounds> {
        Some(Bounds::new(DVec3::splat(-1.0 - 1e-9), DVec3::splat(1.0 + 1e-9)))
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let line = Line::new(ray, &self.bounds()?)?;
        let inside = self.inside(&line)?;
        let along = |s: f64| {
            let (value, gradient) = self.at(line.at(s));
            (value, gradient.dot(line.direction))
        };
        let enter = line.t(refine(line.enter, inside, false, along));
        let hit = |t: f64| ray.contains(t).then_some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 });
        hit(enter).or_else(|| hit(line.t(refine(inside, line.exit, true, along))))
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let mut p = ray.at(hit.t);
        for _ in 0..3 {
            let (value, gradient) = self.at(p);
            let step = value * gradient / gradient.length_squared();
            p -= if step.length_squared() < 1e-4 { step } else { DVec3::ZERO };
        }
        let (_, gradient) = self.at(p);
        let n = gradient.try_normalize().unwrap_or(-ray.direction.normalize());
        let left = self.value(p).abs() / gradient.length().max(1e-6);
        SurfacePoint { p, error: (1e-13 + 4.0 * left).min(1e-6), ng: n, ns: n }
    }

    fn uv(&self, _: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        Sphere::uv(point.p.normalize_or(DVec3::Y))
    }

    fn curvature(&self, _: &ShapeHit) -> f64 {
        1.0
    }

    fn hull_points(&self) -> Vec<DVec3> {
        // Rays from the centre in the directions of a grid on a cube.
        let at = |i: i32| f64::from(i) / 4.0;
        let mut points = Vec::new();
        for (i, j) in (-4..=4).flat_map(|i| (-4..=4).map(move |j| (i, j))) {
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    let mut d = DVec3::ZERO;
                    (d[axis], d[(axis + 1) % 3], d[(axis + 2) % 3]) = (sign, at(i), at(j));
                    points.extend(self.intersect(&Ray::new(DVec3::ZERO, d)).map(|hit| hit.t * d));
                }
            }
        }
        points
    }
}
