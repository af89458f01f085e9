//! The tree with four children to a node, collapsed from the binary one: fewer steps, one register per plane.

use std::mem::MaybeUninit;
use std::ops::Range;

use crate::bvh2::Node as Node2;
use crate::slabs::Slabs4;
use crate::{Aabb, Bvh2, MAX_DEPTH, Ray};

/// Children of a node.
const WIDTH: usize = 4;

/// At most three children wait at each level.
const STACK: usize = MAX_DEPTH * (WIDTH - 1) + 1;

const LEAF: u32 = 1 << 31;

/// A tree over boxes, four children to a node of 128 bytes. Finds what the [`Bvh2`] finds that it was made from.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh4 {
    nodes: Vec<Node>,
    order: Vec<u32>,
    /// The largest distance of any box plane from 0.
    reach: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
struct Node {
    /// Per axis the lower planes of the children, then the upper ones.
    planes: [[[f32; WIDTH]; 2]; 3],
    /// Index of a node, or `LEAF` and the position of the leaf's first primitive.
    children: [u32; WIDTH],
    /// Primitives in the leaf.
    counts: [u32; WIDTH],
}

const _: () = assert!(size_of::<Node>() == 128);

/// A child that is still to be searched: a lower bound of its entry, and which child of which node it is.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    entry: f32,
    node: u32,
    lane: u32,
}

impl Bvh4 {
    /// Makes the wide tree; the same for the same binary tree.
    pub fn collapse(tree: &Bvh2) -> Bvh4 {
        let mut wide = Bvh4 { nodes: Vec::new(), order: tree.order().to_vec(), reach: tree.reach() };
        if !tree.nodes().is_empty() {
            // Children are at most as deep as in the binary tree: MAX_DEPTH bounds the recursion.
            wide.add(tree.nodes(), 0);
        }
        wide
    }

    /// Adds the wide node of a binary one, and all below it; returns its index.
    fn add(&mut self, nodes: &[Node2], root: usize) -> u32 {
        // The children, and of those that are nodes the children instead, those with the largest boxes first.
        let mut sides: Vec<(usize, usize)> = vec![(root, 0), (root, 1)];
        while sides.len() < WIDTH {
            let area = |&(node, side): &(usize, usize)| nodes[node].bounds(side).half_area();
            let inner = (0..sides.len()).filter(|&i| nodes[sides[i].0].leaf(sides[i].1).is_none());
            let Some(largest) = inner.max_by(|&a, &b| area(&sides[a]).total_cmp(&area(&sides[b]))) else {
                break;
            };
            let (node, side) = sides[largest];
            let child = nodes[node].child(side);
            sides.splice(largest..=largest, [(child, 0), (child, 1)]);
        }
        let index = self.nodes.len();
        self.nodes.push(Node {
            planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
            children: [LEAF; WIDTH],
            counts: [0; WIDTH],
        });
        for (lane, (node, side)) in sides.into_iter().enumerate() {
            let Aabb { min, max } = nodes[node].bounds(side);
            let (child, count) = match nodes[node].leaf(side) {
                Some(positions) => (LEAF | positions.start, positions.end - positions.start),
                None => (self.add(nodes, nodes[node].child(side)), 0),
            };
            let wide = &mut self.nodes[index];
            for axis in 0..3 {
                wide.planes[axis][0][lane] = min[axis];
                wide.planes[axis][1][lane] = max[axis];
            }
            (wide.children[lane], wide.counts[lane]) = (child, count);
        }
        index as u32
    }

    /// For each position in leaf order, the index of its primitive in the input.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.order.len() * size_of::<u32>()
    }

    /// As [`Bvh2::closest`]: visits the leaves that the ray may meet, nearer ones first as far as boxes can tell, and
    /// returns the last `t_max`.
    #[inline]
    pub fn closest(&self, ray: &Ray, mut leaf: impl FnMut(Range<u32>, f32) -> f32) -> f32 {
        let mut t_max = ray.t_max;
        if !ray.is_valid() || self.nodes.is_empty() {
            return t_max;
        }
        let slabs = Slabs4::new(ray, self.reach);
        let mut stack = [const { MaybeUninit::<Waiting>::uninit() }; STACK];
        let mut waiting = 0;
        let mut node = 0;
        loop {
            let (entry, mut met) = slabs.test(&self.nodes[node as usize].planes, t_max);
            // All children that are met go on the stack, the nearest last.
            let first = waiting;
            while met != 0 {
                let lane = met.trailing_zeros();
                met &= met - 1;
                let child = Waiting { entry: entry[lane as usize], node, lane };
                let mut at = waiting;
                waiting += 1;
                while at > first {
                    // SAFETY: entries below `at`, which is at most the old `waiting`, have been written.
                    let before = unsafe { stack[at - 1].assume_init() };
                    if before.entry >= child.entry {
                        break;
                    }
                    stack[at].write(before);
                    at -= 1;
                }
                stack[at].write(child);
            }
            // Leaves are searched as they come up, until there is a node to go on with.
            loop {
                if waiting == 0 {
                    return t_max;
                }
                waiting -= 1;
                // SAFETY: every entry below `waiting` has been written.
                let Waiting { entry, node: parent, lane } = unsafe { stack[waiting].assume_init() };
                // Not `>`: NaN ends the search.
                let still_counts = entry <= t_max;
                if !still_counts {
                    if t_max.is_nan() {
                        return t_max;
                    }
                    continue;
                }
                let parent = &self.nodes[parent as usize];
                let child = parent.children[lane as usize];
                if child & LEAF == 0 {
                    node = child;
                    break;
                }
                let position = child & !LEAF;
                let t = leaf(position..position + parent.counts[lane as usize], t_max);
                // A larger one is ignored; NaN stays, and ends the search.
                t_max = if t > t_max { t_max } else { t };
            }
        }
    }

    /// As [`Bvh2::any`]: whether `leaf` says so for any of the leaves that the ray may meet; stops at the first.
    #[inline]
    pub fn any(&self, ray: &Ray, mut leaf: impl FnMut(Range<u32>) -> bool) -> bool {
        let mut found = false;
        self.closest(ray, |positions, t_max| {
            found = leaf(positions);
            if found { f32::NAN } else { t_max }
        });
        found
    }
}
