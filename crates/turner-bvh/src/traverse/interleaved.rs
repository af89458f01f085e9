//! Traversal of incoherent rays: many rays in flight, which take one step each in turn.
//!
//! A step of one ray depends on its previous step and on memory, so a ray alone leaves the processor waiting. With
//! 16 rays in flight, their independent steps overlap. Mispredicted branches cannot be hidden this way, and whether
//! a ray reaches a node, a leaf or its end is unpredictable. So no branch depends on it: each step ends by setting the
//! ray's bit in one of three queues, by arithmetic, and the loop processes one queue after the other:
//!
//! ```text
//!             +---------------------+-------------------+
//!             v                     |                   |
//!   ends:  write the hit,   nodes:  test 8 boxes,  leaves:  test the blocks,
//!          start a new ray          push the hit ones,      drop stack entries behind a new hit,
//!             |                     pop the next            pop the next
//!             +---> nodes           +---> nodes | leaves | ends, prefetch its memory
//! ```
//!
//! For the same reason a popped entry is not compared with the nearest hit. Whenever a hit is found, which is rare,
//! all stack entries behind it are removed.

use super::stack::Stack;
use super::{GROUP, Leaves, SearchRay, Tree, prepare};
use crate::node::ChildRef;
use crate::simd::{Lanes, Simd};
use crate::{Hit, Ray};

/// Rays in flight.
const IN_FLIGHT: usize = 16;

/// Marks a slot without a ray.
const NO_RAY: usize = usize::MAX;

/// Sentinel at the bottom of each stack: popping it ends the traversal. No node has such a child.
const END: u32 = ChildRef::EMPTY.0;

/// A ray in flight.
struct ActiveRay {
    ray: SearchRay,
    hit: Hit,
    index: usize,
    /// The next child to visit.
    child: u32,
    stack: Stack,
}

/// The queues as bit sets. Every ray in flight is in exactly one of them, or in the local copy of the loop that
/// processes it.
#[derive(Clone, Copy, Default)]
struct Queues {
    nodes: u32,
    leaves: u32,
    ends: u32,
}

impl Queues {
    /// Adds a ray to the queue of its next child, without branches.
    #[inline(always)]
    fn put(&mut self, slot: usize, child: u32) {
        let leaf = child >> 31;
        let end = u32::from(child == END);
        self.nodes |= (leaf ^ 1) << slot;
        self.leaves |= (leaf ^ end) << slot;
        self.ends |= end << slot;
    }
}

/// Finds the nearest hit of each ray; the first ray has index `first`.
#[inline(always)]
pub(crate) fn closest<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    first: usize,
    hits: &mut [Hit],
) {
    run::<S, L, false>(simd, tree, rays, first, |index, hit| hits[index] = hit);
}

/// Finds whether each ray hits anything; the first ray has index `first`.
#[inline(always)]
pub(crate) fn any<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    first: usize,
    hits: &mut [bool],
) {
    run::<S, L, true>(simd, tree, rays, first, |index, hit| hits[index] = hit.is_hit());
}

