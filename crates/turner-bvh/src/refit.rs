//! New boxes for a tree whose primitives have moved: the same nodes, in time proportional to their number.

use std::fmt;

use crate::build::wide::set_order;
use crate::node::{ChildRef, WideNode};
use crate::{Aabb, BoxBvh};

/// Why a tree was not refitted; it is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// There are more or fewer primitives than the tree was built over.
    Count {
        /// How many there were.
        built: usize,
        /// How many there are.
        given: usize,
    },
    /// A primitive that was left out when the tree was built, because its box was not [valid](Aabb::is_valid), has a
    /// valid one now: the tree has no place for it.
    LeftOut {
        /// Its number.
        primitive: usize,
    },
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            RefitError::Count { built, given } => {
                write!(f, "the tree was built over {built} primitives, not {given}")
            }
            RefitError::LeftOut { primitive } => {
                write!(f, "primitive {primitive} was left out when the tree was built")
            }
        }
    }
}

impl std::error::Error for RefitError {}

impl BoxBvh {
    /// Takes on other boxes for the same primitives: much faster than to build anew. As in a fresh tree, no primitive is
    /// missed whose box a ray meets; rays become slower as far as primitives that were neighbours no longer are. A
    /// primitive whose box is no longer valid widens no box until it is valid again; its leaf still names it.
    pub fn refit(&mut self, boxes: &[Aabb]) -> Result<(), RefitError> {
        if boxes.len() != self.count {
            return Err(RefitError::Count { built: self.count, given: boxes.len() });
        }
        let scale = BoxBvh::scale(boxes);
        let scaled = |b: Aabb| Aabb::new(b.min.map(|x| x * scale), b.max.map(|x| x * scale));
        if let Some(&id) = self.dropped.iter().find(|&&id| scaled(boxes[id as usize]).is_valid()) {
            return Err(RefitError::LeftOut { primitive: id as usize });
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

/// Sets all boxes from those of the leaves, bottom-up, and the order of children after them. Empty places, and leaves
/// whose box is not valid, get the empty box.
fn set_boxes(nodes: &mut [WideNode], leaf: impl Fn(ChildRef) -> Aabb) {
    let mut boxes = vec![Aabb::EMPTY; nodes.len()];
    // Depth first: children come after their parents.
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
            let there = (0..3).all(|axis| bounds.min[axis] <= bounds.max[axis]);
            let bounds = if there { bounds } else { Aabb::EMPTY };
            node.set(i, bounds, child);
            all = all.union(bounds);
        }
        set_order(node);
        boxes[index] = all;
    }
}
