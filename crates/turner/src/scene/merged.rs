//! One tree over the triangles of many meshes.
//!
//! Meshes that are placed once, and small ones that are placed a few times, are gathered in the world's space, so that rays go
//! through one tree together instead of through one object after the other. What a hit is then told by the object it belongs
//! to: its number, its own triangle, its weights.
//!
//! Positions are rounded to single precision after they were moved into the world. Two rules keep that harmless: a mesh is
//! gathered only if it is no smaller than [`RATIO`]th of the distances in the gathered mesh, and places on its
//! surface are computed from the rounded positions, so that a ray which leaves it does not meet it again. Meshes without a transform keep
//! their positions bit for bit.
//!
//! **Memory.** 28 bytes per triangle beside the mesh's own, for positions, corners and owner; the tree is in place of theirs.

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::Arc;

use crate::material::{Material, ShadowKind};
use crate::math::{Bounds, DAffine3, DVec3, Ray};
use crate::scene::faces::{Faces, NO_FACES};
use crate::scene::scene::{NO_TRANSFORM, ObjectTransform, Primitive};
use crate::scene::{Hit, Scene};
use crate::schema::{ErrorCode, MeshData, PrepareOptions, SceneError};
use crate::shape::{NO_TRIANGLE, Shape, ShapeHit, SurfacePoint, TriangleMesh};

/// A mesh this much smaller than the gathered one, or larger than most, stands by itself.
const RATIO: f64 = 1024.0;

/// Meshes of more triangles stand by themselves: they gain little, and their positions would take memory twice.
const MAX_MESH: usize = 1 << 22;

/// Triangles of meshes that are placed more than once: gathered, they take memory for each place.
const MAX_REPEATED: usize = 1 << 16;

