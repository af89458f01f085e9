//! How surface coordinates change along a surface, and how it curves.

use super::{Shape, ShapeHit, Sphere, SurfacePoint, TriangleMesh};
use crate::math::{DVec2, DVec3};

impl Shape {
    /// How (u, v) change along two tangent vectors at a point of the surface, in the space of the shape: the derivative times the vectors, so that there is no seam
    /// where the coordinates start again. Finite.
    pub fn uv_change(&self, hit: &ShapeHit, point: &SurfacePoint, along: [DVec3; 2]) -> [DVec2; 2] {
        match self {
            Shape::Mesh(mesh) => mesh.uv_change(hit, 0, along),
            Shape::Rectangle(r) => along.map(|d| sound(r.uv_along(d))),
            Shape::Sphere(_)
            | Shape::Plane(_)
            | Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Points(_) => {
                let size = self.local_size(hit, point);
                let here = self.uv(hit, point);
                along.map(|d| {
                    let length = d.length();
                    if !(length > 0.0 && length < f64::INFINITY) {
                        return DVec2::ZERO;
                    }
                    let step = 1e-5 * size / length;
                    let there = self.uv_beside(hit, point, step * d);
                    let change = there - here;
                    // Steps are small: what is more than half a turn crossed the seam.
                    sound((change - if self.wraps() { change.round() } else { DVec2::ZERO }) / step)
                })
            }
        }
    }

    /// (u, v) beside a point of the surface.
    fn uv_beside(&self, hit: &ShapeHit, point: &SurfacePoint, offset: DVec3) -> DVec2 {
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
            | Shape::Mesh(_) => self.uv(hit, &SurfacePoint { p, ..*point }),
        }
    }

    /// A length over which (u, v) change by about as much as they do in all; steps are taken in proportion.
    fn local_size(&self, hit: &ShapeHit, point: &SurfacePoint) -> f64 {
        match self {
            Shape::Sphere(s) => s.radius.abs(),
            Shape::Points(s) => s.sphere(hit.part).radius,
            Shape::Plane(_) => 1.0 + point.p.abs().max_element(),
            Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Rectangle(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Mesh(_) => self.bounds().map_or(1.0, |b| b.size().max_element()),
        }
    }

    /// Whether (u, v) start again somewhere on the surface.
    fn wraps(&self) -> bool {
        match self {
            Shape::Sphere(_) | Shape::Points(_) | Shape::Cylinder(_) | Shape::Cone(_) | Shape::Torus(_) => {
                true
            }
            Shape::Plane(_) | Shape::Box(_) | Shape::Disk(_) | Shape::Rectangle(_) | Shape::Mesh(_) => false,
        }
    }

    /// How much the normal turns per unit of length along the surface, radians, about: above 0 where the surface bulges outwards. Of triangles, by their vertices' normals.
    pub fn curvature(&self, hit: &ShapeHit) -> f64 {
        match self {
            Shape::Sphere(s) => 1.0 / s.radius.abs().max(1e-30),
            Shape::Points(s) => 1.0 / s.sphere(hit.part).radius.max(1e-30),
            Shape::Plane(_) | Shape::Box(_) | Shape::Disk(_) | Shape::Rectangle(_) => 0.0,
            // Curved one way, flat the other.
            Shape::Cylinder(_) | Shape::Cone(_) if hit.part != 0 => 0.0,
            Shape::Cylinder(c) => 0.5 / c.radius().max(1e-30),
            Shape::Cone(c) => 0.5 / c.mean_radius().max(1e-30),
            Shape::Torus(t) => 0.5 / t.tube_radius().max(1e-30),
            Shape::Mesh(mesh) => mesh.curvature(hit),
        }
    }
}

impl TriangleMesh {
    /// How (u, v) of a set change along two vectors in the plane of the triangle that was hit. Finite.
    pub fn uv_change(&self, hit: &ShapeHit, set: usize, along: [DVec3; 2]) -> [DVec2; 2] {
        let [p, q, r] = self.corner_points(hit.part);
        let [a, b, c] = self.corner_uvs(hit.part, set);
        let weights = Weights::new(q - p, r - p);
        along.map(|d| {
            let (wq, wr) = weights.of(d);
            sound(wq * (b - a) + wr * (c - a))
        })
    }

    /// The mean over the edges of how much the vertices' normals turn along them.
    fn curvature(&self, hit: &ShapeHit) -> f64 {
        let Some(n) = self.corner_normals(hit.part) else { return 0.0 };
        let p = self.corner_points(hit.part);
        let turn = |i: usize, j: usize| {
            let edge = p[j] - p[i];
            let squared = edge.length_squared();
            if squared > 0.0 { (n[j] - n[i]).dot(edge) / squared } else { 0.0 }
        };
        let mean = (turn(0, 1) + turn(1, 2) + turn(2, 0)) / 3.0;
        if mean.is_finite() { mean } else { 0.0 }
    }
}

/// Vectors of a triangle's plane as sums of its edges: the dual basis.
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

/// Coordinates that have no derivative, as at a pole, change fast but finitely.
fn sound(v: DVec2) -> DVec2 {
    let one = |v: f64| if v.is_nan() { 0.0 } else { v.clamp(-1e9, 1e9) };
    DVec2::new(one(v.x), one(v.y))
}
