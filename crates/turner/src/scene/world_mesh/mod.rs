//! One tree over the triangles of many meshes.
//!
//! Meshes that are placed once, and small ones that are placed a few times, are gathered in the world's space, so that rays go
//! through one tree together instead of through one object after the other. What a hit is then told by the object it belongs
//! to: its number, its own triangle, its weights.
//!
//! Positions are rounded to single precision after they were moved into the world. Two rules keep that harmless: a mesh is
//! gathered only if it is no smaller than [`gather::RATIO`]th of the distances in the gathered mesh, and places on its
//! surface are computed from the rounded positions, so that a ray which leaves it does not meet it again. Meshes without a transform keep
//! their positions bit for bit.
//!
//! **Memory.** 28 bytes per triangle beside the mesh's own, for positions, corners and owner; the tree is in place of theirs.
//! While some members differ from those that the tree was built over, positions and nodes are there twice.

mod gather;

use std::cell::Cell;
use std::sync::Arc;

use crate::material::ShadowKind;
use crate::math::{DAffine3, DVec3, Ray};
use crate::scene::alpha_test::NO_FACES;
use crate::scene::scene::NO_TRANSFORM;
use crate::scene::{Hit, Scene};
use crate::shape::extent::Extent;
use crate::shape::{NO_TRIANGLE, Shape, ShapeHit, SurfacePoint, TriangleMesh};

pub(crate) use gather::{Members, choose};

/// The gathered meshes.
#[derive(Clone, Debug)]
pub(crate) struct StaticWorldMesh {
    /// Positions and tree, which later scenes share.
    mesh: Arc<TriangleMesh>,
    /// What was taken from positions in the world.
    offset: DVec3,
    /// For each triangle its member.
    owners: Arc<[u32]>,
    members: Arc<[Member]>,
    /// Where the members lie in the mesh, and what they were made from.
    parts: Arc<[Part]>,
    sources: Arc<[Source]>,
    /// Whose tree this shares, if some members have changed since that was built.
    base: Option<Base>,
    /// The first member among the scene's primitives; the others follow.
    first: u32,
    /// Whether hits of some members may be none.
    checked: bool,
    /// Whether all cast full shadows.
    opaque: bool,
}

/// A member's mesh and its place in the world.
#[derive(Clone, Debug)]
struct Source {
    mesh: Arc<TriangleMesh>,
    to_world: Option<DAffine3>,
}

/// Gathered meshes with a tree over all of them.
#[derive(Clone, Debug)]
struct Base {
    mesh: Arc<TriangleMesh>,
    owners: Arc<[u32]>,
    members: Arc<[Member]>,
    parts: Arc<[Part]>,
    sources: Arc<[Source]>,
}

/// A member's place in the gathered mesh.
#[derive(Clone, Debug)]
struct Part {
    /// Its first corner and its first triangle.
    corner: u32,
    start: u32,
    extent: Extent,
}

#[derive(Clone, Debug)]
struct Member {
    /// Its first triangle.
    start: u32,
    /// -1 where its transform mirrors.
    side: f64,
    /// Whether its positions are those of its mesh.
    exact: bool,
}

/// A triangle that stands in the world as it is.
pub(crate) struct PlacedTriangle<'a> {
    /// The mesh of the object.
    pub(crate) own: &'a TriangleMesh,
    /// The mesh whose positions count, and its triangle.
    pub(crate) mesh: &'a TriangleMesh,
    pub(crate) part: u32,
    /// In the gathered mesh what was taken from its positions, and -1 where its transform mirrors.
    pub(crate) moved: Option<(DVec3, f64)>,
}

