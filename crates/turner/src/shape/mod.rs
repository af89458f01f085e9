//! Shapes: what rays hit. One file each; [`ShapeDesc`] is the table of their names in a scene.
//!
//! The contract, which every [`Shape`] keeps:
//!
//! - All is in the shape's own space and in its units; an object's transform moves rays into it and surfaces out of it.
//! - [`Shape::bounds`] holds the whole shape, and may be larger. `None` is an unbounded shape.
//! - [`Shape::intersect`] is given a ray whose direction may have any length but 0; t counts in lengths of it. It finds the nearest t with
//!   t_min <= t <= t_max, both ends included, from outside and from inside. `None` is a miss: so are rays that are not finite.
//! - [`Shape::occludes`] says whether `intersect` would find anything; it may stop at the first hit.
//! - [`Shape::surface`] is given the ray and a hit of it, and computes what is needed once, for the nearest hit. The point is moved onto the surface;
//!   `error` bounds what is left of its distance from there, so that rays that start farther off do not meet the surface they leave.
//! - The geometric normal `ng` is of unit length. It points out of closed shapes, and of open ones to the side that the shape's text names, never
//!   towards the ray. The shading normal `ns` is unit too, on the same side.
//! - [`Shape::uv`] covers 0..1 on bounded shapes by the mapping written at each; the paper's (−1..1) coordinates are 2u − 1, 2v − 1. Only
//!   textures ask for it.

// `!(a <= b)` is meant: it turns away NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod cone;
mod cuboid;
mod cylinder;
mod disk;
pub(crate) mod extent;
mod joined_mesh;
pub mod mesh;
mod mesh_cache;
mod mesh_rays;
mod mesh_search;
mod outline;
mod plane;
pub mod points;
mod rectangle;
mod sphere;
mod surface_change;
#[cfg(test)]
pub(crate) mod testing;
mod torus;
pub mod traversal;
pub mod triangle;
mod triangle_mesh;
mod triangle_x8;

pub use cone::{Cone, ConeDesc};
pub use cuboid::{BoxDesc, Cuboid};
pub use cylinder::{Cylinder, CylinderDesc};
pub use disk::{Disk, DiskDesc};
pub use mesh::MeshDesc;
pub use mesh_cache::{CachedShapes, MeshCache};
pub use mesh_rays::{BlockRays, MeshRays, NO_TRIANGLE};
pub use plane::{Plane, PlaneDesc};
pub use points::{Points, PointsDesc};
pub use rectangle::{Rectangle, RectangleDesc};
pub use sphere::{Sphere, SphereDesc};
pub use torus::{Torus, TorusDesc};
pub use triangle_mesh::{SkippedTriangles, TriangleMesh};

use std::sync::Arc;

use crate::math::elementary::{atan2, sin_cos};
use crate::math::{Bounds, DVec2, DVec3, Frame, Ray};
use crate::schema::{ErrorCode, SceneError, family};

family! {
    /// Shapes: the `type` of an `[[object]]`.
    pub enum ShapeDesc as "shape", "shapes" {
        Sphere(SphereDesc),
        Plane(PlaneDesc),
        Box(BoxDesc),
        Disk(DiskDesc),
        Rectangle(RectangleDesc),
        Cylinder(CylinderDesc),
        Cone(ConeDesc),
        Torus(TorusDesc),
        Mesh(MeshDesc),
        Points(PointsDesc),
    }
}

/// Bound on the distance of a surface point from the surface, per unit of the largest coordinate or length that
/// went into it: eighteen roundings. It is generous on purpose: a ray that starts that far outside must not be
/// taken for one that starts inside, after further roundings.
pub(crate) const ROUNDING: f64 = 4e-15;

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

/// A shape ready to be traced. 56 bytes: the common ones by value, larger ones behind a pointer.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// An infinite plane.
    Plane(Plane),
    /// An axis-aligned box.
    Box(Cuboid),
    /// A disk or ring.
    Disk(Box<Disk>),
    /// A rectangle or parallelogram.
    Rectangle(Box<Rectangle>),
    /// A cylinder.
    Cylinder(Box<Cylinder>),
    /// A cone.
    Cone(Box<Cone>),
    /// A torus.
    Torus(Box<Torus>),
    /// A triangle mesh, shared by the objects that show it.
    Mesh(Arc<TriangleMesh>),
    /// A cloud of points, shared by the objects that show it.
    Points(Arc<Points>),
}

const _: () = assert!(size_of::<Shape>() <= 56);

