//! Shapes: the geometry that rays hit. Each shape has its own file; [`ShapeDesc`] lists their names in a scene.
//!
//! Every [`Shape`] keeps this contract:
//!
//! - Coordinates are in the shape's own space and units. An object's transform takes rays into it and surfaces
//!   out of it.
//! - [`Shape::bounds`] contains the complete shape and may be larger. `None` means unbounded.
//! - [`Shape::intersect`] takes a ray whose direction has any length but 0; t is in units of that length. It
//!   returns the nearest hit with t_min <= t <= t_max, both ends included, from outside and from inside.
//!   Non-finite rays miss.
//! - [`Shape::occludes`] returns whether `intersect` would find a hit; it may stop at the first one found.
//! - [`Shape::surface`] computes the surface at a hit, once, for the nearest hit only. It moves the point onto
//!   the surface; `error` bounds the remaining distance, so that a ray that starts farther off than `error`
//!   does not hit the surface it leaves.
//! - The geometric normal `ng` has unit length. It points out of closed shapes, and to the documented side of
//!   open ones; it is never flipped towards the ray. The shading normal `ns` has unit length and is on the same
//!   side.
//! - [`Shape::uv`] covers 0..1 on bounded shapes by the mapping documented at each shape. The (−1..1)
//!   coordinates of the classic documents are 2u − 1, 2v − 1. Only textures call it.

// `!(a <= b)` is deliberate: it also rejects NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod cone;
mod cuboid;
pub mod curves;
mod cylinder;
mod disk;
pub mod displacement;
pub(crate) mod extent;
mod height_field;
mod in_world;
mod joined_mesh;
mod made_meshes;
pub mod mesh;
mod mesh_attributes;
mod mesh_cache;
mod mesh_rays;
mod mesh_search;
mod outline;
mod parametric;
mod plane;
pub mod points;
mod rectangle;
pub mod solid;
mod sphere;
pub mod subdivision;
mod surface_change;
#[cfg(test)]
pub(crate) mod testing;
mod text;
mod torus;
pub mod traversal;
pub mod triangle;
mod triangle_mesh;
mod triangle_x8;

pub use cone::{Cone, ConeDesc};
pub use cuboid::{BoxDesc, Cuboid};
pub use curves::{Curves, CurvesDesc};
pub use cylinder::{Cylinder, CylinderDesc};
pub use disk::{Disk, DiskDesc};
pub use height_field::HeightFieldDesc;
pub use mesh::MeshDesc;
pub use mesh_cache::{CachedShapes, MeshCache};
pub use mesh_rays::{BlockRays, MeshRays, NO_TRIANGLE};
pub use parametric::ParametricDesc;
pub use plane::{Plane, PlaneDesc};
pub use points::{Points, PointsDesc};
pub use rectangle::{Rectangle, RectangleDesc};
pub use solid::{Solid, SolidGeometry};
pub use sphere::{Sphere, SphereDesc};
pub use subdivision::{Subdivided, Subdivision, SubdivisionScheme, subdivide};
#[cfg(test)]
pub(crate) use text::testing as text_testing;
pub use text::{TextAlign, TextDesc};
pub use torus::{Torus, TorusDesc};
pub use triangle_mesh::{SkippedTriangles, TriangleMesh};

use std::sync::Arc;

use crate::math::elementary::{atan2, sin_cos};
use crate::math::{Bounds, DVec2, DVec3, Frame, Ray};
use crate::schema::{ErrorCode, SceneError, family};
use solid::PrepareSolid;
use solid::{
    BlobDesc, ClippedDesc, DifferenceDesc, DistanceGridDesc, IntersectionDesc, IsosurfaceDesc, LatheDesc,
    PolynomialDesc, PrismDesc, QuadricDesc, SphereSweepDesc, SuperellipsoidDesc, UnionDesc,
};