impl StaticWorldMesh {
    /// Bytes it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.mesh.memory()
            + size_of_val(&self.owners[..])
            + size_of_val(&self.members[..])
            + size_of_val(&self.parts[..])
            + size_of_val(&self.sources[..])
            + self.base.as_ref().map_or(0, |base| base.mesh.memory() + size_of_val(&base.owners[..]))
    }

    /// Whether its tree was changed since it was built.
    pub(crate) fn is_changed(&self) -> bool {
        self.base.is_some()
    }

    /// Whether all members cast full shadows.
    pub(crate) fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// The gathered mesh.
    pub(crate) fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// What is taken from the origins of its rays.
    pub(crate) fn offset(&self) -> DVec3 {
        self.offset
    }

    /// Whether hits of some members may be none.
    pub(crate) fn is_checked(&self) -> bool {
        self.checked
    }

    /// A ray of the world in its space.
    #[inline]
    pub(crate) fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: ray.origin - self.offset, ..*ray }
    }

    /// A hit as its owner has it.
    #[inline]
    pub(crate) fn owned(&self, hit: &ShapeHit) -> Hit {
        let member = self.owners[hit.part as usize];
        let shape = ShapeHit { part: hit.part - self.members[member as usize].start, ..*hit };
        Hit { shape, primitive: self.first + member }
    }

    /// The triangle that a part of a primitive is here.
    #[inline]
    pub(crate) fn triangle(&self, primitive: u32, part: u32) -> u32 {
        let member = primitive.wrapping_sub(self.first) as usize;
        self.members.get(member).map_or(NO_TRIANGLE, |m| m.start + part)
    }

    /// The member that a primitive is, if its positions were rounded.
    fn rounded(&self, primitive: u32) -> Option<&Member> {
        let member = self.members.get(primitive.checked_sub(self.first)? as usize)?;
        (!member.exact).then_some(member)
    }
}

impl Scene {
    /// Whether anything is at a hit of the gathered meshes.
    #[inline]
    pub(crate) fn world_mesh_hit_counts(&self, ray: &Ray, hit: &Hit) -> bool {
        let primitive = &self.primitives[hit.primitive as usize];
        primitive.faces == NO_FACES
            || !self.faces[primitive.faces as usize].are_checked()
            || self.is_there(primitive, &self.to_object(primitive, ray), &hit.shape)
    }

    /// The nearest hit of the gathered meshes.
    #[inline]
    pub(crate) fn intersect_world_mesh(&self, world_mesh: &StaticWorldMesh, ray: &Ray) -> Option<Hit> {
        let moved = world_mesh.ray(ray);
        let hit = world_mesh.owned(&world_mesh.mesh.intersect(&moved)?);
        if !world_mesh.checked || self.world_mesh_hit_counts(ray, &hit) {
            return Some(hit);
        }
        self.intersect_world_mesh_behind(world_mesh, ray)
    }

    /// The same, where the nearest triangle is not there.
    #[cold]
    pub(crate) fn intersect_world_mesh_behind(&self, world_mesh: &StaticWorldMesh, ray: &Ray) -> Option<Hit> {
        let accept = |hit: &ShapeHit| self.world_mesh_hit_counts(ray, &world_mesh.owned(hit));
        world_mesh.mesh.intersect_where(&world_mesh.ray(ray), &accept).map(|hit| world_mesh.owned(&hit))
    }

    /// Whether a hit of the gathered meshes stops light; sets `tinted` where it lets some through.
    #[inline]
    pub(crate) fn world_mesh_stops(&self, ray: &Ray, hit: &Hit, tinted: &Cell<bool>) -> bool {
        let primitive = &self.primitives[hit.primitive as usize];
        self.world_mesh_hit_counts(ray, hit)
            && match self.materials[self.material_of(primitive, &hit.shape).index()].shadow() {
                ShadowKind::Opaque => true,
                ShadowKind::None => false,
                ShadowKind::Tinted => {
                    tinted.set(true);
                    false
                }
            }
    }

    /// Whether the gathered meshes stop light along a ray.
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
        let blocks = |hit: &ShapeHit| self.world_mesh_stops(ray, &world_mesh.owned(hit), tinted);
        world_mesh.mesh.occludes_where(&moved, &blocks)
    }

    /// The triangle of a mesh that a hit is in the world, with what was taken from its positions and -1 where its transform mirrors; `None`
    /// where it does not stand in the world as it is.
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

    /// The surface of a member whose positions were rounded; `object` is that of its own mesh.
    #[inline]
    pub(crate) fn merged_surface(
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
        let ns = match primitive.transform {
            NO_TRANSFORM => object.ns,
            i => (self.transforms[i as usize].normal * object.ns).normalize(),
        };
        let facet = object.ns == object.ng;
        let ns = if facet || !ns.is_finite() { ng } else { ns * ns.dot(ng).signum() };
        Some((p, error, ng, ns))
    }

    /// The corners of a triangle of a mesh in the world, and -1 where its transform mirrors.
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
