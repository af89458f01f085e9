//! Static world mesh: one BVH over the triangles of many meshes.
//!
//! A two-level structure (a BVH over objects, one BVH per mesh) makes rays traverse overlapping objects one after the
//! other. Meshes that are placed once, and small meshes placed a few times, are therefore copied to world space and
//! share one BVH. A hit is mapped back to its object: primitive, triangle index, barycentric weights.
//!
//! ```text
//!   mesh A ──to_world──┐     positions in world space (f32, minus `offset`)
//!   mesh B ──to_world──┼──>  | A's triangles | B's triangles | C's |   one BVH
//!   mesh C ──to_world──┘     0               start of B      start of C
//!   owners[triangle] = member;  own triangle = triangle − member.start
//! ```
//!
//! Positions are rounded to single precision in world space. Two rules keep that harmless. A mesh is included only if
//! it is no smaller than 1/[`gather::RATIO`] of its distance from the origin. And points on its surface are computed
//! from the rounded positions, so a ray that leaves the surface does not hit it again. Meshes without a transform
//! keep their positions bit for bit.
//!
//! **Memory.** 28 bytes per triangle in addition to the mesh's own, for positions, corners and owner; the BVH
//! replaces those of the meshes. While some members differ from those that the BVH was built over, positions and
//! nodes exist twice.

mod gather;

use std::cell::Cell;
use std::sync::Arc;

use crate::material::ShadowKind;
use crate::math::{DAffine3, DMat3, DVec3, Ray};
use crate::scene::alpha_test::NO_FACES;
use crate::scene::scene::NO_TRANSFORM;
use crate::scene::{Hit, Scene};
use crate::shape::extent::Extent;
use crate::shape::{NO_TRIANGLE, Shape, ShapeHit, SurfacePoint, TriangleMesh};

pub(crate) use gather::{Members, choose};

/// A static world mesh.
#[derive(Clone, Debug)]
pub(crate) struct StaticWorldMesh {
    /// Positions and BVH, shared with later scenes.
    mesh: Arc<TriangleMesh>,
    /// Offset subtracted from world-space positions.
    offset: DVec3,
    /// For each triangle its member.
    owners: Arc<[u32]>,
    members: Arc<[Member]>,
    /// The members' ranges in the mesh, and the meshes that they come from.
    parts: Arc<[Part]>,
    sources: Arc<[Source]>,
    /// The mesh whose BVH this one shares, if members have changed since it was built.
    base: Option<Base>,
    /// Index of the first member among the scene's primitives; the others follow.
    first: u32,
    /// Whether some members need an alpha test.
    alpha_tested: bool,
    /// Whether all members cast opaque shadows.
    opaque: bool,
}

/// A member's mesh and transform.
#[derive(Clone, Debug)]
struct Source {
    mesh: Arc<TriangleMesh>,
    to_world: Option<DAffine3>,
}

/// A world mesh with a BVH built over all of its members.
#[derive(Clone, Debug)]
struct Base {
    mesh: Arc<TriangleMesh>,
    owners: Arc<[u32]>,
    members: Arc<[Member]>,
    parts: Arc<[Part]>,
    sources: Arc<[Source]>,
}

/// A member's range in the world mesh.
#[derive(Clone, Debug)]
struct Part {
    /// Index of its first corner and of its first triangle.
    corner: u32,
    start: u32,
    extent: Extent,
}

#[derive(Clone, Debug)]
struct Member {
    /// Index of its first triangle.
    start: u32,
    /// -1 if its transform mirrors, else 1.
    side: f64,
    /// Whether its positions equal those of its mesh.
    exact: bool,
}

/// A triangle with world-space positions.
pub(crate) struct PlacedTriangle<'a> {
    /// The object's mesh.
    pub(crate) own: &'a TriangleMesh,
    /// The mesh that holds the world-space positions, and the triangle's index in it.
    pub(crate) mesh: &'a TriangleMesh,
    pub(crate) part: u32,
    /// For a world mesh: the offset subtracted from positions, and -1 if the transform mirrors.
    pub(crate) moved: Option<(DVec3, f64)>,
}

impl PlacedTriangle<'_> {
    /// The geometric unit normal, equal to that of [`Scene::surface`] bit by bit.
    #[inline]
    pub(crate) fn normal(&self) -> DVec3 {
        self.mesh.geometric_normal(self.part) * self.moved.map_or(1.0, |(_, side)| side)
    }
}