/// Declares [`ShapeDesc`]: the basic shapes with how each is prepared, followed by the solids of the table in
/// [`solid`].
macro_rules! shapes {
    (
        ($($basic:ident($basic_ty:ty) => $prepare:expr,)+)
        $($solid:ident($solid_ty:ty),)+
    ) => {
        family! {
            /// Shapes: the `type` of an `[[object]]`.
            pub enum ShapeDesc as "shape", "shapes" {
                $($basic($basic_ty),)+
                $($solid($solid_ty),)+
            }
        }

        impl ShapeDesc {
            /// Converts it to the form that rays are intersected with; checks what the reader could not. `meshes`
            /// are the scene's.
            pub fn prepare(&self, meshes: &mut MeshCache<'_>) -> Result<Shape, SceneError> {
                match self {
                    $(ShapeDesc::$basic(desc) => {
                        let prepare: fn(&$basic_ty, &mut MeshCache<'_>) -> Result<Shape, SceneError> = $prepare;
                        prepare(desc, meshes)
                    })+
                    $(ShapeDesc::$solid(desc) => desc.prepare_solid(meshes).map(|s| Shape::Solid(Arc::new(s))),)+
                }
            }
        }
    };
}

solid::descriptions! { shapes! (
    Sphere(SphereDesc) => |d, _| Ok(Shape::Sphere(Sphere { center: d.center, radius: d.radius })),
    Plane(PlaneDesc) => |d, _| Ok(Shape::Plane(d.prepare()?)),
    Box(BoxDesc) => |d, _| Ok(Shape::Box(d.prepare()?)),
    Disk(DiskDesc) => |d, _| Ok(Shape::Disk(Box::new(d.prepare()?))),
    Rectangle(RectangleDesc) => |d, _| Ok(Shape::Rectangle(Box::new(d.prepare()?))),
    Cylinder(CylinderDesc) => |d, _| Ok(Shape::Cylinder(Box::new(d.prepare()?))),
    Cone(ConeDesc) => |d, _| Ok(Shape::Cone(Box::new(d.prepare()?))),
    Torus(TorusDesc) => |d, _| Ok(Shape::Torus(Box::new(d.prepare()?))),
    Mesh(MeshDesc) => |d, meshes| Ok(Shape::Mesh(meshes.get(d)?)),
    Points(PointsDesc) => |d, meshes| Ok(Shape::Points(meshes.points(d)?)),
    Curves(CurvesDesc) => |d, meshes| Ok(Shape::Curves(meshes.curves(d)?)),
    Parametric(ParametricDesc) => |d, meshes| Ok(Shape::Mesh(meshes.parametric(d)?)),
    Text(TextDesc) => |d, meshes| Ok(Shape::Mesh(meshes.text(d)?)),
    HeightField(HeightFieldDesc) => |d, meshes| Ok(Shape::Mesh(meshes.height_field(d)?)),
) }

/// Bound on the distance of a surface point from the surface, per unit of the largest coordinate or length it
/// is computed from: eighteen roundings. It is generous on purpose: a ray that starts that far outside must
/// still count as outside after further roundings.
pub(crate) const ROUNDING: f64 = 4e-15;

/// A hit of a ray with a shape: all that traversal keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// Parameter along the ray.
    pub t: f64,
    /// The part that was hit: a face of a box, a cap or the side of a cylinder, a triangle.
    pub part: u32,
    /// First coordinate within the part, if the shape stores it (barycentric for triangles).
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

/// A shape that rays can be intersected with. 56 bytes: common shapes by value, larger ones behind a pointer.
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
    /// A triangle mesh, shared by the objects that use it.
    Mesh(Arc<TriangleMesh>),
    /// A point cloud, shared by the objects that use it.
    Points(Arc<Points>),
    /// Curves, shared by the objects that use them.
    Curves(Arc<Curves>),
    /// Another shape; see [`solid`].
    Solid(Arc<Solid>),
}

const _: () = assert!(size_of::<Shape>() <= 56);

impl Shape {
    /// Its name in a scene file.
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
            Shape::Curves(_) => CurvesDesc::DOC.name,
            Shape::Solid(s) => s.word(),
        }
    }

    /// Bounding box; `None` if unbounded, empty for a mesh without triangles, a cloud without points or no curves.
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
            Shape::Curves(s) => Some(s.bounds()),
            Shape::Solid(s) => s.bounds(),
        }
    }

    /// The nearest hit with `t_min <= t <= t_max`, from outside or inside. Rays with NaN, infinities or a zero
    /// direction miss.
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
            Shape::Curves(s) => s.intersect(ray),
            Shape::Solid(s) => s.intersect(ray),
        }
    }

    /// Whether anything is hit with `t_min <= t <= t_max`.
    #[inline]
    pub fn occludes(&self, ray: &Ray) -> bool {
        match self {
            // Any triangle is enough, not the nearest.
            Shape::Mesh(s) => s.occludes(ray),
            Shape::Points(s) => s.occludes_where(ray, &|_| true),
            Shape::Curves(s) => s.occludes_where(ray, &|_| true),
            Shape::Sphere(_)
            | Shape::Plane(_)
            | Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Rectangle(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Solid(_) => self.intersect(ray).is_some(),
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
            Shape::Curves(s) => s.surface(ray, hit),
            Shape::Solid(s) => s.surface(ray, hit),
        }
    }

    /// Texture coordinates at a point of the surface: 0..1 for bounded shapes, the mesh's own for meshes. Only
    /// textures call it, because it may cost an arc tangent.
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
            Shape::Curves(s) => s.uv(hit),
            Shape::Solid(s) => s.uv(hit, point),
        }
    }

    /// Mean number of simple intersection tests (blocks of eight triangles of a mesh, points of a cloud, parts of curves) for a
    /// ray that hits the bounding box. At least 1. It depends on the shape alone, not on its tree.
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
            Shape::Curves(s) => s.tests_per_ray(),
            Shape::Solid(s) => s.tests_per_ray(),
        }
    }

    /// Bytes in addition to its slot in the scene's list. A mesh counts in full for each object that uses it.
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
            Shape::Curves(s) => s.memory(),
            Shape::Solid(s) => size_of::<Solid>() + s.memory(),
        }
    }

    /// Whether it encloses a volume. A plane encloses the half-space that its normal points away from; a mesh counts
    /// as closed.
    pub fn is_closed(&self) -> bool {
        match self {
            Shape::Sphere(_) | Shape::Plane(_) | Shape::Box(_) | Shape::Torus(_) | Shape::Mesh(_) => true,
            Shape::Disk(_) | Shape::Rectangle(_) | Shape::Points(_) | Shape::Curves(_) => false,
            Shape::Cylinder(s) => s.is_capped(),
            Shape::Cone(s) => s.is_capped(),
            Shape::Solid(s) => s.is_closed(),
        }
    }

    /// Whether a ray is inside a closed shape after its last crossing; never, except for unbounded shapes.
    pub(crate) fn contains_far_end(&self, ray: &Ray) -> bool {
        match self {
            Shape::Plane(s) => s.contains_far_end(ray),
            Shape::Solid(s) => s.contains_far_end(ray),
            Shape::Sphere(_)
            | Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Rectangle(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Mesh(_)
            | Shape::Points(_)
            | Shape::Curves(_) => false,
        }
    }
}

