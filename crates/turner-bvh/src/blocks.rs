//! BVH over boxes for callers that test eight primitives at once.

use std::cell::RefCell;
use std::ops::Range;

use crate::build::wide::{self, NO_PRIMITIVE, Source};
use crate::custom::{Any, Nearest, reaches};
use crate::node::WideNode;
use crate::traverse::{Space, Tree};
use crate::{Aabb, BoxBvh, BuildError, BuildOptions, BuildStats, InstructionSet, Ray, search};

/// Primitives in a block.
const WIDTH: usize = 8;

/// A BVH over boxes of any primitives whose leaves are blocks of eight primitives: traversal yields ranges of blocks, and
/// the caller tests a block at once. Leaves are larger than those of a [`BoxBvh`], so that there are fewer nodes.
///
/// ```
/// use turner_bvh::{Aabb, BlockBvh, BuildOptions, Ray};
///
/// // Ten flat squares across the z axis.
/// let boxes: Vec<Aabb> = (0..10).map(|i| Aabb::new([-1.0, -1.0, i as f32], [1.0, 1.0, i as f32])).collect();
/// let (bvh, blocks) = BlockBvh::build(&boxes, &BuildOptions::default())?;
/// let ray = Ray::new([0.0, 0.0, 3.5], [0.0, 0.0, 1.0]);
/// let t = bvh.closest(&ray, |range, t_max| {
///     let ids = blocks[range.start as usize..range.end as usize].iter().flatten().filter(|id| **id != BlockBvh::NONE);
///     ids.map(|&id| id as f32 - 3.5).filter(|&t| t >= 0.0).fold(t_max, f32::min)
/// });
/// assert_eq!(t, 0.5);
/// # Ok::<(), turner_bvh::BuildError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BlockBvh {
    nodes: Vec<WideNode>,
    /// Number of blocks.
    blocks: u32,
    space: Space,
    stats: BuildStats,
    instruction_set: InstructionSet,
}

impl BlockBvh {
    /// Fills the last block of a leaf.
    pub const NONE: u32 = NO_PRIMITIVE;

    /// Builds the BVH. Returns it with the primitives of each block. Boxes that are not [valid](Aabb::is_valid) are omitted.
    pub fn build(
        boxes: &[Aabb],
        options: &BuildOptions<'_>,
    ) -> Result<(BlockBvh, Vec<[u32; WIDTH]>), BuildError> {
        let scale = BoxBvh::scale(boxes);
        let tree = wide::build(&Source::Boxes { boxes, scale, width: WIDTH }, options)?;
        let count = tree.slots.len() / WIDTH;
        let mut blocks = Vec::new();
        blocks
            .try_reserve_exact(count)
            .map_err(|_| BuildError::OutOfMemory { needed: size_of_val(&tree.slots[..]) })?;
        blocks.extend(tree.slots.chunks_exact(WIDTH).map(|ids| std::array::from_fn(|i| ids[i])));
        let bvh = BlockBvh {
            space: Space::of(scale, &tree.nodes),
            nodes: tree.nodes,
            blocks: count as u32,
            stats: tree.stats,
            instruction_set: options.instruction_set,
        };
        Ok((bvh, blocks))
    }

    /// Size and quality of the BVH.
    pub fn stats(&self) -> &BuildStats {
        &self.stats
    }

    /// The instruction set that traversal uses.
    pub fn instruction_set(&self) -> InstructionSet {
        self.instruction_set
    }

    /// Memory in bytes, without the blocks.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
    }

    fn tree<'a, L>(&'a self, leaves: &'a L) -> Tree<'a, L> {
        Tree { nodes: &self.nodes, leaves, space: self.space, instruction_set: self.instruction_set }
    }

    /// As [`BoxBvh::closest`]; `leaf` gets a range of blocks.
    #[inline]
    pub fn closest(&self, ray: &Ray, mut leaf: impl FnMut(Range<u32>, f32) -> f32) -> f32 {
        if !reaches(&self.space, ray) {
            let all = ray.is_valid() && self.blocks > 0;
            let t = if all { leaf(0..self.blocks, ray.t_max) } else { ray.t_max };
            return if t > ray.t_max { ray.t_max } else { t };
        }
        let rays = std::slice::from_ref(ray);
        let leaves = Nearest { rays, visit: RefCell::new(|_, range, t| leaf(range, t)), order: &[] };
        let hit = search::closest(self.tree(&leaves), ray);
        if hit.is_hit() { hit.u } else { ray.t_max }
    }

    /// As [`BoxBvh::any`]; `leaf` gets a range of blocks.
    #[inline]
    pub fn any(&self, ray: &Ray, mut leaf: impl FnMut(Range<u32>) -> bool) -> bool {
        if !reaches(&self.space, ray) {
            return ray.is_valid() && self.blocks > 0 && leaf(0..self.blocks);
        }
        let leaves = Any { visit: RefCell::new(|_, range| leaf(range)), order: &[] };
        search::any(self.tree(&leaves), ray)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BoxBvh;

    /// Every box is in one block, and the same boxes are visited as by a [`BoxBvh`].
    #[test]
    fn blocks_hold_every_box_once() {
        let mut state = 1_u32;
        let mut unit = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / 16_777_216.0
        };
        for count in [0, 1, 7, 8, 9, 500] {
            let mut boxes: Vec<Aabb> = (0..count)
                .map(|_| {
                    let p = [unit(), unit(), unit()];
                    Aabb::new(p, p.map(|x| x + 0.05))
                })
                .collect();
            if count > 8 {
                boxes[3] = Aabb::EMPTY;
            }
            let (bvh, blocks) = BlockBvh::build(&boxes, &BuildOptions::default()).unwrap();
            let one = BoxBvh::build(&boxes, &BuildOptions::default()).unwrap();
            let mut ids: Vec<u32> =
                blocks.iter().flatten().copied().filter(|id| *id != BlockBvh::NONE).collect();
            ids.sort_unstable();
            let valid = (0..count as u32).filter(|i| boxes[*i as usize].is_valid());
            assert_eq!(ids, valid.collect::<Vec<_>>());
            for _ in 0..200 {
                let ray = Ray::new([-1.0, unit(), unit()], [1.0, 0.3 * unit(), 0.3 * unit()]);
                // The entry of the line into a box, exact enough to compare.
                let entry = |id: u32| {
                    let b = &boxes[id as usize];
                    let at = |i: usize, p: f32| (p - ray.origin[i]) / ray.direction[i];
                    let near = (0..3).map(|i| at(i, b.min[i])).fold(0.0, f32::max);
                    let far = (0..3).map(|i| at(i, b.max[i])).fold(f32::INFINITY, f32::min);
                    if near <= far { near } else { f32::INFINITY }
                };
                let of = |range: Range<u32>| {
                    let ids = blocks[range.start as usize..range.end as usize].iter().flatten();
                    ids.filter(|id| **id != BlockBvh::NONE).map(|id| entry(*id)).fold(f32::INFINITY, f32::min)
                };
                let a = bvh.closest(&ray, |range, t| of(range).min(t));
                let b = one.closest(&ray, |range, t| {
                    let ids = &one.order()[range.start as usize..range.end as usize];
                    ids.iter().map(|id| entry(*id)).fold(t, f32::min)
                });
                assert_eq!(a, b);
                assert_eq!(bvh.any(&ray, |range| of(range) < f32::INFINITY), a < f32::INFINITY);
            }
        }
    }
}
