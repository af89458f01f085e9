//! A BVH for a mesh in which some triangles changed: the others keep their nodes and blocks.
//!
//! Leaves with a changed triangle are removed from a copy of the nodes; the blocks are shared. The unchanged triangles
//! of those leaves and the new triangles go into a small second BVH:
//!
//! ```text
//!          copy of the nodes               second BVH over
//!            /    |    \                   what the removed leaves still need
//!        leaf   (cut)   leaf      +        and the new triangles
//!         |               |
//!       blocks, shared with the old BVH
//! ```
//!
//! Each ray traverses the first BVH, then the second one up to its nearest hit so far. The hits are those of a BVH
//! built over the complete new mesh, bit for bit: the nearest t, then the lowest index, computed by the same arithmetic
//! on the same vertices. A change costs the time to copy the nodes (an eighth of the BVH) and to build the small one.

use std::sync::Arc;

use crate::build::wide::{self, Source, WideTree, set_order};
use crate::bvh::{MIN_REACH, scale_of};
use crate::node::{ChildRef, WideNode};
use crate::search;
use crate::traverse::{Blocks, Space, Tree};
use crate::triangle::{Block, fill_blocks};
use crate::{Aabb, BuildError, BuildOptions, Bvh, Hit, Ray, Triangles};

/// A run of triangles that a new mesh shares with the old one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Index of the first triangle in the mesh that the BVH was built over.
    pub from: u32,
    /// Index of the first triangle in the new mesh.
    pub to: u32,
    /// Number of triangles.
    pub count: u32,
}

/// A mesh that shares triangles with the mesh of an existing BVH.
#[derive(Clone, Copy)]
pub struct ChangedMesh<'a> {
    /// Number of triangles in the new mesh.
    pub count: u32,
    /// The runs that both meshes share, ascending in both.
    pub kept: &'a [Kept],
    /// Bounds of the old triangles that are not kept.
    pub gone: Aabb,
    /// The largest absolute value of a finite coordinate in the new mesh.
    pub farthest: f32,
    /// Vertices of a triangle of the new mesh; `None` for a triangle that rays ignore.
    pub corners: &'a dyn Fn(u32) -> Option<[[f32; 3]; 3]>,
}

/// The second part of a changed BVH.
#[derive(Clone, Debug)]
pub(crate) struct Changed {
    /// The BVH over moved and new triangles.
    nodes: Vec<WideNode>,
    blocks: Vec<Block>,
    /// Maps an old triangle index to its new index; `None` if no index changed.
    index_map: Option<Vec<u32>>,
}

/// BVHs of at most this many blocks are rebuilt instead. Up to half a packet (eight blocks), traversal tests all blocks
/// without visiting nodes and would still hit the triangles of removed leaves.
const MIN_BLOCKS: usize = 16;

/// Rays traced at a time in the second BVH; their copies are on the stack.
const CHUNK: usize = 256;

/// A dynamic filter, so that all callers share one copy of the traversal code.
type Filter<'a> = &'a dyn Fn(u32, &Hit) -> bool;
type Leaves<'a> = Blocks<'a, Filter<'a>>;

