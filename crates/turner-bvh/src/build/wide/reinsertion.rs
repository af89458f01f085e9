//! Improves a finished binary tree by moving subtrees (Meister and Bittner 2018, "Parallel reinsertion for bounding
//! volume hierarchy optimization").
//!
//! Top-down splits are greedy. Reinsertion removes a node together with its parent and inserts it next to another node,
//! where the sum of all areas, and with it the SAH cost, becomes smallest:
//!
//! ```text
//!        P                     P              gain = area(A)                        A is no longer needed
//!       / \                   / \                  + shrinkage of the ancestors     without the node's box
//!      A   B       ->        S   B                 - area(N + T)                    the new parent A of N and T
//!     / \ / \                   / \                - growth of T's ancestors
//!    N  S T  U                 A   U
//!                             / \             N: node  S: sibling  T: target
//!                            T   N
//! ```
//!
//! The search for the best target walks from the node to the root; at each ancestor (the pivot) it descends into the
//! other subtree, depth first. Growth only accumulates on the way down, so `saved - area(N)` bounds all gains below a
//! node and prunes the search.
//!
//! Each round searches the nodes with the largest boxes in parallel, sorts the moves by gain, and applies those that
//! do not conflict with an earlier one. The result does not depend on threads.

use super::super::BuildError;
use super::binary::{BinaryNode, BinaryTree};
use super::parallel::{Progress, each};
use super::prims::{Bounds, Costs};

/// The most rounds of search and moves.
const ROUNDS: usize = 8;

/// A round that reduces the sum of areas by less than this fraction is the last.
const MIN_GAIN: f64 = 0.002;

/// Round `r` (from 0) searches `(r + 1) / SEARCH_DIVISOR` of the nodes, those with the largest boxes.
const SEARCH_DIVISOR: usize = 4;

/// Nodes per task.
const BATCH: usize = 1024;

/// A tree with links to parents. The root is node 0.
struct Linked {
    bounds: Vec<Bounds>,
    areas: Vec<f32>,
    parents: Vec<u32>,
    /// `[0, 0]` in leaves.
    children: Vec<[u32; 2]>,
}

/// A move: the node, its new sibling, and by how much the sum of areas shrinks.
#[derive(Clone, Copy, Debug)]
struct Reinsertion {
    node: u32,
    to: u32,
    gain: f32,
}

/// Improves the tree. The order of nodes and primitives changes.
pub(super) fn improve(
    tree: BinaryTree,
    costs: &Costs,
    threads: usize,
    progress: &Progress<'_>,
) -> Result<BinaryTree, BuildError> {
    let mut linked = Linked::new(&tree, costs);
    let count = linked.bounds.len();
    for round in 0..ROUNDS {
        // Later rounds include smaller nodes.
        let mut nodes: Vec<u32> = (1..count as u32).collect();
        let wanted = (count / SEARCH_DIVISOR * (round + 1)).clamp(count.min(64), count).min(nodes.len());
        if wanted == 0 {
            break;
        }
        if wanted < nodes.len() {
            let area = |&i: &u32| linked.areas[i as usize];
            nodes.select_nth_unstable_by(wanted, |a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
            nodes.truncate(wanted);
            nodes.sort_unstable();
        }
        let batches: Vec<&[u32]> = nodes.chunks(BATCH).collect();
        let found = each(threads, batches, |batch| {
            let mut stack = Vec::new();
            let found: Vec<Reinsertion> =
                batch.iter().filter_map(|&node| linked.search(node, costs, &mut stack)).collect();
            progress.check().map(|()| found)
        });
        let mut moves = Vec::new();
        for batch in found {
            moves.extend(batch?);
        }
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node)));
        let mut touched = vec![false; count];
        let mut saved = 0.0;
        for reinsertion in &moves {
            if linked.is_free(reinsertion, &touched) {
                linked.reinsert(reinsertion, costs, &mut touched);
                saved += f64::from(reinsertion.gain);
            }
        }
        if saved < MIN_GAIN * linked.total() {
            break;
        }
    }
    progress.check()?;
    Ok(linked.into_tree(&tree, costs))
}

impl Linked {
    fn new(tree: &BinaryTree, costs: &Costs) -> Linked {
        let count = tree.nodes.len();
        let mut parents = vec![0; count];
        let mut children = vec![[0; 2]; count];
        for (i, node) in tree.nodes.iter().enumerate() {
            if !node.is_leaf() {
                children[i] = [i as u32 + 1, node.right];
                for child in children[i] {
                    parents[child as usize] = i as u32;
                }
            }
        }
        let bounds: Vec<Bounds> = tree.nodes.iter().map(BinaryNode::bounds).collect();
        let areas = bounds.iter().map(|b| b.area(costs.pad)).collect();
        Linked { bounds, areas, parents, children }
    }

    /// Sum of the areas of all inner nodes.
    fn total(&self) -> f64 {
        self.areas.iter().zip(&self.children).filter(|(_, c)| c[1] != 0).map(|(&a, _)| f64::from(a)).sum()
    }

    fn sibling(&self, node: u32) -> u32 {
        let [a, b] = self.children[self.parents[node as usize] as usize];
        if a == node { b } else { a }
    }

