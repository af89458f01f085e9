//! Rays that have nothing in common: several in turn, one step each.
//!
//! A step of one ray waits for memory, for its own last step, and for guessed branches; meanwhile the processor works
//! on the next rays' steps. So each step is a short piece of code with few branches.

use std::hint::select_unpredictable;

use super::stack::Stack;
use super::{Leaves, SearchRay, Tree};
use crate::node::ChildRef;
use crate::simd::{Lanes, Simd};
use crate::{Hit, Ray};

/// Rays under way at once.
const WAYS: usize = 4;

/// In place of a ray's number.
const NOBODY: usize = usize::MAX;

/// One ray under way.
struct Way {
    ray: SearchRay,
    hit: Hit,
    index: usize,
    stack: Stack,
}

/// Finds the nearest hit of each ray.
#[inline(always)]
pub(crate) fn closest_batch<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    run::<S, L, false>(simd, tree, rays, |index, hit| hits[index] = hit);
}

/// Finds whether each ray hits anything.
#[inline(always)]
pub(crate) fn any_batch<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    run::<S, L, true>(simd, tree, rays, |index, hit| hits[index] = hit.is_hit());
}

#[inline(always)]
fn run<S: Simd, L: Leaves, const ANY: bool>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    mut found: impl FnMut(usize, Hit),
) {
    let mut ways: [Way; WAYS] = std::array::from_fn(|_| Way {
        ray: SearchRay::NONE,
        hit: Hit::MISS,
        index: NOBODY,
        stack: Stack::new(),
    });
    // Those under way come first. At the start all are, on behalf of nobody, and over at once.
    let mut order: [usize; WAYS] = std::array::from_fn(|i| i);
    let mut active = WAYS;
    let mut next = 0;
    while active > 0 {
        let mut i = 0;
        while i < active {
            let way = &mut ways[order[i] % WAYS];
            if step::<S, L, ANY>(simd, tree, way) {
                i += 1;
                continue;
            }
            if way.index != NOBODY {
                found(way.index, way.ray.finish(way.hit));
            }
            loop {
                let Some(ray) = rays.get(next) else {
                    active -= 1;
                    order.swap(i, active);
                    break;
                };
                let index = next;
                next += 1;
                match SearchRay::new(simd, ray, &tree.space) {
                    Some(ray) if !tree.nodes.is_empty() => {
                        way.hit = Hit { t: ray.t_max, ..Hit::MISS };
                        way.ray = ray;
                        way.index = index;
                        way.stack.clear();
                        way.stack.push(ChildRef::node(0).0, 0.0);
                        i += 1;
                        break;
                    }
                    _ => found(index, Hit::MISS),
                }
            }
        }
    }
}

/// One step: takes the nearest child left. False when the search is over.
#[inline(always)]
fn step<S: Simd, L: Leaves, const ANY: bool>(simd: S, tree: &Tree<'_, L>, way: &mut Way) -> bool {
    let Some((word, near)) = way.stack.pop() else { return false };
    if !ANY && near > way.hit.t {
        return !way.stack.is_empty();
    }
    let child = ChildRef(word);
    if child.is_leaf() {
        let index = way.index as u32;
        if !ANY {
            tree.leaves.closest(simd, child, &way.ray, index, &mut way.hit);
        } else if tree.leaves.any(simd, child, &way.ray, index) {
            way.hit.primitive = 0;
            return false;
        }
    } else {
        let node = tree.node(child);
        let (near, far) = way.ray.meets(simd, node, way.hit.t);
        let count = if ANY {
            simd.push_any(near.le(far), node.child_words(), way.stack.room().0)
        } else {
            let order = node.order[way.ray.octant as usize & 7];
            simd.push_ordered(near, far, node.child_words(), order, way.stack.room())
        };
        way.stack.grow(count);
    }
    let Some(word) = way.stack.top() else { return false };
    // Without a branch: it would be guessed, and the guess is proved only when this step's work is done.
    let child = ChildRef(word);
    let node: *const u8 = tree.nodes.as_ptr().wrapping_add(child.index()).cast();
    simd.prefetch(select_unpredictable(child.is_leaf(), tree.leaves.address(child), node));
    true
}
