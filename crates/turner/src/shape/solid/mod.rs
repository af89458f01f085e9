//! Solids: shapes beyond the basic ones, each in a file of its own with a line in each of the two tables below.
//!
//! A solid implements [`SolidGeometry`], whose contract is that of [`Shape`](super::Shape). The table `solids!` generates
//! the enum [`Solid`] and calls each type directly, without a vtable. The table `descriptions!` adds them to
//! [`ShapeDesc`](super::ShapeDesc).

mod blob;
mod contained;
pub mod csg;
mod distance_grid;
pub(in crate::shape) mod expression;
mod isosurface;
mod lathe;
mod line;
mod outline;
mod polynomial;
mod prism;
mod quadric;
mod roots;
mod sphere_sweep;
mod superellipsoid;
mod tessellate;
#[cfg(test)]
pub(in crate::shape) mod testing;

pub use blob::{Blob, BlobDesc};
pub use contained::Contained;
pub use csg::{ClippedDesc, Csg, CsgPart, DifferenceDesc, IntersectionDesc, UnionDesc};
pub use distance_grid::{DistanceGrid, DistanceGridDesc};
pub use isosurface::{Isosurface, IsosurfaceDesc};
pub use lathe::{Lathe, LatheDesc, LatheSpline};
pub use polynomial::{Polynomial, PolynomialDesc};
pub use prism::{Prism, PrismDesc};
pub use quadric::{Quadric, QuadricDesc};
pub use sphere_sweep::{SphereSweep, SphereSweepDesc, SweepPath};
pub use superellipsoid::{Superellipsoid, SuperellipsoidDesc};
pub use tessellate::tessellate;

use super::{MeshCache, ShapeHit, SurfacePoint, TriangleMesh};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{MaterialId, SceneError};

/// What a solid has to compute. Coordinates are in its own space; rules for rays, hits and surfaces are at
/// [`Shape`](super::Shape).
pub trait SolidGeometry {
    /// Bounding box; `None` if unbounded.
    fn bounds(&self) -> Option<Bounds>;

    /// The nearest hit with `t_min <= t <= t_max`, from outside or inside.
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit>;

    /// The surface at a hit of `ray`.
    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint;

    /// Texture coordinates at a point of the surface.
    fn uv(&self, hit: &ShapeHit, point: &SurfacePoint) -> DVec2;

    /// Approximate change of the normal per unit of length along the surface, in radians; positive where convex.
    fn curvature(&self, hit: &ShapeHit) -> f64;

    /// Whether the surface encloses a volume, so that it can be a part of constructive solid geometry.
    fn is_closed(&self) -> bool {
        true
    }

    /// Whether a ray is inside after its last crossing; always `false` for bounded solids.
    fn contains_far_end(&self, _ray: &Ray) -> bool {
        false
    }

    /// Whether (u, v) wrap around on the surface.
    fn wraps(&self) -> bool {
        true
    }

    /// Points whose convex hull approximates that of the solid; empty if unbounded.
    fn hull_points(&self) -> Vec<DVec3> {
        self.bounds().map_or(Vec::new(), |b| b.corners().to_vec())
    }

    /// Bytes beyond its own size.
    fn memory(&self) -> usize {
        0
    }

    /// Mean number of simple intersection tests for a ray that hits the bounding box; at least 1.
    fn tests_per_ray(&self) -> f64 {
        1.0
    }

    /// Materials of its parts, `None` for that of the object; empty if it has no parts with materials.
    fn materials(&self) -> &[Option<MaterialId>] {
        &[]
    }

    /// The position in [`SolidGeometry::materials`] of the material at a hit.
    fn material_slot(&self, _hit: &ShapeHit) -> usize {
        0
    }

    /// The mesh that was hit, with the hit on it, for attributes that only meshes have.
    fn mesh_at(&self, _hit: &ShapeHit) -> Option<(&TriangleMesh, ShapeHit)> {
        None
    }
}