    /// The best target for a node, if a move reduces the sum of areas. The root and its children do not move.
    fn search(&self, node: u32, costs: &Costs, stack: &mut Vec<(f32, u32)>) -> Option<Reinsertion> {
        let parent = self.parents[node as usize];
        let sibling = self.sibling(node);
        if parent == 0 {
            return None;
        }
        let (bounds, area) = (self.bounds[node as usize], self.areas[node as usize]);
        let mut best = Reinsertion { node, to: 0, gain: 0.0 };
        // Without the node its parent is not needed, and its ancestors shrink to the bounds of their other nodes.
        let mut saved = self.areas[parent as usize];
        let mut remaining = self.bounds[sibling as usize];
        let (mut pivot, mut side) = (parent, sibling);
        loop {
            stack.push((saved, side));
            while let Some((saved, at)) = stack.pop() {
                if saved - area <= best.gain {
                    continue;
                }
                let merged = self.bounds[at as usize].union(bounds).area(costs.pad);
                let gain = saved - merged;
                if gain > best.gain {
                    best = Reinsertion { node, to: at, gain };
                }
                let [left, right] = self.children[at as usize];
                if right != 0 {
                    let saved = gain + self.areas[at as usize];
                    if saved - area > best.gain {
                        stack.push((saved, left));
                        stack.push((saved, right));
                    }
                }
            }
            if pivot != parent {
                remaining = remaining.union(self.bounds[side as usize]);
                saved += self.areas[pivot as usize] - remaining.area(costs.pad);
            }
            if pivot == 0 {
                break;
            }
            side = self.sibling(pivot);
            pivot = self.parents[pivot as usize];
        }
        (best.gain > 0.0 && best.to != sibling && best.to != parent && best.to != 0).then_some(best)
    }

    /// The nodes whose links the move changes.
    fn changed(&self, m: &Reinsertion) -> [u32; 5] {
        let parent = self.parents[m.node as usize];
        [m.node, m.to, self.sibling(m.node), parent, self.parents[m.to as usize]]
    }

    /// Whether the move does not conflict with earlier ones: no link it changes has changed, and its target is not
    /// below the node.
    fn is_free(&self, m: &Reinsertion, touched: &[bool]) -> bool {
        let changed = self.changed(m);
        if changed.iter().any(|&node| touched[node as usize]) || self.parents[m.node as usize] == 0 {
            return false;
        }
        if m.to == changed[2] || m.to == changed[3] {
            return false;
        }
        let mut above = m.to;
        while above != 0 && above != m.node {
            above = self.parents[above as usize];
        }
        above != m.node
    }

    fn replace(&mut self, parent: u32, old: u32, new: u32) {
        let pair = &mut self.children[parent as usize];
        pair[usize::from(pair[0] != old)] = new;
        self.parents[new as usize] = parent;
    }

    fn reinsert(&mut self, m: &Reinsertion, costs: &Costs, touched: &mut [bool]) {
        for node in self.changed(m) {
            touched[node as usize] = true;
        }
        let parent = self.parents[m.node as usize];
        let grandparent = self.parents[parent as usize];
        self.replace(grandparent, parent, self.sibling(m.node));
        // The old parent is free and becomes the new parent.
        self.replace(self.parents[m.to as usize], m.to, parent);
        self.children[parent as usize] = [m.to, m.node];
        self.parents[m.to as usize] = parent;
        self.refit(grandparent, costs);
        self.refit(parent, costs);
    }

    fn refit(&mut self, mut node: u32, costs: &Costs) {
        loop {
            let [a, b] = self.children[node as usize].map(|child| self.bounds[child as usize]);
            let bounds = a.union(b);
            self.bounds[node as usize] = bounds;
            self.areas[node as usize] = bounds.area(costs.pad);
            if node == 0 {
                return;
            }
            node = self.parents[node as usize];
        }
    }

    /// The tree in depth-first order.
    fn into_tree(self, old: &BinaryTree, costs: &Costs) -> BinaryTree {
        let mut tree = BinaryTree::default();
        tree.nodes.reserve_exact(old.nodes.len());
        tree.ids.reserve_exact(old.ids.len());
        // Nodes to append, and the index of the parent whose right child each is.
        let mut pending = vec![(0_u32, None)];
        let mut rights = vec![0_u32; old.nodes.len()];
        while let Some((index, right_of)) = pending.pop() {
            let at = tree.nodes.len();
            if let Some(parent) = right_of {
                rights[parent] = at as u32;
            }
            let bounds = self.bounds[index as usize];
            let [left, right] = self.children[index as usize];
            if right == 0 {
                let leaf = &old.nodes[index as usize];
                let first = tree.ids.len();
                tree.ids.extend_from_slice(&old.ids[leaf.first()..leaf.first() + leaf.count()]);
                tree.push_leaf(bounds, first, costs);
            } else {
                tree.push_inner(bounds);
                pending.push((right, Some(at)));
                pending.push((left, None));
            }
        }
        for i in (0..tree.nodes.len()).rev() {
            if rights[i] != 0 {
                tree.finish_counted(i, rights[i] as usize, costs);
            }
        }
        tree
    }
}
