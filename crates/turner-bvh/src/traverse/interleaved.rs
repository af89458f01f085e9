//! Rays that have nothing in common: many under way, one step each in turn.
//!
//! A step of one ray waits for memory and for its own last step; meanwhile the processor works on those of other rays.
//! What it cannot hide are wrong guesses of branches, and whether a ray comes to a node, to a leaf or to its end is
//! anybody's guess. So rays are not asked: each step ends by putting its ray into one of three queues, by arithmetic, and
//! queues are worked off one after the other. For the same reason nothing is compared when it is taken off a stack:
//! whenever a hit is found, which is rare, what lies behind it is swept from the stack.

use super::stack::Stack;
use super::{GROUP, Leaves, SearchRay, Tree, prepare};
use crate::node::ChildRef;
use crate::simd::{Lanes, Simd};
use crate::{Hit, Ray};

/// Rays under way at once.
const WAYS: usize = 16;

/// In place of a ray's number.
const NOBODY: usize = usize::MAX;

/// At the bottom of each stack: the search is over. No node has such a child.
const END: u32 = ChildRef::EMPTY.0;

/// One ray under way.
struct Way {
    ray: SearchRay,
    hit: Hit,
    index: usize,
    /// What comes next.
    child: u32,
    stack: Stack,
}

/// Rays that wait for the same kind of step.
#[derive(Clone, Copy)]
struct Queue {
    ways: [*mut Way; WAYS],
    len: usize,
}

/// Which queue a child belongs to.
const NODES: usize = 0;
const LEAVES: usize = 1;
const ENDS: usize = 2;

/// Every way is in exactly one queue, or in the hands of the loop that took it out.
struct Queues([Queue; 3]);

impl Queues {
    /// Empties a queue.
    #[inline(always)]
    fn take(&mut self, kind: usize) -> Queue {
        let queue = self.0[kind];
        self.0[kind].len = 0;
        queue
    }

    #[inline(always)]
    fn put(&mut self, way: *mut Way, child: u32) {
        let kind = (child >> 31) as usize + usize::from(child == END);
        // SAFETY: there are three kinds, and no more ways than a queue has places.
        unsafe {
            let queue = self.0.get_unchecked_mut(kind);
            *queue.ways.get_unchecked_mut(queue.len) = way;
            queue.len += 1;
        }
    }
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
    if tree.nodes.is_empty() {
        for index in 0..rays.len() {
            found(index, Hit::MISS);
        }
        return;
    }
    let mut ways: [Way; WAYS] = std::array::from_fn(|_| Way {
        ray: SearchRay::NONE,
        hit: Hit::MISS,
        index: NOBODY,
        child: END,
        stack: Stack::new(),
    });
    // At first all are at their end, on behalf of nobody.
    let mut queues = Queues([Queue { ways: [std::ptr::null_mut(); WAYS], len: 0 }; 3]);
    let first = ways.as_mut_ptr();
    for i in 0..WAYS {
        // SAFETY: within the array.
        queues.put(unsafe { first.add(i) }, END);
    }
    // Rays are made ready in groups; of the last one made, `waiting` tells which have not set out.
    let mut ready = [SearchRay::NONE; GROUP];
    let (mut group, mut next, mut waiting) = (0, 0, 0_u32);
    loop {
        let ends = queues.take(ENDS);
        for &pointer in &ends.ways[..ends.len % (WAYS + 1)] {
            // SAFETY: it points into `ways`, and no other reference to that way exists: see `Queues`.
            let way = unsafe { &mut *pointer };
            if way.index != NOBODY {
                found(way.index, way.ray.finish(way.hit));
                way.index = NOBODY;
            }
            while waiting == 0 && next < rays.len() {
                group = next;
                next = rays.len().min(next + GROUP);
                waiting = prepare(simd, &rays[group..next], &tree.space, &mut ready);
                let mut missing = !waiting & (1_u32 << (next - group)) - 1;
                while missing != 0 {
                    found(group + missing.trailing_zeros() as usize, Hit::MISS);
                    missing &= missing - 1;
                }
            }
            if waiting != 0 {
                let i = waiting.trailing_zeros() as usize % GROUP;
                waiting &= waiting - 1;
                way.ray = ready[i];
                way.hit = Hit { t: way.ray.t_max, ..Hit::MISS };
                way.index = group + i;
                way.stack.clear();
                way.stack.push(END, f32::NEG_INFINITY);
                way.child = ChildRef::node(0).0;
                queues.put(pointer, way.child);
            }
        }
        let nodes = queues.take(NODES);
        for &pointer in &nodes.ways[..nodes.len % (WAYS + 1)] {
            // SAFETY: as above.
            let way = unsafe { &mut *pointer };
            step::<S, L, ANY>(simd, tree, way);
            queues.put(pointer, way.child);
        }
        let leaves = queues.take(LEAVES);
        for &pointer in &leaves.ways[..leaves.len % (WAYS + 1)] {
            // SAFETY: as above.
            let way = unsafe { &mut *pointer };
            leaf::<S, L, ANY>(simd, tree, way);
            queues.put(pointer, way.child);
        }
        if nodes.len + leaves.len == 0 && queues.0[NODES].len == 0 {
            return;
        }
    }
}

/// Searches a node: its children that the ray meets go onto the stack, and the top comes next.
#[inline(always)]
fn step<S: Simd, L: Leaves, const ANY: bool>(simd: S, tree: &Tree<'_, L>, way: &mut Way) {
    let node = tree.node(ChildRef(way.child));
    let slabs = way.ray.slabs(simd);
    let (near, far) = slabs.meets(simd, node, way.hit.t);
    let count = if ANY {
        simd.push_any(near.le(far), node.child_words(), way.stack.room().0)
    } else {
        let order = node.order[slabs.octant];
        simd.push_ordered(near, far, node.child_words(), order, way.stack.room())
    };
    way.stack.grow(count);
    advance(simd, tree, way);
}

/// Takes the next child off the stack and asks for its memory.
#[inline(always)]
fn advance<S: Simd, L: Leaves>(simd: S, tree: &Tree<'_, L>, way: &mut Way) {
    way.child = way.stack.take();
    let child = ChildRef(way.child);
    let node: *const u8 = tree.nodes.as_ptr().wrapping_add(child.index()).cast();
    // Not by a branch: it would be guessed, and the guess is proved only when this step's work is done.
    simd.prefetch(std::hint::select_unpredictable(child.is_leaf(), tree.leaves.address(child), node));
}

/// Tests what a leaf holds.
#[inline(always)]
fn leaf<S: Simd, L: Leaves, const ANY: bool>(simd: S, tree: &Tree<'_, L>, way: &mut Way) {
    let (child, index) = (ChildRef(way.child), way.index as u32);
    if ANY {
        if tree.leaves.any(simd, child, &way.ray, index) {
            way.hit.primitive = 0;
            way.child = END;
            return;
        }
    } else {
        let before = way.hit.t;
        tree.leaves.closest(simd, child, &way.ray, index, &mut way.hit);
        if way.hit.t < before {
            way.stack.sweep(simd, way.hit.t);
        }
    }
    advance(simd, tree, way);
}