#[inline(always)]
fn run<S: Simd, L: Leaves, const ANY: bool>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    first: usize,
    mut found: impl FnMut(usize, Hit),
) {
    if tree.nodes.is_empty() {
        for index in 0..rays.len() {
            found(index, Hit::MISS);
        }
        return;
    }
    let mut active_rays: [ActiveRay; IN_FLIGHT] = std::array::from_fn(|_| ActiveRay {
        ray: SearchRay::NONE,
        hit: Hit::MISS,
        index: NO_RAY,
        child: END,
        stack: Stack::new(),
    });
    // All slots start at their end, without a ray.
    let mut queues = Queues { ends: u32::MAX >> (32 - IN_FLIGHT), ..Queues::default() };
    // Rays are prepared in groups; `ready_set` holds those of the last group that have not started yet.
    let mut ready = [SearchRay::NONE; GROUP];
    let (mut group, mut next, mut ready_set) = (0, 0, 0_u32);
    loop {
        let mut ends = std::mem::take(&mut queues.ends);
        while ends != 0 {
            let i = ends.trailing_zeros() as usize % IN_FLIGHT;
            ends &= ends - 1;
            let active = &mut active_rays[i];
            if active.index != NO_RAY {
                found(active.index, active.ray.finish(active.hit));
                active.index = NO_RAY;
            }
            while ready_set == 0 && next < rays.len() {
                group = next;
                next = rays.len().min(next + GROUP);
                ready_set = prepare(simd, &rays[group..next], &tree.space, &mut ready);
                let mut missing = !ready_set & ((1_u32 << (next - group)) - 1);
                while missing != 0 {
                    found(group + missing.trailing_zeros() as usize, Hit::MISS);
                    missing &= missing - 1;
                }
            }
            if ready_set != 0 {
                let ray = ready_set.trailing_zeros() as usize % GROUP;
                ready_set &= ready_set - 1;
                active.ray = ready[ray];
                active.hit = Hit { t: active.ray.t_max, ..Hit::MISS };
                active.index = group + ray;
                active.stack.clear();
                active.stack.push(END, f32::NEG_INFINITY);
                active.child = ChildRef::node(0).0;
                queues.nodes |= 1 << i;
            }
        }
        let mut nodes = std::mem::take(&mut queues.nodes);
        while nodes != 0 {
            let i = nodes.trailing_zeros() as usize % IN_FLIGHT;
            nodes &= nodes - 1;
            let active = &mut active_rays[i];
            step::<S, L, ANY>(simd, tree, active);
            queues.put(i, active.child);
        }
        let mut leaves = std::mem::take(&mut queues.leaves);
        while leaves != 0 {
            let i = leaves.trailing_zeros() as usize % IN_FLIGHT;
            leaves &= leaves - 1;
            let active = &mut active_rays[i];
            leaf::<S, L, ANY>(simd, tree, active, first);
            queues.put(i, active.child);
        }
        if queues.nodes | queues.leaves | queues.ends == 0 {
            return;
        }
    }
}

/// Visits a node: pushes the children that the ray hits, then pops the next child.
#[inline(always)]
fn step<S: Simd, L: Leaves, const ANY: bool>(simd: S, tree: &Tree<'_, L>, active: &mut ActiveRay) {
    let node = tree.node(ChildRef(active.child));
    let slabs = active.ray.slabs(simd);
    let (near, far) = slabs.intersect(simd, node, active.hit.t);
    let count = if ANY {
        simd.push_any(near.le(far), node.child_words(), active.stack.room().0)
    } else {
        let order = node.order[slabs.octant];
        simd.push_ordered(near, far, node.child_words(), order, active.stack.room())
    };
    active.stack.grow(count);
    advance(simd, tree, active);
}

/// Pops the next child and prefetches its memory.
#[inline(always)]
fn advance<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, active: &mut ActiveRay) {
    active.child = active.stack.take();
    let child = ChildRef(active.child);
    let node: *const u8 = tree.nodes.as_ptr().wrapping_add(child.index()).cast();
    // A select instead of a branch: the branch would be mispredicted.
    simd.prefetch(std::hint::select_unpredictable(child.is_leaf(), tree.leaves.address(child), node));
}

/// Tests the primitives of a leaf.
#[inline(always)]
fn leaf<S: Simd, L: Leaves, const ANY: bool>(
    simd: S,
    tree: &Tree<'_, L>,
    active: &mut ActiveRay,
    first: usize,
) {
    let (child, index) = (ChildRef(active.child), (first + active.index) as u32);
    if ANY {
        if tree.leaves.any(simd, child, &active.ray, index) {
            active.hit.primitive = 0;
            active.child = END;
            return;
        }
    } else {
        let before = active.hit.t;
        tree.leaves.closest(simd, child, &active.ray, index, &mut active.hit);
        if active.hit.t < before {
            active.stack.sweep(simd, active.hit.t);
        }
    }
    advance(simd, tree, active);
}