impl StaticWorldMesh {
    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.mesh.memory()
            + size_of_val(&self.owners[..])
            + size_of_val(&self.members[..])
            + size_of_val(&self.parts[..])
            + size_of_val(&self.sources[..])
            + self.base.as_ref().map_or(0, |base| base.mesh.memory() + size_of_val(&base.owners[..]))
    }

    /// Whether members have changed since its BVH was built.
    pub(crate) fn is_changed(&self) -> bool {
        self.base.is_some()
    }

    /// Whether all members cast opaque shadows.
    pub(crate) fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// The mesh with all triangles.
    pub(crate) fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The offset subtracted from ray origins.
    pub(crate) fn offset(&self) -> DVec3 {
        self.offset
    }

    /// Whether some members need an alpha test.
    pub(crate) fn is_alpha_tested(&self) -> bool {
        self.alpha_tested
    }

    /// A world-space ray relative to the offset.
    #[inline]
    pub(crate) fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: ray.origin - self.offset, ..*ray }
    }

    /// Maps a hit to the member's primitive and triangle.
    #[inline]
    pub(crate) fn owned(&self, hit: &ShapeHit) -> Hit {
        let member = self.owners[hit.part as usize];
        let shape = ShapeHit { part: hit.part - self.members[member as usize].start, ..*hit };
        Hit { shape, primitive: self.first + member }
    }

    /// The triangle index here of a part of a primitive.
    #[inline]
    pub(crate) fn triangle(&self, primitive: u32, part: u32) -> u32 {
        let member = primitive.wrapping_sub(self.first) as usize;
        self.members.get(member).map_or(NO_TRIANGLE, |m| m.start + part)
    }

    /// The member of a primitive, if its positions were rounded.
    fn rounded(&self, primitive: u32) -> Option<&Member> {
        let member = self.members.get(primitive.checked_sub(self.first)? as usize)?;
        (!member.exact).then_some(member)
    }
}

impl Scene {
    /// Whether a hit of the world mesh passes the alpha test.
    #[inline]
    pub(crate) fn accepts_world_mesh_hit(&self, ray: &Ray, hit: &Hit) -> bool {
        let primitive = &self.primitives[hit.primitive as usize];
        primitive.faces == NO_FACES
            || !self.faces[primitive.faces as usize].need_test()
            || self.accepts_hit(primitive, &self.to_object(primitive, ray), &hit.shape)
    }

    /// The nearest hit of the world mesh.
    #[inline]
    pub(crate) fn intersect_world_mesh(&self, world_mesh: &StaticWorldMesh, ray: &Ray) -> Option<Hit> {
        let moved = world_mesh.ray(ray);
        let hit = world_mesh.owned(&world_mesh.mesh.intersect(&moved)?);
        if !world_mesh.alpha_tested || self.accepts_world_mesh_hit(ray, &hit) {
            return Some(hit);
        }
        self.intersect_world_mesh_behind(world_mesh, ray)
    }

    /// The same, if the nearest hit failed the alpha test.
    #[cold]
    pub(crate) fn intersect_world_mesh_behind(&self, world_mesh: &StaticWorldMesh, ray: &Ray) -> Option<Hit> {
        let accept = |hit: &ShapeHit| self.accepts_world_mesh_hit(ray, &world_mesh.owned(hit));
        world_mesh.mesh.intersect_where(&world_mesh.ray(ray), &accept).map(|hit| world_mesh.owned(&hit))
    }

    /// Whether a hit of the world mesh blocks light; sets `tinted` if it transmits some.
    #[inline]
    pub(crate) fn world_mesh_hit_blocks(&self, ray: &Ray, hit: &Hit, tinted: &Cell<bool>) -> bool {
        let primitive = &self.primitives[hit.primitive as usize];
        self.accepts_world_mesh_hit(ray, hit)
            && match self.materials[self.material_of(primitive, &hit.shape).index()].shadow() {
                ShadowKind::Opaque => true,
                ShadowKind::None => false,
                ShadowKind::Tinted => {
                    tinted.set(true);
                    false
                }
            }
    }