/// The gathered meshes.
#[derive(Clone, Debug)]
pub(crate) struct Merged {
    /// Positions and tree, which later scenes share.
    mesh: Arc<TriangleMesh>,
    /// What was taken from positions in the world.
    offset: DVec3,
    /// For each triangle its member.
    owners: Arc<[u32]>,
    members: Arc<[Member]>,
    /// What the members were made from.
    sources: Vec<Source>,
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

impl Source {
    fn is(&self, other: &Source) -> bool {
        Arc::ptr_eq(&self.mesh, &other.mesh) && self.to_world == other.to_world
    }
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

/// Which primitives are gathered, and what is taken from their positions.
pub(crate) fn choose(primitives: &[Primitive], bounds: &[Option<Bounds>]) -> (Vec<bool>, DVec3) {
    let none = (vec![false; primitives.len()], DVec3::ZERO);
    let mut uses: HashMap<*const TriangleMesh, usize> = HashMap::new();
    for primitive in primitives {
        if let Shape::Mesh(mesh) = &primitive.shape {
            *uses.entry(Arc::as_ptr(mesh)).or_default() += 1;
        }
    }
    // By the first of its places, a mesh is in or out.
    let (mut repeated, mut allowed) = (0, HashMap::new());
    let mut candidates = Vec::new();
    for (i, primitive) in primitives.iter().enumerate() {
        let (Shape::Mesh(mesh), Some(b)) = (&primitive.shape, bounds[i]) else { continue };
        let pointer = Arc::as_ptr(mesh);
        let count = mesh.data().triangles.len();
        let is_in = *allowed.entry(pointer).or_insert_with(|| {
            let uses = uses.get(&pointer).copied().unwrap_or(1);
            let all = count.saturating_mul(uses);
            if uses == 1 {
                return count <= MAX_MESH;
            }
            let fits = repeated + all <= MAX_REPEATED;
            repeated += if fits { all } else { 0 };
            fits
        });
        if is_in && mesh.triangle_count() > 0 && !b.is_empty() && b.is_finite() {
            candidates.push((i, b));
        }
    }
    if candidates.len() < 2 {
        return none;
    }
    let mut sizes: Vec<f64> = candidates.iter().map(|(_, b)| b.size().length()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = RATIO * sizes[sizes.len() / 2];
    // Where the middle is nearer than this, moving gains less than three bits.
    let all = candidates.iter().fold(Bounds::EMPTY, |a, (_, b)| a.union(b));
    let far = all.center().abs().max_element() > 4.0 * all.size().max_element();
    let offset = if far { all.center() } else { DVec3::ZERO };
    let reach = |b: &Bounds| (b.min - offset).abs().max((b.max - offset).abs()).max_element();
    candidates.retain(|(_, b)| reach(b) <= most);
    let extent = candidates.iter().map(|(_, b)| reach(b)).fold(0.0, f64::max);
    candidates.retain(|(_, b)| b.size().length() * RATIO >= extent);
    if candidates.len() < 2 {
        return none;
    }
    let mut chosen = none.0;
    for (i, _) in candidates {
        chosen[i] = true;
    }
    (chosen, offset)
}

/// The primitives whose meshes are gathered, and what they refer to.
#[derive(Clone, Copy)]
pub(crate) struct Members<'a> {
    pub(crate) primitives: &'a [Primitive],
    /// Where they come to stand among the scene's primitives.
    pub(crate) first: usize,
    pub(crate) transforms: &'a [ObjectTransform],
    pub(crate) materials: &'a [Material],
    pub(crate) faces: &'a [Faces],
}

/// One mesh in the world's space of several, with the owner of each triangle.
fn gather(
    sources: &[Source],
    offset: DVec3,
    options: &PrepareOptions,
) -> Result<(TriangleMesh, Vec<u32>, Vec<Member>), SceneError> {
    let total = |count: fn(&MeshData) -> usize| {
        sources.iter().fold(0usize, |sum, s| sum.saturating_add(count(s.mesh.data())))
    };
    let (corners, triangles) = (total(|d| d.positions.len()), total(|d| d.triangles.len()));
    let mut data = MeshData::default();
    let mut owners = Vec::new();
    let bytes = (corners as u64).saturating_mul(12).saturating_add((triangles as u64).saturating_mul(16));
    options.limits.memory.need(bytes, || format!("{triangles} triangles in one tree"))?;
    let room = corners < u32::MAX as usize
        && triangles < u32::MAX as usize
        && data.positions.try_reserve_exact(corners).is_ok()
        && data.triangles.try_reserve_exact(triangles).is_ok()
        && owners.try_reserve_exact(triangles).is_ok();
    if !room {
        let message = format!("there is no memory for {triangles} triangles in one tree");
        return Err(SceneError::new(ErrorCode::TooLarge, message));
    }
    let mut members = Vec::with_capacity(sources.len());
    for Source { mesh, to_world } in sources {
        let base = data.positions.len() as u32;
        let from = mesh.data();
        let exact = to_world.is_none() && offset == DVec3::ZERO;
        if exact {
            data.positions.extend_from_slice(&from.positions);
        } else {
            data.positions.extend(from.positions.iter().map(|p| {
                let p = DVec3::from(p.map(f64::from));
                let p = to_world.map_or(p, |t| t.transform_point3(p));
                (p - offset).as_vec3().to_array()
            }));
        }
        let side = to_world.map_or(1.0, |t| t.matrix3.determinant().signum());
        members.push(Member { start: data.triangles.len() as u32, side, exact });
        let member = members.len() as u32 - 1;
        owners.resize(owners.len() + from.triangles.len(), member);
        data.triangles.extend(from.triangles.iter().map(|t| t.map(|i| i + base)));
    }
    let (mesh, _) = TriangleMesh::build(&Arc::new(data), false, options)?;
    Ok((mesh, owners, members))
}

impl Merged {
    /// Gathers the meshes of some primitives, which come to stand from `first` on. Where `last` gathered the same meshes in the same places, its tree is shared;
    /// says whether it was not.
    pub(crate) fn build(
        members: &Members<'_>,
        offset: DVec3,
        last: Option<&Merged>,
        options: &PrepareOptions,
    ) -> Result<(Merged, bool), SceneError> {
        let Members { primitives, first, transforms, materials, faces } = *members;
        let (mut checked, mut opaque) = (false, true);
        let mut sources = Vec::with_capacity(primitives.len());
        for primitive in primitives {
            let Shape::Mesh(mesh) = &primitive.shape else { continue };
            let to_world = transforms.get(primitive.transform as usize).map(|t| t.to_world);
            sources.push(Source { mesh: mesh.clone(), to_world });
            match faces.get(primitive.faces as usize) {
                Some(f) => {
                    checked |= f.are_checked();
                    opaque &= f.are_opaque(materials);
                }
                None => opaque &= materials[primitive.material.index()].shadow() == ShadowKind::Opaque,
            }
        }
        let first = first as u32;
        let same = |last: &&Merged| {
            last.offset == offset
                && last.sources.len() == sources.len()
                && last.sources.iter().zip(&sources).all(|(a, b)| a.is(b))
        };
        if let Some(last) = last.filter(same) {
            return Ok((Merged { sources, first, checked, opaque, ..last.clone() }, false));
        }
        let (mesh, owners, members) = gather(&sources, offset, options)?;
        let (mesh, owners, members) = (Arc::new(mesh), owners.into(), members.into());
        Ok((Merged { mesh, offset, owners, members, sources, first, checked, opaque }, true))
    }

