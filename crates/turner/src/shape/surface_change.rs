//! Derivatives of surface coordinates along a surface, and its curvature.

use super::solid::SolidGeometry;
use super::{Shape, ShapeHit, Sphere, SurfacePoint, TriangleMesh};
use crate::math::{DVec2, DVec3};

impl Shape {
    /// Directional derivatives of (u, v) along two tangent vectors at a surface point, in the shape's space.
    /// Where (u, v) wrap around there is no jump. Finite.
    pub fn uv_change(&self, hit: &ShapeHit, point: &SurfacePoint, along: [DVec3; 2]) -> [DVec2; 2] {
        match self {
            Shape::Mesh(mesh) => mesh.uv_change(hit, 0, along),
            Shape::Rectangle(r) => along.map(|d| finite_or_zero(r.uv_along(d))),
            Shape::Curves(c) => along.map(|d| finite_or_zero(c.uv_along(hit, point.ng, d))),
            Shape::Sphere(_)
            | Shape::Plane(_)
            | Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Points(_)
            | Shape::Solid(_) => {
                let size = self.local_size(hit, point);
                let here = self.uv(hit, point);
                along.map(|d| {
                    let length = d.length();
                    if !(length > 0.0 && length < f64::INFINITY) {
                        return DVec2::ZERO;
                    }
                    let step = 1e-5 * size / length;
                    let there = self.uv_at_offset(hit, point, step * d);
                    let change = there - here;
                    // The step is small: a change of more than one half crossed the seam.
                    finite_or_zero((change - if self.wraps() { change.round() } else { DVec2::ZERO }) / step)
                })
            }
        }
    }

    /// (u, v) at a point offset from a surface point.
    fn uv_at_offset(&self, hit: &ShapeHit, point: &SurfacePoint, offset: DVec3) -> DVec2 {
        let p = point.p + offset;
        match self {
            Shape::Sphere(s) => Sphere::uv((p - s.center).normalize_or(point.ng)),
            Shape::Points(s) => Sphere::uv((p - s.sphere(hit.part).center).normalize_or(point.ng)),
            Shape::Plane(_)
            | Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Rectangle(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Mesh(_)
            | Shape::Curves(_)
            | Shape::Solid(_) => self.uv(hit, &SurfacePoint { p, ..*point }),
        }
    }

    /// A length over which (u, v) change by about their full range; finite-difference steps are in proportion
    /// to it.
    fn local_size(&self, hit: &ShapeHit, point: &SurfacePoint) -> f64 {
        match self {
            Shape::Sphere(s) => s.radius.abs(),
            Shape::Points(s) => s.sphere(hit.part).radius,
            Shape::Curves(s) => s.radius(hit),
            Shape::Plane(_) => 1.0 + point.p.abs().max_element(),
            Shape::Solid(s) => match s.bounds() {
                Some(bounds) => bounds.size().max_element(),
                None => 1.0 + point.p.abs().max_element(),
            },
            Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Rectangle(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Mesh(_) => self.bounds().map_or(1.0, |b| b.size().max_element()),
        }
    }

    /// Whether (u, v) wrap around on the surface.
    fn wraps(&self) -> bool {
        match self {
            Shape::Sphere(_) | Shape::Points(_) | Shape::Cylinder(_) | Shape::Cone(_) | Shape::Torus(_) => {
                true
            }
            Shape::Disk(d) => d.is_polar(),
            Shape::Plane(_) | Shape::Box(_) | Shape::Rectangle(_) | Shape::Mesh(_) | Shape::Curves(_) => {
                false
            }
            Shape::Solid(s) => s.wraps(),
        }
    }

    /// Approximate change of the normal per unit of length along the surface, in radians; positive where the
    /// surface is convex. For triangles it comes from the vertex normals.
    pub fn curvature(&self, hit: &ShapeHit) -> f64 {
        match self {
            Shape::Sphere(s) => 1.0 / s.radius.abs().max(1e-30),
            Shape::Points(s) => 1.0 / s.sphere(hit.part).radius.max(1e-30),
            Shape::Plane(_) | Shape::Box(_) | Shape::Disk(_) | Shape::Rectangle(_) => 0.0,
            // Curved in one direction, flat in the other: the mean.
            Shape::Cylinder(_) | Shape::Cone(_) if hit.part != 0 => 0.0,
            Shape::Cylinder(c) => 0.5 / c.radius().max(1e-30),
            Shape::Cone(c) => 0.5 / c.mean_radius().max(1e-30),
            Shape::Torus(t) => 0.5 / t.tube_radius().max(1e-30),
            Shape::Curves(c) => 0.5 / c.radius(hit).max(1e-30),
            Shape::Mesh(mesh) => mesh.curvature(hit),
            Shape::Solid(s) => s.curvature(hit),
        }
    }
}

impl TriangleMesh {
    /// Directional derivatives of (u, v) of a set along two vectors in the plane of the triangle that was hit.
    /// Finite.
    pub fn uv_change(&self, hit: &ShapeHit, set: usize, along: [DVec3; 2]) -> [DVec2; 2] {
        let [p, q, r] = self.corner_points(hit.part);
        let [a, b, c] = self.corner_uvs(hit.part, set);
        let weights = Weights::new(q - p, r - p);
        along.map(|d| {
            let (wq, wr) = weights.of(d);
            finite_or_zero(wq * (b - a) + wr * (c - a))
        })
    }

    /// The mean over the edges of the change of the vertex normals along the edge.
    fn curvature(&self, hit: &ShapeHit) -> f64 {
        let Some(n) = self.corner_normals(hit.part) else { return 0.0 };
        let p = self.corner_points(hit.part);
        let normal_change = |i: usize, j: usize| {
            let edge = p[j] - p[i];
            let squared = edge.length_squared();
            if squared > 0.0 { (n[j] - n[i]).dot(edge) / squared } else { 0.0 }
        };
        let mean = (normal_change(0, 1) + normal_change(1, 2) + normal_change(2, 0)) / 3.0;
        if mean.is_finite() { mean } else { 0.0 }
    }
}

/// Expresses vectors in a triangle's plane as sums of its edges: the dual basis.
struct Weights {
    q: DVec3,
    r: DVec3,
}

impl Weights {
    fn new(q: DVec3, r: DVec3) -> Weights {
        let n = q.cross(r);
        let squared = n.length_squared();
        let inverse = if squared > 0.0 { 1.0 / squared } else { 0.0 };
        Weights { q: r.cross(n) * inverse, r: n.cross(q) * inverse }
    }

    fn of(&self, d: DVec3) -> (f64, f64) {
        (self.q.dot(d), self.r.dot(d))
    }
}

/// Makes a derivative finite, where it does not exist (at a pole): NaN becomes 0, large values are clamped.
fn finite_or_zero(v: DVec2) -> DVec2 {
    let one = |v: f64| if v.is_nan() { 0.0 } else { v.clamp(-1e9, 1e9) };
    DVec2::new(one(v.x), one(v.y))
}