impl Bvh {
    /// Returns the BVH of a mesh that differs in some triangles from the one this BVH was built over. Returns `None` if
    /// the BVH must be rebuilt: it is small, it was changed before, or the new mesh needs another scale because its
    /// size differs too much.
    ///
    /// Queries take a little longer than in a freshly built BVH. Use it during editing and for changes to small parts
    /// of a mesh.
    pub fn changed(
        &self,
        mesh: &ChangedMesh<'_>,
        options: &BuildOptions<'_>,
    ) -> Result<Option<Bvh>, BuildError> {
        if self.changed.is_some() || self.blocks.len() <= MIN_BLOCKS {
            return Ok(None);
        }
        let scale = self.space.scale;
        let index_map = IndexMap { kept: mesh.kept };
        let mut cut = Cut {
            blocks: &self.blocks,
            gone: Aabb { min: mesh.gone.min.map(|x| x * scale), max: mesh.gone.max.map(|x| x * scale) },
            index_map: &index_map,
            orphans: Vec::new(),
        };
        let mut nodes = self.nodes.clone();
        cut.node(&mut nodes, 0);
        let mut ids = cut.orphans;
        ids.extend(index_map.added(mesh.count).flatten());
        ids.sort_unstable();
        ids.dedup();
        let added = small_tree(&ids, mesh.corners, scale, options)?;
        let (base, small) = (Space::of(scale, &nodes), Space::of(scale, &added.0));
        let space = Space { reach: base.reach.max(small.reach), ..base };
        let first = scale_of(mesh.farthest);
        let reach = space.reach * space.unscale;
        let wanted = if first >= 1.0 || reach * first >= MIN_REACH { first } else { scale_of(reach) };
        if wanted != scale {
            return Ok(None);
        }
        let mut stats = self.stats;
        stats.blocks += added.1.len();
        stats.nodes += added.0.len();
        stats.bytes += size_of_val(&added.0[..]) + size_of_val(&added.1[..]);
        let index_map = index_map.table(self.triangles);
        let changed = Some(Box::new(Changed { nodes: added.0, blocks: added.1, index_map }));
        let blocks = Arc::clone(&self.blocks);
        let triangles = mesh.count;
        Ok(Some(Bvh {
            nodes,
            blocks,
            space,
            stats,
            changed,
            triangles,
            instruction_set: self.instruction_set,
        }))
    }
}

/// Builds a BVH over some triangles of a mesh; they keep their indices.
fn small_tree(
    ids: &[u32],
    corners: &dyn Fn(u32) -> Option<[[f32; 3]; 3]>,
    scale: f32,
    options: &BuildOptions<'_>,
) -> Result<(Vec<WideNode>, Vec<Block>), BuildError> {
    let (mut positions, mut index_map) = (Vec::with_capacity(3 * ids.len()), Vec::with_capacity(ids.len()));
    for &id in ids {
        if let Some(corners) = corners(id) {
            positions.extend(corners);
            index_map.push(id);
        }
    }
    let triangles: Vec<[u32; 3]> =
        (0..index_map.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Triangles { positions: &positions, triangles: &triangles };
    let source = Source::Triangles { positions: &positions, triangles: &triangles, scale };
    let WideTree { nodes, slots, .. } = wide::build_best(&source, options)?;
    let mut blocks = fill_blocks(&mesh, scale, &slots, options.threads)?;
    for id in blocks.iter_mut().flat_map(|block| &mut block.ids) {
        *id = index_map.get(*id as usize).copied().unwrap_or(wide::NO_PRIMITIVE);
    }
    Ok((nodes, blocks))
}

/// Maps triangle indices of the old mesh to those of the new mesh.
struct IndexMap<'a> {
    kept: &'a [Kept],
}

impl IndexMap<'_> {
    /// The new index of a triangle that is kept.
    fn of(&self, id: u32) -> Option<u32> {
        let after = self.kept.partition_point(|k| k.from <= id);
        let kept = self.kept.get(after.checked_sub(1)?)?;
        (id - kept.from < kept.count).then(|| kept.to + (id - kept.from))
    }

    /// The indices that exist only in the new mesh.
    fn added(&self, count: u32) -> impl Iterator<Item = std::ops::Range<u32>> {
        let ends = self.kept.iter().map(|k| k.to + k.count);
        let starts = self.kept.iter().map(|k| k.to).chain([count]);
        std::iter::once(0).chain(ends).zip(starts).map(|(start, end)| start..end)
    }

    /// The new index of each old triangle; `None` if no index changed.
    fn table(&self, count: u32) -> Option<Vec<u32>> {
        let moved = self.kept.iter().any(|k| k.from != k.to);
        moved.then(|| {
            let mut table = vec![Hit::NONE; count as usize];
            for k in self.kept {
                let from = k.from as usize..(k.from + k.count) as usize;
                for (to, number) in table[from].iter_mut().zip(k.to..) {
                    *to = number;
                }
            }
            table
        })
    }
}

