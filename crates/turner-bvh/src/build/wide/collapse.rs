//! Collapses a binary tree into nodes of eight children (Ylitie, Karras, Laine 2017, "Efficient incoherent ray
//! traversal on GPUs through compressed wide BVHs").
//!
//! A wide node is a cut through the binary tree below it: it takes up to eight descendants as children and drops the
//! nodes in between.
//!
//! ```text
//!             N                   N        The cut # crosses each path from N to a leaf once.
//!           /   \             / | | | \    Its subtrees become the children of N.
//!         .       .          a  b c d  e
//!       /   \    / \
//!      #a    .  #d  #e
//!           / \
//!         #b   #c
//! ```
//!
//! Each binary node already knows `costs[i]`, the least SAH cost of its subtree with at most `i + 1` slots
//! ([`binary`](super::binary)). So the cheapest cut is found top-down: give the eight slots of N to its two children in
//! the cheapest way (`distribute`), and repeat for each child until it has one slot (`gather`). A subtree becomes a
//! leaf if that costs no more than a node. The result is optimal for the given binary tree, in time linear in its
//! nodes.

use super::NO_PRIMITIVE;
use super::binary::{BinaryNode, BinaryTree};
use super::octants::set_order;
use super::prims::Costs;
use crate::node::{ChildRef, MAX_WIDE_DEPTH, WideNode};

/// A wide subtree. References are relative to its own first node and block.
#[derive(Debug, Default)]
pub(super) struct Subtree {
    pub(super) nodes: Vec<WideNode>,
    pub(super) slots: Vec<u32>,
    pub(super) root: Option<ChildRef>,
    pub(super) leaves: usize,
    pub(super) references: usize,
    /// Nodes on the longest path down, including those above the subtree.
    pub(super) max_depth: usize,
}

/// Appends wide nodes to a subtree.
pub(super) struct Collapse<'a> {
    pub(super) tree: &'a BinaryTree,
    pub(super) costs: &'a Costs,
    pub(super) out: Subtree,
}

