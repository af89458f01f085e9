//! Refits a BVH to moved primitives: updates the boxes bottom-up and keeps the tree.
//!
//! ```text
//!        N              box(N) = box(L) + box(R)          3. then parents
//!       / \
//!      L   R            box(L) = union of its leaves      2. then their nodes
//!     /|   |\
//!    a b   c d          new boxes of the primitives       1. leaves first
//! ```
//!
//! The time is linear in the number of nodes, and hits stay exact. Rays become slower as primitives that share a leaf
//! move apart, because boxes then overlap; rebuild when that matters.

use std::fmt;

use crate::build::wide::set_order;
use crate::node::{ChildRef, WideNode};
use crate::{Aabb, BoxBvh};

/// Why a refit failed; the BVH is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// The number of primitives differs from the build.
    Count {
        /// Number of primitives in the build.
        built: usize,
        /// Number of boxes given.
        given: usize,
    },
    /// A primitive that the build omitted, because its box was not [valid](Aabb::is_valid), has a valid box now. The
    /// BVH has no leaf for it.
    Omitted {
        /// Index of the primitive.
        primitive: usize,
    },
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            RefitError::Count { built, given } => {
                write!(f, "the BVH was built over {built} primitives, not {given}")
            }
            RefitError::Omitted { primitive } => {
                write!(f, "primitive {primitive} was omitted when the BVH was built")
            }
        }
    }
}

impl std::error::Error for RefitError {}

impl BoxBvh {
    /// Replaces the boxes of all primitives, much faster than a rebuild. As in a fresh BVH, no primitive is missed
    /// whose box a ray intersects; rays become slower as former neighbours move apart. A primitive whose box becomes
    /// invalid stays in its leaf but does not enlarge any box until it is valid again.
    pub fn refit(&mut self, boxes: &[Aabb]) -> Result<(), RefitError> {
        if boxes.len() != self.count {
            return Err(RefitError::Count { built: self.count, given: boxes.len() });
        }
        let scale = BoxBvh::scale(boxes);
        let scaled = |b: Aabb| Aabb::new(b.min.map(|x| x * scale), b.max.map(|x| x * scale));
        if let Some(&id) = self.dropped.iter().find(|&&id| scaled(boxes[id as usize]).is_valid()) {
            return Err(RefitError::Omitted { primitive: id as usize });
        }
        set_boxes(&mut self.nodes, |leaf| {
            let ids = &self.order[leaf.first_block()..leaf.first_block() + leaf.blocks()];
            let boxes = ids.iter().map(|&id| scaled(boxes[id as usize])).filter(|b| b.is_valid());
            boxes.fold(Aabb::EMPTY, Aabb::union)
        });
        self.measure(scale);
        Ok(())
    }
}

/// Computes all boxes bottom-up from those of the leaves, then the order of the children. Empty slots and leaves
/// without a valid box get the empty box.
fn set_boxes(nodes: &mut [WideNode], leaf: impl Fn(ChildRef) -> Aabb) {
    let mut boxes = vec![Aabb::EMPTY; nodes.len()];
    // Nodes are depth first: children come after their parents.
    for (index, node) in nodes.iter_mut().enumerate().rev() {
        let mut all = Aabb::EMPTY;
        for i in 0..8 {
            let child = node.children[i];
            let bounds = match child {
                ChildRef::EMPTY => continue,
                leaf_child if leaf_child.is_leaf() => leaf(leaf_child),
                node => {
                    debug_assert!(node.index() > index);
                    boxes[node.index()]
                }
            };
            let is_valid_box = (0..3).all(|axis| bounds.min[axis] <= bounds.max[axis]);
            let bounds = if is_valid_box { bounds } else { Aabb::EMPTY };
            node.set(i, bounds, child);
            all = all.union(bounds);
        }
        set_order(node);
        boxes[index] = all;
    }
}
