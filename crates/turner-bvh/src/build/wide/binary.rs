//! Top-down binary trees, and the optimal cost of each subtree as children of a wide node.
//!
//! While a binary tree grows, each node also solves the dynamic programme that [`collapse`](super::collapse) reads
//! (Ylitie, Karras, Laine 2017): `costs[i]` is the least SAH cost of the subtree when it may take up at most `i + 1`
//! child slots of a wide node.
//!
//! ```text
//!   costs[0] = min(area * NODE_COST + split(8),  cost as a leaf)       one slot: a wide node or a leaf
//!   costs[i] = min(costs[i - 1], split(i + 1))                         i + 1 slots, passed on to both children
//!   split(n) = min over a + b = n of left.costs[a - 1] + right.costs[b - 1]
//! ```

use super::bins::{Grid, MAX_BINS, Scratch, Split, best_split, halve, partition};
use super::lanes::F4;
use super::prims::{Bounds, Costs, Prim, Set};
use super::sweep::{MAX_SWEEP, Sweep};
use crate::node::MAX_LEAF_BLOCKS;

/// Below this depth the builder halves sets, which bounds the recursion.
const MAX_BINARY_DEPTH: usize = 96;

/// SAH cost of a wide node, in blocks.
pub(super) const NODE_COST: f32 = 1.0;

/// A node of a binary tree in depth-first order; its left child is the next node.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct BinaryNode {
    /// The fourth lanes hold the position of the first primitive (`lo`) and the number of primitives (`hi`).
    bounds: Bounds,
    /// The least cost of this subtree as at most 1, 2, ... 7 children of a wide node.
    pub(super) costs: [f32; 7],
    /// Index of the right child; 0 for a leaf.
    pub(super) right: u32,
}

const _: () = assert!(size_of::<BinaryNode>() == 64);

impl BinaryNode {
    fn new(bounds: Bounds, first: usize, count: usize) -> BinaryNode {
        let ([a, b, c, _], [d, e, f, _]) = (bounds.lo.array(), bounds.hi.array());
        let lo = F4::new([a, b, c, f32::from_bits(first as u32)]);
        let hi = F4::new([d, e, f, f32::from_bits(count as u32)]);
        BinaryNode { bounds: Bounds { lo, hi }, costs: [0.0; 7], right: 0 }
    }

    pub(super) fn leaf(bounds: Bounds, first: usize, count: usize, costs: &Costs) -> BinaryNode {
        let cost = costs.leaf(bounds, count);
        BinaryNode { costs: [cost; 7], ..BinaryNode::new(bounds, first, count) }
    }

    pub(super) fn bounds(&self) -> Bounds {
        self.bounds
    }

    pub(super) fn first(&self) -> usize {
        self.bounds.lo.array()[3].to_bits() as usize
    }

    pub(super) fn count(&self) -> usize {
        self.bounds.hi.array()[3].to_bits() as usize
    }

    pub(super) fn is_leaf(&self) -> bool {
        self.right == 0
    }

    pub(super) fn fits_leaf(&self, costs: &Costs) -> bool {
        costs.blocks(self.count()) <= MAX_LEAF_BLOCKS
    }

    /// Cost as one leaf; infinite if the leaf would be too large. It is also infinite where areas overflow.
    pub(super) fn leaf_cost(&self, costs: &Costs) -> f32 {
        if self.fits_leaf(costs) { costs.leaf(self.bounds, self.count()) } else { f32::INFINITY }
    }
}

/// A binary tree, and the primitive IDs in leaf order.
#[derive(Clone, Debug, Default)]
pub(super) struct BinaryTree {
    pub(super) nodes: Vec<BinaryNode>,
    pub(super) ids: Vec<u32>,
}

impl BinaryTree {
    pub(super) fn clear(&mut self) {
        self.nodes.clear();
        self.ids.clear();
    }

    pub(super) fn push_leaf(&mut self, bounds: Bounds, first: usize, costs: &Costs) {
        self.nodes.push(BinaryNode::leaf(bounds, first, self.ids.len() - first, costs));
    }

    /// Appends an inner node. Its children are appended next.
    pub(super) fn push_inner(&mut self, bounds: Bounds) -> usize {
        self.nodes.push(BinaryNode::new(bounds, self.ids.len(), 0));
        self.nodes.len() - 1
    }

    /// Appends another tree and keeps its order.
    pub(super) fn append(&mut self, other: BinaryTree) {
        let (first_node, first_id) = (self.nodes.len() as u32, self.ids.len());
        self.ids.extend_from_slice(&other.ids);
        self.nodes.extend(other.nodes.iter().map(|node| {
            let moved = BinaryNode::new(node.bounds, node.first() + first_id, node.count());
            let right = if node.is_leaf() { 0 } else { node.right + first_node };
            BinaryNode { costs: node.costs, right, ..moved }
        }));
    }

