//! Selects the meshes of the static world mesh, and builds it: from scratch, or incrementally after an edit.

use std::collections::HashMap;
use std::sync::Arc;

use turner_bvh::Kept;

use super::{Base, Member, Part, Source, StaticWorldMesh};
use crate::material::{Material, ShadowKind};
use crate::math::{Bounds, DVec3};
use crate::scene::alpha_test::Faces;
use crate::scene::scene::{ObjectTransform, Primitive};
use crate::schema::{ErrorCode, MeshData, PrepareOptions, SceneError};
use crate::shape::extent::Extent;
use crate::shape::{Shape, TriangleMesh};

/// A mesh smaller than its distance from the offset by this factor keeps its own BVH: single precision would not show its
/// form.
const RATIO: f64 = 1024.0;

/// One smaller than the extent of the world mesh by this factor does so, too: the search is exact within 1/2¹⁷ of four
/// times the extent, which is then half of the mesh.
const WIDEST: f64 = 16384.0;

/// Meshes of more triangles keep their own BVH: they gain little, and their positions would need memory twice.
const MAX_MESH: usize = 1 << 22;

/// Limit of the triangles of repeated meshes: in a world mesh each placement takes memory.
const MAX_REPEATED: usize = 1 << 16;

/// The primitives to include, and the offset to subtract from positions.
pub(crate) fn choose(
    primitives: &[Primitive],
    bounds: &[Option<Bounds>],
    materials: &[Material],
) -> (Vec<bool>, DVec3) {
    let none = (vec![false; primitives.len()], DVec3::ZERO);
    let mut uses: HashMap<*const TriangleMesh, usize> = HashMap::new();
    for primitive in primitives {
        if let Shape::Mesh(mesh) = &primitive.shape {
            *uses.entry(Arc::as_ptr(mesh)).or_default() += 1;
        }
    }
    // The first placement decides for all placements of a mesh.
    let (mut repeated, mut allowed) = (0, HashMap::new());
    let mut candidates = Vec::new();
    for (i, primitive) in primitives.iter().enumerate() {
        let (Shape::Mesh(mesh), Some(b)) = (&primitive.shape, bounds[i]) else { continue };
        // Boundaries of media give way to surfaces that coincide with them, so their hits must be told apart; and with
        // them shadow rays would need the order of the hits in the whole world mesh.
        if materials[primitive.material.index()].is_boundary() {
            continue;
        }
        let pointer = Arc::as_ptr(mesh);
        let count = mesh.data().triangles.len();
        let allowed_mesh = *allowed.entry(pointer).or_insert_with(|| {
            let uses = uses.get(&pointer).copied().unwrap_or(1);
            let all = count.saturating_mul(uses);
            if uses == 1 {
                return count <= MAX_MESH;
            }
            let fits = repeated + all <= MAX_REPEATED;
            repeated += if fits { all } else { 0 };
            fits
        });
        if allowed_mesh && mesh.triangle_count() > 0 && !b.is_empty() && b.is_finite() {
            candidates.push((i, b));
        }
    }
    if candidates.len() < 2 {
        return none;
    }
    // Closer to the origin an offset gains less than three bits.
    let all = candidates.iter().fold(Bounds::EMPTY, |a, (_, b)| a.union(b));
    let far = all.center().abs().max_element() > 4.0 * all.size().max_element();
    let offset = if far { all.center() } else { DVec3::ZERO };
    let reach = |b: &Bounds| (b.min - offset).abs().max((b.max - offset).abs()).max_element();
    candidates.retain(|(_, b)| b.size().length() * RATIO >= reach(b));
    let sorted = |of: &dyn Fn(&Bounds) -> f64| {
        let mut values: Vec<f64> = candidates.iter().map(|(_, b)| of(b)).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (sizes, reaches) = (sorted(&|b| b.size().length()), sorted(&reach));
    // The extent at which the fewest meshes keep their own BVH: a wide floor under small things, or the small things.
    let own = |(i, extent): (usize, &f64)| {
        let larger = reaches.len() - 1 - i;
        (larger + sizes.partition_point(|size| size * WIDEST < *extent), *extent)
    };
    let fewest = reaches.iter().enumerate().rev().map(own).min_by_key(|(count, _)| *count);
    let extent = fewest.map_or(0.0, |(_, extent)| extent);
    candidates.retain(|(_, b)| reach(b) <= extent && b.size().length() * WIDEST >= extent);
    if candidates.len() < 2 {
        return none;
    }
    let mut chosen = none.0;
    for (i, _) in candidates {
        chosen[i] = true;
    }
    (chosen, offset)
}

/// The primitives whose meshes are included, and the arrays that they refer to.
#[derive(Clone, Copy)]
pub(crate) struct Members<'a> {
    pub(crate) primitives: &'a [Primitive],
    /// Index of the first among the scene's primitives.
    pub(crate) first: usize,
    pub(crate) transforms: &'a [ObjectTransform],
    pub(crate) materials: &'a [Material],
    pub(crate) faces: &'a [Faces],
}