/// Removes leaves that contain changed triangles.
struct Cut<'a> {
    blocks: &'a [Block],
    /// Bounds of the removed triangles, in scaled units.
    gone: Aabb,
    index_map: &'a IndexMap<'a>,
    /// New indices of kept triangles in removed leaves.
    orphans: Vec<u32>,
}

impl Cut<'_> {
    /// Removes leaves below a node. Returns the node's new bounds if they changed.
    fn node(&mut self, nodes: &mut [WideNode], index: usize) -> Option<Aabb> {
        let mut cut = false;
        for i in 0..8 {
            let (child, bounds) = (nodes[index].children[i], nodes[index].bounds(i));
            if child == ChildRef::EMPTY || !overlap(bounds, self.gone) {
                continue;
            }
            let left = match child.is_leaf() {
                true => self.leaf(child).then_some(Aabb::EMPTY),
                false => self.node(nodes, child.index()),
            };
            if let Some(left) = left {
                cut = true;
                let child = if left == Aabb::EMPTY { ChildRef::EMPTY } else { child };
                nodes[index].set(i, left, child);
            }
        }
        if !cut {
            return None;
        }
        let node = &mut nodes[index];
        set_order(node);
        let occupied = (0..8).filter(|i| node.children[*i] != ChildRef::EMPTY);
        Some(occupied.fold(Aabb::EMPTY, |all, i| all.union(node.bounds(i))))
    }

    /// Whether a leaf contains a removed triangle. If so, its kept triangles become orphans.
    fn leaf(&mut self, leaf: ChildRef) -> bool {
        let blocks = &self.blocks[leaf.first_block()..leaf.first_block() + leaf.blocks()];
        let ids = || blocks.iter().flat_map(|block| block.ids).filter(|id| *id != wide::NO_PRIMITIVE);
        let gone = ids().any(|id| self.index_map.of(id).is_none());
        if gone {
            self.orphans.extend(ids().filter_map(|id| self.index_map.of(id)));
        }
        gone
    }
}

fn overlap(a: Aabb, b: Aabb) -> bool {
    (0..3).all(|i| a.min[i] <= b.max[i] && b.min[i] <= a.max[i])
}

impl Changed {
    fn renumbered(&self, hit: &Hit) -> Hit {
        let number = |index_map: &Vec<u32>| index_map.get(hit.primitive as usize).copied();
        let primitive = self.index_map.as_ref().and_then(number).unwrap_or(hit.primitive);
        Hit { primitive, ..*hit }
    }
}

/// The traversal view of the first or the second BVH.
fn tree<'a, 'f>(bvh: &'a Bvh, nodes: &'a [WideNode], leaves: &'a Leaves<'f>) -> Tree<'a, Leaves<'f>> {
    Tree { nodes, leaves, space: bvh.space, instruction_set: bvh.instruction_set }
}

fn leaves<'f>(blocks: &'f [Block], filter: Filter<'f>) -> Leaves<'f> {
    Blocks { blocks, filter, filtered: true }
}