    /// Bytes it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.mesh.memory()
            + size_of_val(&self.owners[..])
            + size_of_val(&self.members[..])
            + size_of_val(&self.sources[..])
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
    pub(crate) fn is_merged_there(&self, ray: &Ray, hit: &Hit) -> bool {
        let primitive = &self.primitives[hit.primitive as usize];
        primitive.faces == NO_FACES
            || !self.faces[primitive.faces as usize].are_checked()
            || self.is_there(primitive, &self.to_object(primitive, ray), &hit.shape)
    }

    /// The nearest hit of the gathered meshes.
    #[inline]
    pub(crate) fn intersect_merged(&self, merged: &Merged, ray: &Ray) -> Option<Hit> {
        let moved = merged.ray(ray);
        let hit = merged.owned(&merged.mesh.intersect(&moved)?);
        if !merged.checked || self.is_merged_there(ray, &hit) {
            return Some(hit);
        }
        self.intersect_merged_behind(merged, ray)
    }

    /// The same, where the nearest triangle is not there.
    #[cold]
    pub(crate) fn intersect_merged_behind(&self, merged: &Merged, ray: &Ray) -> Option<Hit> {
        let accept = |hit: &ShapeHit| self.is_merged_there(ray, &merged.owned(hit));
        merged.mesh.intersect_where(&merged.ray(ray), &accept).map(|hit| merged.owned(&hit))
    }

    /// Whether a hit of the gathered meshes stops light; sets `tinted` where it lets some through.
    #[inline]
    pub(crate) fn merged_stops(&self, ray: &Ray, hit: &Hit, tinted: &Cell<bool>) -> bool {
        let primitive = &self.primitives[hit.primitive as usize];
        self.is_merged_there(ray, hit)
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
    pub(crate) fn merged_blocks(&self, merged: &Merged, ray: &Ray, tinted: &Cell<bool>) -> bool {
        let moved = merged.ray(ray);
        if merged.opaque {
            return merged.mesh.occludes(&moved);
        }
        let blocks = |hit: &ShapeHit| self.merged_stops(ray, &merged.owned(hit), tinted);
        merged.mesh.occludes_where(&moved, &blocks)
    }

    /// The triangle of a mesh that a hit is in the world, with what was taken from its positions and -1 where its transform mirrors; `None`
    /// where it does not stand in the world as it is.
    #[inline]
    pub(crate) fn placed_triangle(&self, hit: &Hit) -> Option<PlacedTriangle<'_>> {
        let primitive = &self.primitives[hit.primitive as usize];
        let Shape::Mesh(mesh) = &primitive.shape else { return None };
        if let Some(merged) = &self.merged
            && let Some(member) = merged.rounded(hit.primitive)
        {
            let part = hit.shape.part + member.start;
            let moved = Some((merged.offset, member.side));
            return Some(PlacedTriangle { own: mesh, mesh: &merged.mesh, part, moved });
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
        let merged = self.merged.as_ref()?;
        let member = merged.rounded(hit.primitive)?;
        let s = merged.mesh.surface(&ShapeHit { part: hit.shape.part + member.start, ..hit.shape });
        let p = s.p + merged.offset;
        let error = s.error + 4.0 * f64::EPSILON * merged.offset.abs().max_element();
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
        if let Some(merged) = &self.merged
            && let Some(member) = merged.rounded(index)
        {
            let corners = merged.mesh.triangle_corners(member.start + part)?;
            return Some((corners.map(|p| p + merged.offset), member.side));
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