impl Collapse<'_> {
    /// Collapses the binary tree, which hangs below `depth` nodes. With `is_root` the result is always a node.
    pub(super) fn run(mut self, depth: usize, is_root: bool) -> Subtree {
        self.out.max_depth = depth;
        let root = &self.tree.nodes[0];
        self.out.root = Some(if !self.is_leaf(root) {
            self.node(0, depth + 1)
        } else if is_root {
            self.wide_node(&[0], depth + 1)
        } else {
            self.leaf(root)
        });
        self.out
    }

    /// Whether a subtree that takes one slot is a leaf.
    fn is_leaf(&self, node: &BinaryNode) -> bool {
        node.is_leaf() || node.fits_leaf(self.costs) && node.leaf_cost(self.costs) <= node.costs[0]
    }

    /// Appends the node for the subtree at `index`, which has at least two children.
    fn node(&mut self, index: usize, depth: usize) -> ChildRef {
        if depth + halvings(self.tree.nodes[index].count()) >= MAX_WIDE_DEPTH {
            let mut leaves = Vec::new();
            self.gather_leaves(index, &mut leaves);
            return self.even_node(&leaves, depth);
        }
        let mut children = [0; 8];
        let mut count = 0;
        self.distribute(index, 8, &mut children, &mut count);
        self.wide_node(&children[..count], depth)
    }

    /// Collects the children that the subtree becomes in at most `slots` slots.
    fn gather(&self, index: usize, mut slots: usize, children: &mut [usize; 8], count: &mut usize) {
        let node = &self.tree.nodes[index];
        while slots > 1 && node.costs[slots - 2] <= node.costs[slots - 1] {
            slots -= 1;
        }
        if slots == 1 || node.is_leaf() {
            children[*count] = index;
            *count += 1;
        } else {
            self.distribute(index, slots, children, count);
        }
    }

    /// Divides the slots between both children at the least cost.
    fn distribute(&self, index: usize, slots: usize, children: &mut [usize; 8], count: &mut usize) {
        let (left, right) = (index + 1, self.tree.nodes[index].right as usize);
        let (l, r) = (&self.tree.nodes[left].costs, &self.tree.nodes[right].costs);
        let mut best = (f32::INFINITY, 1);
        for for_left in 1..slots {
            let cost = l[for_left - 1] + r[slots - for_left - 1];
            if cost < best.0 {
                best = (cost, for_left);
            }
        }
        self.gather(left, best.1, children, count);
        self.gather(right, slots - best.1, children, count);
    }

    fn wide_node(&mut self, children: &[usize], depth: usize) -> ChildRef {
        let index = self.start_node(depth);
        let mut node = WideNode::EMPTY;
        for (slot, &child) in children.iter().enumerate() {
            let tree = self.tree;
            let binary = &tree.nodes[child];
            let reference =
                if self.is_leaf(binary) { self.leaf(binary) } else { self.node(child, depth + 1) };
            node.set(slot, binary.bounds().aabb(), reference);
        }
        self.end_node(index, node)
    }

    fn start_node(&mut self, depth: usize) -> usize {
        self.out.max_depth = self.out.max_depth.max(depth);
        self.out.nodes.push(WideNode::EMPTY);
        self.out.nodes.len() - 1
    }

    fn end_node(&mut self, index: usize, mut node: WideNode) -> ChildRef {
        set_order(&mut node);
        self.out.nodes[index] = node;
        ChildRef::node(index)
    }

    /// Appends a leaf with all primitives below the binary node, without duplicates, sorted by ID.
    fn leaf(&mut self, node: &BinaryNode) -> ChildRef {
        let first = self.out.slots.len();
        self.out.slots.extend_from_slice(&self.tree.ids[node.first()..node.first() + node.count()]);
        let slots = &mut self.out.slots[first..];
        if !slots.is_sorted_by(|a, b| a < b) {
            slots.sort_unstable();
            let mut kept = 1;
            for i in 1..slots.len() {
                if slots[i] != slots[kept - 1] {
                    slots[kept] = slots[i];
                    kept += 1;
                }
            }
            self.out.slots.truncate(first + kept);
        }
        let count = self.out.slots.len() - first;
        self.out.leaves += 1;
        self.out.references += count;
        let blocks = self.costs.blocks(count);
        self.out.slots.resize(first + (blocks << self.costs.block_shift), NO_PRIMITIVE);
        ChildRef::leaf(first >> self.costs.block_shift, blocks)
    }

    fn gather_leaves(&self, index: usize, leaves: &mut Vec<usize>) {
        let mut pending = vec![index];
        while let Some(index) = pending.pop() {
            let node = &self.tree.nodes[index];
            if self.is_leaf(node) {
                leaves.push(index);
            } else {
                pending.extend([node.right as usize, index + 1]);
            }
        }
    }

    /// A node over leaves that are divided evenly: used near the depth limit.
    fn even_node(&mut self, leaves: &[usize], depth: usize) -> ChildRef {
        if leaves.len() <= 8 {
            return self.wide_node(leaves, depth);
        }
        let index = self.start_node(depth);
        let mut node = WideNode::EMPTY;
        for slot in 0..8 {
            let part = &leaves[leaves.len() * slot / 8..leaves.len() * (slot + 1) / 8];
            let tree = self.tree;
            let bounds = part.iter().map(|&i| tree.nodes[i].bounds()).reduce(|a, b| a.union(b));
            let reference = if let [leaf] = part {
                self.leaf(&tree.nodes[*leaf])
            } else {
                self.even_node(part, depth + 1)
            };
            node.set(slot, bounds.expect("eight parts of more than eight").aabb(), reference);
        }
        self.end_node(index, node)
    }
}

/// An upper bound on the nodes along the longest path when leaves are divided evenly.
pub(super) fn halvings(count: usize) -> usize {
    let mut levels = 1;
    let mut reach = 8;
    while reach < count {
        levels += 1;
        reach *= 8;
    }
    levels + 1
}
