//! What leaves hold, and how a ray meets it.

use super::SearchRay;
use crate::Hit;
use crate::node::ChildRef;
use crate::simd::Simd;
use crate::triangle::Block;

/// The leaves of a tree.
pub(crate) trait Leaves {
    /// Takes the nearest hit of a leaf into `hit`, whose t is the end of the search. `ray_index` is for filters.
    fn closest<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32, hit: &mut Hit);

    /// Whether there is any hit until `ray.t_max`.
    fn any<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32) -> bool;

    /// Where a leaf's memory begins, to be asked for ahead of time. Called with references to nodes, too, whose result is
    /// not used: that costs less than to ask which it is.
    fn address(&self, leaf: ChildRef) -> *const u8;
}

/// Leaves that packets of rays search.
pub(crate) trait PacketLeaves: Leaves {
    /// Whether anything asks before a hit counts.
    fn is_filtered(&self) -> bool;

    /// The blocks of all leaves.
    fn all(&self) -> &[Block];

    /// The blocks of a leaf.
    fn blocks(&self, leaf: ChildRef) -> &[Block];

    /// Whether a ray's hit, in the caller's units, counts.
    fn accepts(&self, ray_index: u32, hit: &Hit) -> bool;
}

/// Leaves of triangles in blocks. `filter` gets the ray's number and a hit in the caller's units, and says whether it counts.
#[derive(Clone, Copy)]
pub(crate) struct Blocks<'a, F> {
    pub(crate) blocks: &'a [Block],
    pub(crate) filter: F,
    /// Whether it ever says no.
    pub(crate) filtered: bool,
}

impl<F: Fn(u32, &Hit) -> bool> Blocks<'_, F> {
    #[inline(always)]
    fn of(&self, leaf: ChildRef) -> &[Block] {
        let (first, count) = (leaf.first_block(), leaf.blocks());
        debug_assert!(first + count <= self.blocks.len());
        // SAFETY: builders make leaves of blocks that are there.
        unsafe { self.blocks.get_unchecked(first..first + count) }
    }
}

impl<F: Fn(u32, &Hit) -> bool> Leaves for Blocks<'_, F> {
    #[inline(always)]
    fn closest<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32, hit: &mut Hit) {
        for block in self.of(leaf) {
            block.closest(simd, &ray.shear, ray.t_min, hit, |h| (self.filter)(ray_index, &ray.finish(*h)));
        }
    }

    #[inline(always)]
    fn any<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32) -> bool {
        // Not by `Iterator::any`: what its closure calls need not be inlined.
        for block in self.of(leaf) {
            if block
                .any(simd, &ray.shear, ray.t_min, ray.t_max, |h| (self.filter)(ray_index, &ray.finish(*h)))
            {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn address(&self, leaf: ChildRef) -> *const u8 {
        self.blocks.as_ptr().wrapping_add(leaf.first_block()).cast()
    }
}

impl<F: Fn(u32, &Hit) -> bool> PacketLeaves for Blocks<'_, F> {
    #[inline(always)]
    fn is_filtered(&self) -> bool {
        self.filtered
    }

    #[inline(always)]
    fn all(&self) -> &[Block] {
        self.blocks
    }

    #[inline(always)]
    fn blocks(&self, leaf: ChildRef) -> &[Block] {
        self.of(leaf)
    }

    #[inline(always)]
    fn accepts(&self, ray_index: u32, hit: &Hit) -> bool {
        (self.filter)(ray_index, hit)
    }
}
