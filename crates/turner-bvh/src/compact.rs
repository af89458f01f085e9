//! The tree over triangles that holds no copies of them.

use crate::build::wide::WideTree;
use crate::bvh::scaled;
use crate::node::{ChildRef, WideNode};
use crate::search;
use crate::simd::Simd;
use crate::traverse::{Leaves, SearchRay, Space, Tree};
use crate::triangle::{BLOCK, block};
use crate::{BuildError, BuildOptions, BuildStats, Hit, Ray, Triangles};

/// A tree whose leaves name triangles of a mesh that somebody else keeps: 9 to 11 bytes per triangle, a fifth of
/// what a [`Bvh`](crate::Bvh) takes. Rays are slower, for corners are gathered from all over the mesh. Hits are the same, bit for bit.
#[derive(Clone, Debug)]
pub struct CompactBvh {
    nodes: Vec<WideNode>,
    slots: Vec<u32>,
    space: Space,
    stats: BuildStats,
    /// What the mesh had when the tree was built.
    counts: [usize; 2],
}

/// Leaves that name triangles.
struct Named<'a> {
    mesh: Triangles<'a>,
    scale: f32,
    slots: &'a [u32],
}

impl CompactBvh {
    /// Builds the tree.
    pub fn build(mesh: &Triangles<'_>, options: &BuildOptions<'_>) -> Result<CompactBvh, BuildError> {
        let (WideTree { nodes, slots, mut stats }, space) =
            scaled(mesh, options, crate::build::wide::build_best)?;
        stats.bytes = size_of_val(&nodes[..]) + size_of_val(&slots[..]);
        Ok(CompactBvh { nodes, slots, space, stats, counts: [mesh.positions.len(), mesh.triangles.len()] })
    }

    /// The size and the quality of the tree; `bytes` without the mesh.
    pub fn stats(&self) -> &BuildStats {
        &self.stats
    }

    fn named<'a>(&'a self, mesh: &Triangles<'a>) -> Named<'a> {
        assert_eq!(self.counts, [mesh.positions.len(), mesh.triangles.len()], "not the mesh of this tree");
        Named { mesh: *mesh, scale: self.space.scale, slots: &self.slots }
    }

    fn tree<'a>(&'a self, leaves: &'a Named<'a>) -> Tree<'a, Named<'a>> {
        Tree { nodes: &self.nodes, leaves, space: self.space }
    }

    /// The nearest hit. `mesh` is the one that the tree was built over, unchanged; with another one hits are any.
    ///
    /// # Panics
    ///
    /// If the mesh has not as many vertices or triangles as that one; so do all searches.
    pub fn intersect(&self, mesh: &Triangles<'_>, ray: &Ray) -> Option<Hit> {
        search::closest(self.tree(&self.named(mesh)), ray).some()
    }

    /// Whether anything is hit.
    pub fn occluded(&self, mesh: &Triangles<'_>, ray: &Ray) -> bool {
        search::any(self.tree(&self.named(mesh)), ray)
    }

    /// The nearest hits of many rays.
    pub fn intersect_batch(&self, mesh: &Triangles<'_>, rays: &[Ray], hits: &mut [Hit]) {
        search::closest_batch(self.tree(&self.named(mesh)), rays, hits);
    }

    /// Whether each of many rays hits anything.
    pub fn occluded_batch(&self, mesh: &Triangles<'_>, rays: &[Ray], hits: &mut [bool]) {
        search::any_batch(self.tree(&self.named(mesh)), rays, hits);
    }
}

impl Named<'_> {
    /// The triangles of block `i` of a leaf.
    #[inline(always)]
    fn ids(&self, leaf: ChildRef, i: usize) -> &[u32] {
        let first = (leaf.first_block() + i) * BLOCK;
        &self.slots[first..first + BLOCK]
    }
}

impl Leaves for Named<'_> {
    #[inline(always)]
    fn closest<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, _: u32, hit: &mut Hit) {
        let mut i = 0;
        while i < leaf.blocks() {
            let block = block(&self.mesh, self.scale, self.ids(leaf, i));
            block.closest(simd, &ray.shear, ray.t_min, hit, |_| true);
            i += 1;
        }
    }

    #[inline(always)]
    fn any<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, _: u32) -> bool {
        let mut i = 0;
        while i < leaf.blocks() {
            let block = block(&self.mesh, self.scale, self.ids(leaf, i));
            if block.any(simd, &ray.shear, ray.t_min, ray.t_max, |_| true) {
                return true;
            }
            i += 1;
        }
        false
    }

    #[inline(always)]
    fn address(&self, leaf: ChildRef) -> *const u8 {
        self.slots.as_ptr().wrapping_add(leaf.first_block() * BLOCK).cast()
    }
}