impl StaticWorldMesh {
    /// Builds the world mesh of some primitives, the first of which gets the index `first`. If `last` has the same
    /// meshes and transforms, its BVH is shared. If some differ, and `full` does not request a full build, the BVH is
    /// updated. The flag says whether anything differs.
    pub(crate) fn build(
        members: &Members<'_>,
        offset: DVec3,
        last: Option<&StaticWorldMesh>,
        whole: bool,
        options: &PrepareOptions,
    ) -> Result<(StaticWorldMesh, bool), SceneError> {
        let Members { primitives, first, transforms, materials, faces } = *members;
        let (mut alpha_tested, mut opaque) = (false, true);
        let mut sources = Vec::with_capacity(primitives.len());
        for primitive in primitives {
            let Shape::Mesh(mesh) = &primitive.shape else { continue };
            let to_world = transforms.get(primitive.transform as usize).map(|t| t.to_world);
            sources.push(Source { mesh: mesh.clone(), to_world });
            match faces.get(primitive.faces as usize) {
                Some(f) => {
                    alpha_tested |= f.need_test();
                    opaque &= f.are_opaque(materials);
                }
                None => opaque &= materials[primitive.material.index()].shadow() == ShadowKind::Opaque,
            }
        }
        let first = first as u32;
        let last = last.filter(|last| last.offset == offset && !(whole && last.base.is_some()));
        if let Some(last) = last.filter(|last| last.sources[..] == sources[..]) {
            return Ok((StaticWorldMesh { first, alpha_tested, opaque, ..last.clone() }, false));
        }
        let sources: Arc<[Source]> = sources.into();
        let changed = match last.filter(|_| !whole) {
            Some(last) => Gathered::changed(&sources, offset, last.base(), options)?,
            None => None,
        };
        let gathered = match changed {
            Some(changed) => changed,
            None => Gathered::whole(&sources, offset, options)?,
        };
        let Gathered { mesh, owners, members, parts, base } = gathered;
        Ok((
            StaticWorldMesh {
                mesh,
                offset,
                owners,
                members,
                parts,
                sources,
                base,
                first,
                alpha_tested,
                opaque,
            },
            true,
        ))
    }

    /// The base of later updates.
    fn base(&self) -> Base {
        self.base.clone().unwrap_or_else(|| Base {
            mesh: self.mesh.clone(),
            owners: self.owners.clone(),
            members: self.members.clone(),
            parts: self.parts.clone(),
            sources: self.sources.clone(),
        })
    }
}

/// A joined mesh, and its parts.
struct Gathered {
    mesh: Arc<TriangleMesh>,
    owners: Arc<[u32]>,
    members: Arc<[Member]>,
    parts: Arc<[Part]>,
    base: Option<Base>,
}

/// A BVH is updated while at most one in this many triangles was added, and one in this many removed. Beyond that,
/// building and searching the second BVH costs too much, and the first one holds too many unused triangles.
const CHANGED: usize = 8;

/// With fewer triangles a rebuild takes a few milliseconds.
const SMALL: usize = if cfg!(test) { 1 << 8 } else { 1 << 13 };

