//! Shapes: what rays hit. One file each; [`ShapeDesc`] is the table of their names in a scene.
//!
//! A shape lives in its own space (objects may be transformed). Conventions: `ng` is the geometric normal, unit
//! length, pointing out of closed shapes; (u, v) covers 0..1 by a mapping written at each shape; the paper's
//! (−1..1) coordinates are 2u − 1, 2v − 1.

pub mod mesh;
mod sphere;
mod traversal;

pub use sphere::{Sphere, SphereDesc};
pub use traversal::TraversalFrame;

use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::scene::SceneError;
use crate::scene::schema::family;

family! {
    /// Shapes: the `type` of an `[[object]]`.
    pub enum ShapeDesc as "shape", "shapes" {
        Sphere(SphereDesc),
    }
}

/// A hit of a ray with a shape: all that traversal carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// Parameter along the ray.
    pub t: f64,
    /// Which part was hit: a face of a box, the cap or side of a cylinder, a triangle.
    pub part: u32,
    /// First coordinate within the part, if the shape wants to keep it (barycentric for triangles).
    pub u: f64,
    /// Second coordinate within the part.
    pub v: f64,
}

/// The surface at a hit, in the shape's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point, moved onto the surface as exactly as the shape can.
    pub p: DVec3,
    /// Bound on the distance of `p` from the true surface.
    pub error: f64,
    /// Geometric normal, unit, outward.
    pub ng: DVec3,
    /// Shading normal, unit, on the same side as `ng`.
    pub ns: DVec3,
}

/// A shape ready to be traced.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
}

impl Shape {
    /// The box around it; `None` if it is unbounded.
    pub fn bounds(&self) -> Option<Bounds> {
        match self {
            Shape::Sphere(s) => Some(s.bounds()),
        }
    }

    /// The nearest hit with `t_min <= t <= t_max`, from outside or inside. Rays with NaN hit nothing.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        match self {
            Shape::Sphere(s) => s.intersect(ray),
        }
    }

    /// Whether anything is hit with `t_min <= t <= t_max`.
    #[inline]
    pub fn occludes(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }

    /// The surface at a hit of `ray`.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        match self {
            Shape::Sphere(s) => s.surface(ray, hit),
        }
    }

    /// Surface coordinates at a point of the surface, 0..1 for bounded shapes. Asked for by textures alone: they
    /// may cost an arc tangent.
    pub fn uv(&self, hit: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        match self {
            Shape::Sphere(_) => Sphere::uv(point.ng),
        }
    }

    /// Bytes it takes beside its place in the scene's list.
    pub fn memory(&self) -> usize {
        0
    }
}

impl ShapeDesc {
    /// Makes it traceable; checks what the reader could not. `meshes` are the scene's, by `MeshId`.
    pub fn prepare(&self) -> Result<Shape, SceneError> {
        match self {
            ShapeDesc::Sphere(d) => Ok(Shape::Sphere(Sphere { center: d.center, radius: d.radius })),
        }
    }
}