    /// Completes an inner node whose two subtrees are the last nodes appended.
    pub(super) fn finish(&mut self, index: usize, right: usize, costs: &Costs) {
        self.finish_with(index, right, self.ids.len() - self.nodes[index].first(), costs);
    }

    /// Completes an inner node whose two subtrees are complete, wherever they are.
    pub(super) fn finish_counted(&mut self, index: usize, right: usize, costs: &Costs) {
        let count = self.nodes[index + 1].count() + self.nodes[right].count();
        self.finish_with(index, right, count, costs);
    }

    fn finish_with(&mut self, index: usize, right: usize, count: usize, costs: &Costs) {
        let bounds = self.nodes[index].bounds;
        let first = self.nodes[index].first();
        let (l, r) = (self.nodes[index + 1].costs, self.nodes[right].costs);
        let mut node = BinaryNode::new(bounds, first, count);
        node.right = right as u32;
        // The least cost of exactly i + 2 slots, divided between both subtrees.
        let mut both = [f32::INFINITY; 7];
        for a in 0..7 {
            for b in 0..7 - a {
                let cost = l[a] + r[b];
                both[a + b] = if cost < both[a + b] { cost } else { both[a + b] };
            }
        }
        let as_node = bounds.area(costs.pad) * NODE_COST + both[6];
        let mut least = as_node.min(node.leaf_cost(costs));
        node.costs[0] = least;
        for i in 1..7 {
            least = least.min(both[i - 1]);
            node.costs[i] = least;
        }
        self.nodes[index] = node;
    }
}

/// Builds binary trees over sets.
#[derive(Debug)]
pub(super) struct BinaryBuilder {
    pub(super) costs: Costs,
    max_bins: usize,
    one_axis: bool,
    pub(super) tree: BinaryTree,
    pub(super) scratch: Scratch,
    sweep: Sweep,
}

impl BinaryBuilder {
    pub(super) fn new(costs: Costs, max_bins: usize, one_axis: bool) -> BinaryBuilder {
        BinaryBuilder {
            costs,
            max_bins,
            one_axis,
            tree: BinaryTree::default(),
            scratch: Scratch::new(),
            sweep: Sweep::new(one_axis),
        }
    }

    /// Appends the tree of a non-empty set.
    pub(super) fn subtree(&mut self, set: Set<'_>, depth: usize) {
        if set.len() <= MAX_SWEEP {
            self.sweep.subtree(set.prims, &self.costs, &mut self.tree);
            return;
        }
        let index = self.tree.push_inner(set.bounds);
        let [left, right] = if depth < MAX_BINARY_DEPTH { self.split(set) } else { halve(set) };
        self.subtree(left, depth + 1);
        let right_index = self.tree.nodes.len();
        self.subtree(right, depth + 1);
        self.tree.finish(index, right_index, &self.costs);
    }

    /// Appends the tree of a small set.
    pub(super) fn sweep(&mut self, prims: &[Prim]) {
        self.sweep.subtree(prims, &self.costs, &mut self.tree);
    }

    /// Splits at the cheapest plane, or at the median if all centres coincide.
    pub(super) fn split<'a>(&mut self, set: Set<'a>) -> [Set<'a>; 2] {
        let grid = Grid::new(set.centers, bins_for(set.len(), self.max_bins), self.one_axis);
        let bins = self.scratch.fill(set.prims, &grid);
        let Some(split) = best_split(bins, &grid, set.len(), &self.costs) else { return halve(set) };
        let (middle, centers) = partition(set.prims, &grid, &split);
        divide(set, middle, &split, centers)
    }
}

/// The two parts of a partitioned set.
pub(super) fn divide<'a>(set: Set<'a>, middle: usize, split: &Split, centers: [Bounds; 2]) -> [Set<'a>; 2] {
    if middle == 0 || middle == set.len() {
        return halve(set);
    }
    let (left, right) = set.prims.split_at_mut(middle);
    [
        Set { prims: left, bounds: split.bounds[0], centers: centers[0] },
        Set { prims: right, bounds: split.bounds[1], centers: centers[1] },
    ]
}

/// Number of bins. Small sets get fewer: evaluating the planes would take longer than filling the bins.
pub(super) fn bins_for(count: usize, max_bins: usize) -> usize {
    (4 + count / 16).min(max_bins).min(MAX_BINS)
}