impl Gathered {
    /// Joins all meshes and builds a BVH.
    fn whole(sources: &[Source], offset: DVec3, options: &PrepareOptions) -> Result<Gathered, SceneError> {
        let mut data = reserved(sources, options)?;
        let mut owners = Vec::new();
        owners.try_reserve_exact(data.triangles.capacity()).map_err(|_| out_of_memory(sources))?;
        let (mut members, mut parts) = (Vec::with_capacity(sources.len()), Vec::with_capacity(sources.len()));
        for (i, source) in sources.iter().enumerate() {
            let (start, corner) = (data.triangles.len(), data.positions.len());
            source.add(offset, &mut data);
            owners.resize(data.triangles.len(), i as u32);
            let extent = Extent::of(&data.positions, &data.triangles[start..]);
            members.push(source.member(start, offset));
            parts.push(Part { corner: corner as u32, start: start as u32, extent });
        }
        let mesh = TriangleMesh::joined(Arc::new(data), &extent_of(&parts));
        mesh.build_tree(options)?;
        let (owners, members, parts) = (owners.into(), members.into(), parts.into());
        Ok(Gathered { mesh: Arc::new(mesh), owners, members, parts, base: None })
    }

    /// Keeps the BVH of `base` for the meshes that it shares with `sources`; `None` if it shares too few, or if the
    /// BVH must be rebuilt.
    fn changed(
        sources: &[Source],
        offset: DVec3,
        base: Base,
        options: &PrepareOptions,
    ) -> Result<Option<Gathered>, SceneError> {
        if base.sources[..] == *sources {
            let Base { mesh, owners, members, parts, .. } = base;
            return Ok(Some(Gathered { mesh, owners, members, parts, base: None }));
        }
        let matches = base.matches(sources);
        let count = |source: &Source| source.mesh.data().triangles.len();
        let new = sources.iter().zip(&matches).filter(|(_, m)| m.is_none()).map(|(s, _)| count(s));
        let (new, all) = (new.sum::<usize>(), sources.iter().map(count).sum::<usize>());
        let kept = matches.iter().flatten().map(|from| count(&base.sources[*from])).sum::<usize>();
        let removed = base.owners.len() - kept;
        if all < SMALL || new > all / CHANGED || removed > all / CHANGED {
            return Ok(None);
        }
        let mut data = reserved(sources, options)?;
        let (mut members, mut parts) = (Vec::with_capacity(sources.len()), Vec::with_capacity(sources.len()));
        let mut kept: Vec<Kept> = Vec::new();
        let mut gone = vec![true; base.parts.len()];
        for (source, from) in sources.iter().zip(&matches) {
            let (start, corner) = (data.triangles.len(), data.positions.len());
            let extent = match *from {
                Some(from) => {
                    gone[from] = false;
                    base.copy(from, source, &mut data, &mut kept);
                    base.parts[from].extent
                }
                None => {
                    source.add(offset, &mut data);
                    Extent::of(&data.positions, &data.triangles[start..])
                }
            };
            members.push(source.member(start, offset));
            parts.push(Part { corner: corner as u32, start: start as u32, extent });
        }
        let gone = base.parts.iter().zip(gone).filter(|(_, gone)| *gone);
        let gone = gone.fold(Bounds::EMPTY, |all, (part, _)| all.union(&part.extent.bounds));
        let mesh = TriangleMesh::joined(Arc::new(data), &extent_of(&parts));
        if !mesh.share_tree(&base.mesh, &kept, &gone, options)? {
            return Ok(None);
        }
        let same = parts.len() == base.parts.len()
            && mesh.data().triangles.len() == base.owners.len()
            && parts.iter().zip(&base.parts[..]).all(|(a, b)| a.start == b.start);
        let owners = match same {
            true => base.owners.clone(),
            false => owners(&parts, mesh.data().triangles.len()).into(),
        };
        let (members, parts) = (members.into(), parts.into());
        Ok(Some(Gathered { mesh: Arc::new(mesh), owners, members, parts, base: Some(base) }))
    }
}

/// For each triangle its part.
fn owners(parts: &[Part], count: usize) -> Vec<u32> {
    let ends = parts.iter().skip(1).map(|part| part.start as usize).chain([count]);
    let mut owners = Vec::with_capacity(count);
    for (i, end) in ends.enumerate() {
        owners.resize(end, i as u32);
    }
    owners
}

fn extent_of(parts: &[Part]) -> Extent {
    parts.iter().fold(Extent::EMPTY, |all, part| all.union(&part.extent))
}