/// A point on a shape sampled by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaPoint {
    /// Position.
    pub p: DVec3,
    /// Unit outward normal.
    pub n: DVec3,
    /// The part it is on, as in [`ShapeHit`].
    pub part: u32,
}

/// Samples the disk around the origin in the xy plane, uniformly by area.
fn disk_point(radius: f64, u: [f64; 2]) -> DVec3 {
    let r = radius * u[0].sqrt();
    let (s, c) = sin_cos(std::f64::consts::TAU * u[1]);
    DVec3::new(r * c, r * s, 0.0)
}

/// Mean number of parts' boxes hit by a line that hits the box `whole`, at least 1. `parts` is the sum of the
/// parts' half surface areas: the probability of hitting a convex body inside another is the ratio of their
/// areas.
fn mean_parts(parts: f64, whole: &Bounds) -> f64 {
    let DVec3 { x, y, z } = whole.size();
    let ratio = parts / (x * y + y * z + z * x);
    if ratio.is_finite() { ratio.max(1.0) } else { 1.0 }
}

/// The hit of a ray that is inside a convex solid between `enter` and `exit`, each with its part. NaN misses.
#[inline]
fn convex_hit(ray: &Ray, enter: (f64, u32), exit: (f64, u32)) -> Option<ShapeHit> {
    if !(enter.0 <= exit.0) {
        return None;
    }
    let (t, part) = if ray.contains(enter.0) { enter } else { exit };
    ray.contains(t).then_some(ShapeHit { t, part, u: 0.0, v: 0.0 })
}

/// Normalizes a vector, or returns an error that names its key.
fn direction(v: DVec3, shape: &str, key: &str) -> Result<DVec3, SceneError> {
    // Scale first: squares of tiny and huge components would underflow or overflow.
    let v = v / v.abs().max_element();
    v.try_normalize().ok_or_else(|| {
        let message = format!("the `{key}` of a {shape} must not be zero");
        SceneError::new(ErrorCode::OutOfRange, message).help(format!("for example `{key} = [0, 1, 0]`"))
    })
}

/// Unit direction and length of the axis between two points.
fn axis_of(from: DVec3, to: DVec3, shape: &str) -> Result<(DVec3, f64), SceneError> {
    let axis = to - from;
    let length = axis.length();
    if length > 1e-150 && length < 1e150 && length > 1e-12 * from.abs().max(to.abs()).max_element() {
        return Ok((axis / length, length));
    }
    let message = format!("`from` and `to` of a {shape} must be two points: found {from} and {to}");
    Err(SceneError::new(ErrorCode::OutOfRange, message).help("move one of the two points"))
}

/// The angle of (x, y) mapped to 0..1: one half at x = 0, y > 0.
fn unit_angle(x: f64, y: f64) -> f64 {
    0.5 + atan2(x, y) / std::f64::consts::TAU
}

/// (u, v) of a cap that faces `outward`, at a point in the frame's space: those of a disk.
fn cap_uv(frame: &Frame, outward: DVec3, local: DVec3, radius: f64) -> DVec2 {
    let (right, up) = plane::tangents(outward);
    let flat = frame.to_world(DVec3::new(local.x, local.y, 0.0)) / radius;
    let uv = DVec2::new(0.5 * flat.dot(right) + 0.5, 0.5 * flat.dot(up) + 0.5);
    if uv.is_nan() { DVec2::splat(0.5) } else { uv.clamp(DVec2::ZERO, DVec2::ONE) }
}