/// What a description of a solid becomes.
pub(super) trait PrepareSolid {
    /// The form that rays are intersected with; checks what the reader could not.
    fn prepare_solid(&self, meshes: &mut MeshCache<'_>) -> Result<Solid, SceneError>;
}

/// The solids in scene files: each line has a description, whose `prepare_solid` makes a [`Solid`].
macro_rules! descriptions {
    ($then:ident! $before:tt) => {
        $then! {
            $before
            Union(UnionDesc),
            Intersection(IntersectionDesc),
            Difference(DifferenceDesc),
            Clipped(ClippedDesc),
            Prism(PrismDesc),
            Lathe(LatheDesc),
            SphereSweep(SphereSweepDesc),
            Superellipsoid(SuperellipsoidDesc),
            Blob(BlobDesc),
            Quadric(QuadricDesc),
            Polynomial(PolynomialDesc),
            Isosurface(IsosurfaceDesc),
            DistanceGrid(DistanceGridDesc),
        }
    };
}
pub(super) use descriptions;

macro_rules! solids {
    ($($(#[doc = $doc:literal])+ $name:ident($ty:ty): $word:expr,)+) => {
        /// A solid. Its size does not matter: shapes hold it behind a pointer.
        #[derive(Clone, Debug)]
        #[allow(clippy::large_enum_variant)]
        pub enum Solid { $($(#[doc = $doc])+ $name($ty),)+ }

        impl Solid {
            /// Its name in a scene file.
            pub fn word(&self) -> &'static str {
                match self { $(Solid::$name(s) => { let word: fn(&$ty) -> &'static str = $word; word(s) })+ }
            }
        }

        solids! { @methods $($name)+;
            fn bounds() -> Option<Bounds>;
            fn intersect(ray: &Ray) -> Option<ShapeHit>;
            fn surface(ray: &Ray, hit: &ShapeHit) -> SurfacePoint;
            fn uv(hit: &ShapeHit, point: &SurfacePoint) -> DVec2;
            fn curvature(hit: &ShapeHit) -> f64;
            fn is_closed() -> bool;
            fn contains_far_end(ray: &Ray) -> bool;
            fn wraps() -> bool;
            fn hull_points() -> Vec<DVec3>;
            fn memory() -> usize;
            fn tests_per_ray() -> f64;
            fn materials() -> &[Option<MaterialId>];
            fn material_slot(hit: &ShapeHit) -> usize;
            fn mesh_at(hit: &ShapeHit) -> Option<(&TriangleMesh, ShapeHit)>;
        }
    };
    (@methods $($name:ident)+; $($rest:tt)+) => {
        impl SolidGeometry for Solid { solids! { @each [$($name)+] $($rest)+ } }
    };
    (@each $names:tt $(fn $method:ident($($arg:ident: $arg_ty:ty),*) -> $out:ty;)+) => {
        $(solids! { @one $names $method ($($arg: $arg_ty),*) $out })+
    };
    (@one [$($name:ident)+] $method:ident $args:tt $out:ty) => {
        solids! { @fn $method $args $out { $($name)+ } }
    };
    (@fn $method:ident ($($arg:ident: $arg_ty:ty),*) $out:ty { $($name:ident)+ }) => {
        #[inline]
        fn $method(&self, $($arg: $arg_ty),*) -> $out {
            solids! { @match self $method ($($arg),*) $($name)+ }
        }
    };
    (@match $self:ident $method:ident $args:tt $($name:ident)+) => {
        match $self { $(Solid::$name(s) => solids! { @call s $method $args },)+ }
    };
    (@call $s:ident $method:ident ($($arg:ident),*)) => { SolidGeometry::$method($s, $($arg),*) };
}

solids! {
    /// Constructive solid geometry.
    Csg(Csg): Csg::word,
    /// An outline that is extended along y.
    Prism(Prism): |_| PrismDesc::DOC.name,
    /// An outline that is turned about y.
    Lathe(Lathe): |_| LatheDesc::DOC.name,
    /// A sphere that moves along a path.
    SphereSweep(SphereSweep): |_| SphereSweepDesc::DOC.name,
    /// A rounded box, cylinder or octahedron.
    Superellipsoid(Superellipsoid): |_| SuperellipsoidDesc::DOC.name,
    /// Metaballs.
    Blob(Blob): |_| BlobDesc::DOC.name,
    /// A surface of second degree.
    Quadric(Quadric): |_| QuadricDesc::DOC.name,
    /// A polynomial surface.
    Polynomial(Contained<Polynomial>): |_| PolynomialDesc::DOC.name,
    /// The surface where an expression is 0.
    Isosurface(Contained<Isosurface>): |_| IsosurfaceDesc::DOC.name,
    /// A grid of signed distances.
    DistanceGrid(DistanceGrid): |_| DistanceGridDesc::DOC.name,
}