    /// Whether the world mesh blocks light along a ray.
    pub(crate) fn world_mesh_blocks(
        &self,
        world_mesh: &StaticWorldMesh,
        ray: &Ray,
        tinted: &Cell<bool>,
    ) -> bool {
        let moved = world_mesh.ray(ray);
        if world_mesh.opaque {
            return world_mesh.mesh.occludes(&moved);
        }
        let blocks = |hit: &ShapeHit| self.world_mesh_hit_blocks(ray, &world_mesh.owned(hit), tinted);
        world_mesh.mesh.occludes_where(&moved, &blocks)
    }

    /// The triangle of a hit with its world-space positions; `None` if the mesh has its own BVH and a transform.
    #[inline]
    pub(crate) fn placed_triangle(&self, hit: &Hit) -> Option<PlacedTriangle<'_>> {
        let primitive = &self.primitives[hit.primitive as usize];
        let Shape::Mesh(mesh) = &primitive.shape else { return None };
        if let Some(world_mesh) = &self.world_mesh
            && let Some(member) = world_mesh.rounded(hit.primitive)
        {
            let part = hit.shape.part + member.start;
            let moved = Some((world_mesh.offset, member.side));
            return Some(PlacedTriangle { own: mesh, mesh: &world_mesh.mesh, part, moved });
        }
        let stays = primitive.transform == NO_TRANSFORM;
        stays.then_some(PlacedTriangle { own: mesh, mesh, part: hit.shape.part, moved: None })
    }

    /// Brings the triangles of hits into the cache. Their places in memory are random; here nothing waits for them, so that
    /// many are on their way at once.
    pub(crate) fn fetch_triangles(&self, hits: &[Option<Hit>]) {
        let mut sum = 0;
        for hit in hits.iter().flatten() {
            if let Some(triangle) = self.placed_triangle(hit) {
                sum ^= triangle.mesh.touch(triangle.part, triangle.own, hit.shape.part);
            }
        }
        std::hint::black_box(sum);
    }

    /// The surface of a member whose positions were rounded; `object` is the surface of its own mesh.
    #[inline]
    pub(crate) fn world_mesh_surface(
        &self,
        hit: &Hit,
        object: &SurfacePoint,
    ) -> Option<(DVec3, f64, DVec3, DVec3)> {
        let world_mesh = self.world_mesh.as_ref()?;
        let member = world_mesh.rounded(hit.primitive)?;
        let s = world_mesh.mesh.surface(&ShapeHit { part: hit.shape.part + member.start, ..hit.shape });
        let p = s.p + world_mesh.offset;
        let error = s.error + 4.0 * f64::EPSILON * world_mesh.offset.abs().max_element();
        let ng = s.ng * member.side;
        let primitive = &self.primitives[hit.primitive as usize];
        let own = match &primitive.shape {
            // A facet, or vertex normals that are exactly its normal.
            Shape::Mesh(mesh) if object.ns == object.ng => mesh.interpolated_normal(&hit.shape),
            _ => Some(object.ns),
        };
        let ns = own.map(|n| self.normal_matrix(hit).map_or(n, |turn| (turn * n).normalize()));
        let ns = ns.filter(|n| n.is_finite()).map_or(ng, |n| match n.dot(ng) {
            side if side > 0.0 => n,
            side if side < 0.0 => -n,
            _ => ng,
        });
        Some((p, error, ng, ns))
    }

    /// The matrix that brings the normals of a hit object to the world; `None` if they are there.
    #[inline]
    pub(crate) fn normal_matrix(&self, hit: &Hit) -> Option<DMat3> {
        match self.primitives[hit.primitive as usize].transform {
            NO_TRANSFORM => None,
            i => Some(self.transforms[i as usize].normal),
        }
    }

    /// The world-space corners of a mesh's triangle, and -1 if its transform mirrors, else 1.
    pub(crate) fn corners(&self, index: u32, mesh: &TriangleMesh, part: u32) -> Option<([DVec3; 3], f64)> {
        if let Some(world_mesh) = &self.world_mesh
            && let Some(member) = world_mesh.rounded(index)
        {
            let corners = world_mesh.mesh.triangle_corners(member.start + part)?;
            return Some((corners.map(|p| p + world_mesh.offset), member.side));
        }
        let corners = mesh.triangle_corners(part)?;
        let primitive = &self.primitives[index as usize];
        Some(match primitive.transform {
            NO_TRANSFORM => (corners, 1.0),
            i => {
                let to_world = &self.transforms[i as usize].to_world;
                let side = to_world.matrix3.determinant().signum();
                (corners.map(|p| to_world.transform_point3(p)), side)
            }
        })
    }
}
