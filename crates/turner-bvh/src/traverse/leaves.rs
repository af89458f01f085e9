//! Access to the primitives in leaves.

use super::SearchRay;
use crate::Hit;
use crate::node::ChildRef;
use crate::simd::Simd;
use crate::triangle::Block;

/// The leaves of a BVH.
pub(crate) trait Leaves {
    /// Updates `hit` with the nearest hit in a leaf; `hit.t` is the end of the ray's interval. Filters get `ray_index`.
    fn closest<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32, hit: &mut Hit);

    /// Whether there is any hit up to `ray.t_max`.
    fn any<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32) -> bool;

    /// Address of a leaf, for prefetching. Also called with references to nodes, whose result is ignored: that is
    /// cheaper than a branch.
    fn address(&self, leaf: ChildRef) -> *const u8;
}

/// Leaves that packets can test.
pub(crate) trait PacketLeaves: Leaves {
    /// Whether a filter must be asked about hits.
    fn is_filtered(&self) -> bool;

    /// The blocks of all leaves.
    fn all(&self) -> &[Block];

    /// The blocks of a leaf.
    fn blocks(&self, leaf: ChildRef) -> &[Block];

    /// Whether the filter accepts a hit, in the caller's units.
    fn accepts(&self, ray_index: u32, hit: &Hit) -> bool;
}

/// Leaves of triangle blocks. `filter` gets the ray's index and a hit in the caller's units and returns whether to
/// accept it.
#[derive(Clone, Copy)]
pub(crate) struct Blocks<'a, F> {
    pub(crate) blocks: &'a [Block],
    pub(crate) filter: F,
    /// False if the filter accepts everything.
    pub(crate) filtered: bool,
}

impl<F: Fn(u32, &Hit) -> bool> Blocks<'_, F> {
    #[inline(always)]
    fn of(&self, leaf: ChildRef) -> &[Block] {
        let (first, count) = (leaf.first_block(), leaf.blocks());
        debug_assert!(first + count <= self.blocks.len());
        // SAFETY: builders only create leaves of existing blocks.
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
        // A loop instead of `Iterator::any`, whose closure might not be inlined.
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