impl Bvh {
    /// The nearest hits of many rays in a changed BVH.
    pub(crate) fn closest_changed(
        &self,
        changed: &Changed,
        rays: &[Ray],
        hits: &mut [Hit],
        filter: Filter<'_>,
    ) {
        let old = |ray: u32, hit: &Hit| filter(ray, &changed.renumbered(hit));
        let old = leaves(&self.blocks, &old);
        search::closest_triangles(tree(self, &self.nodes, &old), rays, hits);
        let mut near = [Ray::new([0.0; 3], [0.0; 3]); CHUNK];
        let mut nearer = [Hit::MISS; CHUNK];
        for (part, (rays, hits)) in rays.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)).enumerate() {
            let (near, nearer) = (&mut near[..rays.len()], &mut nearer[..rays.len()]);
            for ((near, ray), hit) in near.iter_mut().zip(rays).zip(&mut *hits) {
                *hit = changed.renumbered(hit);
                let t_max = if hit.t < ray.t_max { hit.t } else { ray.t_max };
                *near = Ray { t_max, ..*ray };
            }
            let first = (part * CHUNK) as u32;
            let new = |ray: u32, hit: &Hit| filter(first + ray, hit);
            let new = leaves(&changed.blocks, &new);
            search::closest_triangles(tree(self, &changed.nodes, &new), near, nearer);
            for (hit, nearer) in hits.iter_mut().zip(nearer) {
                if nearer.t < hit.t || nearer.t == hit.t && nearer.primitive < hit.primitive {
                    *hit = *nearer;
                }
            }
        }
    }

    /// Whether each of many rays hits anything in a changed BVH.
    pub(crate) fn any_changed(&self, changed: &Changed, rays: &[Ray], hits: &mut [bool], filter: Filter<'_>) {
        let old = |ray: u32, hit: &Hit| filter(ray, &changed.renumbered(hit));
        let old = leaves(&self.blocks, &old);
        search::any_triangles(tree(self, &self.nodes, &old), rays, hits);
        let mut left = [Ray::new([0.0; 3], [0.0; 3]); CHUNK];
        let mut found = [false; CHUNK];
        for (part, (rays, hits)) in rays.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)).enumerate() {
            let (left, found) = (&mut left[..rays.len()], &mut found[..rays.len()]);
            for ((left, ray), hit) in left.iter_mut().zip(rays).zip(&*hits) {
                // Rays that already hit something get an empty interval.
                *left = if *hit { Ray { t_max: f32::NEG_INFINITY, ..*ray } } else { *ray };
            }
            let first = (part * CHUNK) as u32;
            let new = |ray: u32, hit: &Hit| filter(first + ray, hit);
            let new = leaves(&changed.blocks, &new);
            search::any_triangles(tree(self, &changed.nodes, &new), left, found);
            for (hit, found) in hits.iter_mut().zip(found) {
                *hit |= *found;
            }
        }
    }

    /// The nearest hit of one ray in a changed BVH.
    pub(crate) fn one_closest_changed(
        &self,
        changed: &Changed,
        ray: &Ray,
        filter: &dyn Fn(&Hit) -> bool,
    ) -> Hit {
        let old = |_: u32, hit: &Hit| filter(&changed.renumbered(hit));
        let old = leaves(&self.blocks, &old);
        let hit = changed.renumbered(&search::closest(tree(self, &self.nodes, &old), ray));
        let t_max = if hit.t < ray.t_max { hit.t } else { ray.t_max };
        let new = |_: u32, hit: &Hit| filter(hit);
        let new = leaves(&changed.blocks, &new);
        let nearer = search::closest(tree(self, &changed.nodes, &new), &Ray { t_max, ..*ray });
        let is_nearer = nearer.t < hit.t || nearer.t == hit.t && nearer.primitive < hit.primitive;
        if is_nearer { nearer } else { hit }
    }

    /// Whether one ray hits anything in a changed BVH.
    pub(crate) fn one_any_changed(
        &self,
        changed: &Changed,
        ray: &Ray,
        filter: &dyn Fn(&Hit) -> bool,
    ) -> bool {
        let old = |_: u32, hit: &Hit| filter(&changed.renumbered(hit));
        let old = leaves(&self.blocks, &old);
        let new = |_: u32, hit: &Hit| filter(hit);
        let new = leaves(&changed.blocks, &new);
        search::any(tree(self, &self.nodes, &old), ray) || search::any(tree(self, &changed.nodes, &new), ray)
    }
}

impl Changed {
    /// The nodes of the second BVH.
    pub(crate) fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }
}

#[cfg(test)]
#[path = "changed_tests.rs"]
mod tests;
