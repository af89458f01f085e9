//! Rays that have nothing in common: several in turn, one step each.
//!
//! A step of one ray waits for memory, for its own last step, and for guessed branches; meanwhile the processor works
//! on the next rays' steps. So each step is a short piece of code with few branches.

use super::stack::Stack;
use super::{Leaves, SearchRay, Tree};
use crate::node::ChildRef;
use crate::simd::Simd;
use crate::{Hit, Ray};

/// Rays under way at once.
const WAYS: usize = 4;

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
    let mut next = 0;
    // Starts the next ray that has anything to search; false if there is none left.
    let mut start = |way: &mut Way, found: &mut dyn FnMut(usize, Hit)| {
        while let Some(ray) = rays.get(next) {
            let index = next;
            next += 1;
            if let Some(ray) = SearchRay::new(ray, &tree.space)
                && !tree.nodes.is_empty()
            {
                way.hit = Hit { t: ray.t_max, ..Hit::MISS };
                way.ray = ray;
                way.index = index;
                way.stack.clear();
                way.stack.push(ChildRef::node(0).0, 0.0);
                return true;
            }
            found(index, Hit::MISS);
        }
        false
    };
    let mut ways: [Way; WAYS] =
        std::array::from_fn(|_| Way { ray: SearchRay::NONE, hit: Hit::MISS, index: 0, stack: Stack::new() });
    // Those under way come first.
    let mut order: [usize; WAYS] = std::array::from_fn(|i| i);
    let mut active = 0;
    while active < WAYS && start(&mut ways[active], &mut found) {
        active += 1;
    }
    while active > 0 {
        let mut i = 0;
        while i < active {
            let way = &mut ways[order[i] % WAYS];
            if step::<S, L, ANY>(simd, tree, way) {
                i += 1;
                continue;
            }
            found(way.index, way.ray.finish(way.hit));
            if start(way, &mut found) {
                i += 1;
            } else {
                active -= 1;
                order.swap(i, active);
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
        let (near, met) = way.ray.meets(simd, node, way.hit.t);
        let count = if ANY {
            simd.push_any(met, node.child_words(), way.stack.room().0)
        } else {
            let order = node.order[(way.ray.octant ^ 7) as usize & 7];
            simd.push_ordered(near, met, node.child_words(), order, way.stack.room())
        };
        way.stack.grow(count);
    }
    match way.stack.top() {
        None => false,
        Some(word) => {
            let child = ChildRef(word);
            if child.is_leaf() {
                tree.leaves.prefetch(simd, child);
            } else {
                simd.prefetch(tree.node(child));
            }
            true
        }
    }
}