impl Base {
    /// For each source the same one in the base, in ascending order.
    fn matches(&self, sources: &[Source]) -> Vec<Option<usize>> {
        let mut places: HashMap<_, Vec<usize>> = HashMap::new();
        for (i, source) in self.sources.iter().enumerate() {
            places.entry(source.key()).or_default().push(i);
        }
        let mut next = 0;
        let found = sources.iter().map(|source| {
            let places = places.get(&source.key())?;
            let place = *places.get(places.partition_point(|i| *i < next))?;
            next = place + 1;
            Some(place)
        });
        found.collect()
    }

    /// Appends a part of the base.
    fn copy(&self, index: usize, source: &Source, data: &mut MeshData, kept: &mut Vec<Kept>) {
        let (from, part) = (self.mesh.data(), &self.parts[index]);
        let (corners, triangles) = (source.mesh.data().positions.len(), source.mesh.data().triangles.len());
        let (start, corner) = (part.start as usize, part.corner as usize);
        let to = data.triangles.len() as u32;
        let by = (data.positions.len() as u32).wrapping_sub(part.corner);
        data.positions.extend_from_slice(&from.positions[corner..corner + corners]);
        let copied = &from.triangles[start..start + triangles];
        match by {
            0 => data.triangles.extend_from_slice(copied),
            by => data.triangles.extend(copied.iter().map(|t| t.map(|i| i.wrapping_add(by)))),
        }
        match kept.last_mut() {
            Some(last) if last.from + last.count == part.start && last.to + last.count == to => {
                last.count += triangles as u32;
            }
            _ => kept.push(Kept { from: part.start, to, count: triangles as u32 }),
        }
    }
}

impl Source {
    /// Appends its mesh in world space.
    fn add(&self, offset: DVec3, data: &mut MeshData) {
        let (from, base) = (self.mesh.data(), data.positions.len() as u32);
        if self.is_exact(offset) {
            data.positions.extend_from_slice(&from.positions);
        } else {
            data.positions.extend(from.positions.iter().map(|p| {
                let p = DVec3::from(p.map(f64::from));
                let p = self.to_world.map_or(p, |t| t.transform_point3(p));
                (p - offset).as_vec3().to_array()
            }));
        }
        data.triangles.extend(from.triangles.iter().map(|t| t.map(|i| i + base)));
    }

    fn is_exact(&self, offset: DVec3) -> bool {
        self.to_world.is_none() && offset == DVec3::ZERO
    }

    fn member(&self, start: usize, offset: DVec3) -> Member {
        let side = self.to_world.map_or(1.0, |t| t.matrix3.determinant().signum());
        Member { start: start as u32, side, exact: self.is_exact(offset) }
    }

    /// A key that is equal for the same mesh with the same transform.
    fn key(&self) -> (*const TriangleMesh, Option<[u64; 12]>) {
        (Arc::as_ptr(&self.mesh), self.to_world.map(|t| t.to_cols_array().map(f64::to_bits)))
    }
}

impl PartialEq for Source {
    fn eq(&self, other: &Source) -> bool {
        self.key() == other.key()
    }
}

/// An empty mesh with reserved memory.
fn reserved(sources: &[Source], options: &PrepareOptions) -> Result<MeshData, SceneError> {
    let (corners, triangles) = sizes(sources);
    let bytes = (corners as u64).saturating_mul(12).saturating_add((triangles as u64).saturating_mul(16));
    options.limits.memory.need(bytes, || format!("{triangles} triangles in one BVH"))?;
    let mut data = MeshData::default();
    let reserved = corners < u32::MAX as usize
        && triangles < u32::MAX as usize
        && data.positions.try_reserve_exact(corners).is_ok()
        && data.triangles.try_reserve_exact(triangles).is_ok();
    if reserved { Ok(data) } else { Err(out_of_memory(sources)) }
}

/// Total corners and triangles.
fn sizes(sources: &[Source]) -> (usize, usize) {
    let total = |count: fn(&MeshData) -> usize| {
        sources.iter().fold(0usize, |sum, s| sum.saturating_add(count(s.mesh.data())))
    };
    (total(|d| d.positions.len()), total(|d| d.triangles.len()))
}

fn out_of_memory(sources: &[Source]) -> SceneError {
    let message = format!("not enough memory for {} triangles in one BVH", sizes(sources).1);
    SceneError::new(ErrorCode::TooLarge, message)
}
