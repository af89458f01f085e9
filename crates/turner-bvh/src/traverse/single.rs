//! Traversal with one ray: depth first, nearest child first, with a stack.

use super::stack::Stack;
use super::{GROUP, Leaves, SearchRay, Tree, prepare};
use crate::node::ChildRef;
use crate::simd::{Lanes, Simd};
use crate::{Hit, Ray};

/// The nearest hit, with t in the units of the BVH.
#[inline(always)]
pub(crate) fn closest<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, ray: &SearchRay, index: u32) -> Hit {
    let mut hit = Hit { t: ray.t_max, ..Hit::MISS };
    if !tree.nodes.is_empty() {
        let mut stack = Stack::new();
        stack.push(ChildRef::node(0).0, 0.0);
        continue_closest(simd, tree, ray, index, &mut stack, &mut hit);
    }
    hit
}

/// Continues a traversal: searches the stack for a hit nearer than `hit`.
#[inline(always)]
pub(crate) fn continue_closest<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    ray: &SearchRay,
    index: u32,
    stack: &mut Stack,
    hit: &mut Hit,
) {
    loop {
        let Some((word, near)) = stack.pop() else { return };
        if near > hit.t {
            continue;
        }
        let mut child = ChildRef(word);
        // Down to a leaf, always to the nearest child, whose entry needs no comparison.
        while !child.is_leaf() {
            let node = tree.node(child);
            let slabs = ray.slabs(simd);
            let (near, far) = slabs.intersect(simd, node, hit.t);
            let hits = near.le(far);
            if hits & hits.wrapping_sub(1) == 0 {
                if hits == 0 {
                    child = ChildRef::EMPTY;
                    break;
                }
                // A single child needs no stack.
                child = node.children[hits.trailing_zeros() as usize & 7];
                continue;
            }
            let order = node.order[slabs.octant];
            let count = simd.push_ordered(near, far, node.child_words(), order, stack.room());
            stack.grow(count);
            child = ChildRef(stack.take());
        }
        tree.leaves.closest(simd, child, ray, index, hit);
    }
}

/// Whether there is any hit.
#[inline(always)]
pub(crate) fn any<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, ray: &SearchRay, index: u32) -> bool {
    if tree.nodes.is_empty() {
        return false;
    }
    let mut stack = Stack::new();
    stack.push(ChildRef::node(0).0, 0.0);
    continue_any(simd, tree, ray, index, &mut stack)
}

/// Continues an any-hit traversal with the entries of the stack.
#[inline(always)]
pub(crate) fn continue_any<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    ray: &SearchRay,
    index: u32,
    stack: &mut Stack,
) -> bool {
    loop {
        let Some(word) = stack.pop_child() else { return false };
        let child = ChildRef(word);
        if child.is_leaf() {
            if tree.leaves.any(simd, child, ray, index) {
                return true;
            }
        } else {
            let node = tree.node(child);
            let slabs = ray.slabs(simd);
            let (near, far) = slabs.intersect(simd, node, ray.t_max);
            let count = simd.push_any(near.le(far), node.child_words(), stack.room().0);
            stack.grow(count);
        }
    }
}

/// The nearest hits of many rays, one ray after the other; the first has index `first`.
#[inline(always)]
pub(crate) fn closest_each<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    mut first: usize,
    hits: &mut [Hit],
) {
    let mut ready = [SearchRay::NONE; GROUP];
    for (rays, hits) in rays.chunks(GROUP).zip(hits.chunks_mut(GROUP)) {
        let usable = prepare(simd, rays, &tree.space, &mut ready);
        for (i, (ray, hit)) in ready.iter().zip(hits).enumerate() {
            *hit = if usable >> i & 1 != 0 {
                ray.finish(closest(simd, tree, ray, (first + i) as u32))
            } else {
                Hit::MISS
            };
        }
        first += GROUP;
    }
}

/// Whether each of many rays hits anything, one ray after the other; the first has index `first`.
#[inline(always)]
pub(crate) fn any_each<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    mut first: usize,
    hits: &mut [bool],
) {
    let mut ready = [SearchRay::NONE; GROUP];
    for (rays, hits) in rays.chunks(GROUP).zip(hits.chunks_mut(GROUP)) {
        let usable = prepare(simd, rays, &tree.space, &mut ready);
        for (i, (ray, hit)) in ready.iter().zip(hits).enumerate() {
            *hit = usable >> i & 1 != 0 && any(simd, tree, ray, (first + i) as u32);
        }
        first += GROUP;
    }
}