impl Shape {
    /// Its name in a scene.
    pub fn word(&self) -> &'static str {
        match self {
            Shape::Sphere(_) => SphereDesc::DOC.name,
            Shape::Plane(_) => PlaneDesc::DOC.name,
            Shape::Box(_) => BoxDesc::DOC.name,
            Shape::Disk(_) => DiskDesc::DOC.name,
            Shape::Rectangle(_) => RectangleDesc::DOC.name,
            Shape::Cylinder(_) => CylinderDesc::DOC.name,
            Shape::Cone(_) => ConeDesc::DOC.name,
            Shape::Torus(_) => TorusDesc::DOC.name,
            Shape::Mesh(_) => MeshDesc::DOC.name,
            Shape::Points(_) => PointsDesc::DOC.name,
        }
    }

    /// The box around it; `None` if it is unbounded. Empty for a mesh without triangles, or a cloud without points.
    pub fn bounds(&self) -> Option<Bounds> {
        match self {
            Shape::Sphere(s) => Some(s.bounds()),
            Shape::Plane(_) => None,
            Shape::Box(s) => Some(s.bounds()),
            Shape::Disk(s) => Some(s.bounds()),
            Shape::Rectangle(s) => Some(s.bounds()),
            Shape::Cylinder(s) => Some(s.bounds()),
            Shape::Cone(s) => Some(s.bounds()),
            Shape::Torus(s) => Some(s.bounds()),
            Shape::Mesh(s) => Some(s.bounds()),
            Shape::Points(s) => Some(s.bounds()),
        }
    }

    /// The nearest hit with `t_min <= t <= t_max`, from outside or inside. Rays with NaN or infinities, or without
    /// a direction, hit nothing.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        match self {
            Shape::Sphere(s) => s.intersect(ray),
            Shape::Plane(s) => s.intersect(ray),
            Shape::Box(s) => s.intersect(ray),
            Shape::Disk(s) => s.intersect(ray),
            Shape::Rectangle(s) => s.intersect(ray),
            Shape::Cylinder(s) => s.intersect(ray),
            Shape::Cone(s) => s.intersect(ray),
            Shape::Torus(s) => s.intersect(ray),
            Shape::Mesh(s) => s.intersect(ray),
            Shape::Points(s) => s.intersect(ray),
        }
    }

    /// Whether anything is hit with `t_min <= t <= t_max`.
    #[inline]
    pub fn occludes(&self, ray: &Ray) -> bool {
        match self {
            // Any triangle will do, not the nearest.
            Shape::Mesh(s) => s.occludes(ray),
            Shape::Points(s) => s.occludes_where(ray, &|_| true),
            Shape::Sphere(_)
            | Shape::Plane(_)
            | Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Rectangle(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_) => self.intersect(ray).is_some(),
        }
    }

    /// The surface at a hit of `ray`.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        match self {
            Shape::Sphere(s) => s.surface(ray, hit),
            Shape::Plane(s) => s.surface(ray, hit),
            Shape::Box(s) => s.surface(ray, hit),
            Shape::Disk(s) => s.surface(ray, hit),
            Shape::Rectangle(s) => s.surface(ray, hit),
            Shape::Cylinder(s) => s.surface(ray, hit),
            Shape::Cone(s) => s.surface(ray, hit),
            Shape::Torus(s) => s.surface(ray, hit),
            Shape::Mesh(s) => s.surface(hit),
            Shape::Points(s) => s.surface(ray, hit),
        }
    }

    /// Surface coordinates at a point of the surface, 0..1 for bounded shapes (a mesh has its own). Asked for by
    /// textures alone: they may cost an arc tangent.
    pub fn uv(&self, hit: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        match self {
            Shape::Sphere(_) | Shape::Points(_) => Sphere::uv(point.ng),
            Shape::Plane(s) => s.uv(point.p),
            Shape::Box(s) => s.uv(hit.part, point.p),
            Shape::Disk(s) => s.uv(point.p),
            Shape::Rectangle(s) => s.uv(hit),
            Shape::Cylinder(s) => s.uv(hit.part, point.p),
            Shape::Cone(s) => s.uv(hit.part, point.p),
            Shape::Torus(s) => s.uv(point.p),
            Shape::Mesh(s) => s.uv(hit),
        }
    }

    /// How much a ray that meets the box around it has to be tested against, as a mean over such rays, in tests of simple shapes: blocks of
    /// eight triangles of a mesh, points of a cloud. At least 1. It depends on the shape alone, not on its tree.
    pub(crate) fn tests_per_ray(&self) -> f64 {
        match self {
            Shape::Sphere(_)
            | Shape::Plane(_)
            | Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Rectangle(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_) => 1.0,
            Shape::Mesh(s) => s.tests_per_ray(),
            Shape::Points(s) => s.tests_per_ray(),
        }
    }

    /// Bytes it takes beside its place in the scene's list. A mesh counts in full for each object that shows it.
    pub fn memory(&self) -> usize {
        match self {
            Shape::Sphere(_) | Shape::Plane(_) | Shape::Box(_) => 0,
            Shape::Disk(_) => size_of::<Disk>(),
            Shape::Rectangle(_) => size_of::<Rectangle>(),
            Shape::Cylinder(_) => size_of::<Cylinder>(),
            Shape::Cone(_) => size_of::<Cone>(),
            Shape::Torus(_) => size_of::<Torus>(),
            Shape::Mesh(s) => s.memory(),
            Shape::Points(s) => s.memory(),
        }
    }
}

