//! One ray at a time.

use super::stack::Stack;
use super::{Leaves, SearchRay, Tree};
use crate::Hit;
use crate::node::ChildRef;
use crate::simd::{Lanes, Simd};

/// The nearest hit; its t is still that of the tree.
#[inline(always)]
pub(crate) fn closest<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, ray: &SearchRay, index: u32) -> Hit {
    let mut hit = Hit { t: ray.t_max, ..Hit::MISS };
    if tree.nodes.is_empty() {
        return hit;
    }
    let mut stack = Stack::new();
    let mut child = ChildRef::node(0);
    loop {
        if child.is_leaf() {
            tree.leaves.closest(simd, child, ray, index, &mut hit);
        } else {
            let node = tree.node(child);
            let (near, far) = ray.meets(simd, node, hit.t);
            let met = near.le(far);
            if met & met.wrapping_sub(1) == 0 {
                if met != 0 {
                    // One child: straight on.
                    child = node.children[met.trailing_zeros() as usize & 7];
                    continue;
                }
            } else {
                let count = simd.push_ordered(
                    near,
                    far,
                    node.child_words(),
                    node.order[ray.octant as usize & 7],
                    stack.room(),
                );
                stack.grow(count);
                // The top is the nearest: no need to compare it.
                let Some((word, _)) = stack.pop() else { return hit };
                child = ChildRef(word);
                continue;
            }
        }
        loop {
            let Some((word, near)) = stack.pop() else { return hit };
            if near <= hit.t {
                child = ChildRef(word);
                break;
            }
        }
    }
}

/// Whether there is any hit.
#[inline(always)]
pub(crate) fn any<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, ray: &SearchRay, index: u32) -> bool {
    if tree.nodes.is_empty() {
        return false;
    }
    let mut stack = Stack::new();
    let mut child = ChildRef::node(0);
    loop {
        if child.is_leaf() {
            if tree.leaves.any(simd, child, ray, index) {
                return true;
            }
        } else {
            let node = tree.node(child);
            let (near, far) = ray.meets(simd, node, ray.t_max);
            let count = simd.push_any(near.le(far), node.child_words(), stack.room().0);
            stack.grow(count);
        }
        let Some(word) = stack.pop_child() else { return false };
        child = ChildRef(word);
    }
}