impl ShapeDesc {
    /// Makes it traceable; checks what the reader could not. `meshes` are the scene's.
    pub fn prepare(&self, meshes: &mut MeshCache<'_>) -> Result<Shape, SceneError> {
        Ok(match self {
            ShapeDesc::Sphere(d) => Shape::Sphere(Sphere { center: d.center, radius: d.radius }),
            ShapeDesc::Plane(d) => Shape::Plane(d.prepare()?),
            ShapeDesc::Box(d) => Shape::Box(d.prepare()?),
            ShapeDesc::Disk(d) => Shape::Disk(Box::new(d.prepare()?)),
            ShapeDesc::Rectangle(d) => Shape::Rectangle(Box::new(d.prepare()?)),
            ShapeDesc::Cylinder(d) => Shape::Cylinder(Box::new(d.prepare()?)),
            ShapeDesc::Cone(d) => Shape::Cone(Box::new(d.prepare()?)),
            ShapeDesc::Torus(d) => Shape::Torus(Box::new(d.prepare()?)),
            ShapeDesc::Mesh(d) => Shape::Mesh(meshes.get(d)?),
            ShapeDesc::Points(d) => Shape::Points(meshes.points(d)?),
        })
    }
}

/// A point of a shape chosen by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaPoint {
    /// Where it is.
    pub p: DVec3,
    /// The normal there, unit, outwards.
    pub n: DVec3,
    /// The part it is on, as a hit has it.
    pub part: u32,
}

/// A point of the disk around the origin across z, evenly by area.
fn disk_point(radius: f64, u: [f64; 2]) -> DVec3 {
    let r = radius * u[0].sqrt();
    let (s, c) = sin_cos(std::f64::consts::TAU * u[1]);
    DVec3::new(r * c, r * s, 0.0)
}

/// Of a line that meets a box, how many parts' boxes it meets on average, whose half areas have the sum `parts`: at least 1.
fn mean_parts(parts: f64, whole: &Bounds) -> f64 {
    let DVec3 { x, y, z } = whole.size();
    let ratio = parts / (x * y + y * z + z * x);
    if ratio.is_finite() { ratio.max(1.0) } else { 1.0 }
}

/// The hit of a ray that is inside a convex solid from `enter` to `exit`, each with the part it is on. NaN never
/// hits.
#[inline]
fn convex_hit(ray: &Ray, enter: (f64, u32), exit: (f64, u32)) -> Option<ShapeHit> {
    if !(enter.0 <= exit.0) {
        return None;
    }
    let (t, part) = if ray.contains(enter.0) { enter } else { exit };
    ray.contains(t).then_some(ShapeHit { t, part, u: 0.0, v: 0.0 })
}

/// A vector as a unit vector, or an error that names the key it comes from.
fn direction(v: DVec3, shape: &str, key: &str) -> Result<DVec3, SceneError> {
    // Scaled first: squares of tiny and huge numbers would leave the range.
    let v = v / v.abs().max_element();
    v.try_normalize().ok_or_else(|| {
        let message = format!("the `{key}` of a {shape} must not be zero");
        SceneError::new(ErrorCode::OutOfRange, message).help(format!("for example `{key} = [0, 1, 0]`"))
    })
}

/// The unit vector and the distance between the two ends of an axis.
fn axis_of(from: DVec3, to: DVec3, shape: &str) -> Result<(DVec3, f64), SceneError> {
    let axis = to - from;
    let length = axis.length();
    if length > 1e-150 && length < 1e150 && length > 1e-12 * from.abs().max(to.abs()).max_element() {
        return Ok((axis / length, length));
    }
    let message = format!("`from` and `to` of a {shape} must be two points: found {from} and {to}");
    Err(SceneError::new(ErrorCode::OutOfRange, message).help("move one of them"))
}

/// The angle of (x, y) as 0..1, one half where x = 0 and y > 0.
fn turn(x: f64, y: f64) -> f64 {
    0.5 + atan2(x, y) / std::f64::consts::TAU
}

/// (u, v) of a cap that faces `outward`, at a point local to the frame: those of a disk.
fn cap_uv(frame: &Frame, outward: DVec3, local: DVec3, radius: f64) -> DVec2 {
    let (right, up) = plane::tangents(outward);
    let flat = frame.to_world(DVec3::new(local.x, local.y, 0.0)) / radius;
    let uv = DVec2::new(0.5 * flat.dot(right) + 0.5, 0.5 * flat.dot(up) + 0.5);
    if uv.is_nan() { DVec2::splat(0.5) } else { uv.clamp(DVec2::ZERO, DVec2::ONE) }
}
