//! Subtrees moved to where they make other boxes grow least (Meister, Bittner 2018, "Parallel reinsertion for bounding
//! volume hierarchy optimization").

use super::super::BuildError;
use super::binary::{BinaryNode, BinaryTree};
use super::parallel::{Progress, each};
use super::prims::{Bounds, Costs};

/// Rounds of searching and moving.
const ROUNDS: usize = 8;

/// A round that saves less than this share of all areas is the last.
const MIN_GAIN: f64 = 0.002;

/// In the first round one node of so many is looked at, those with the largest boxes; then two, three, ...
const SHARE: usize = 4;

/// Searches of a task.
const BATCH: usize = 1024;

/// A tree whose nodes know their parents.
struct Linked {
    bounds: Vec<Bounds>,
    areas: Vec<f32>,
    parents: Vec<u32>,
    /// Both 0 in leaves.
    children: Vec<[u32; 2]>,
}

/// A node, the one it should become the sibling of, and by how much the sum of areas shrinks.
#[derive(Clone, Copy, Debug)]
struct Reinsertion {
    node: u32,
    to: u32,
    gain: f32,
}

/// Improves the tree. The order of nodes and primitives changes with it.
pub(super) fn improve(
    tree: BinaryTree,
    costs: &Costs,
    threads: usize,
    progress: &Progress<'_>,
) -> Result<BinaryTree, BuildError> {
    let mut linked = Linked::new(&tree, costs);
    let count = linked.bounds.len();
    for round in 0..ROUNDS {
        // Others each time.
        let mut nodes: Vec<u32> = (1..count as u32).collect();
        let wanted = (count / SHARE * (round + 1)).clamp(count.min(64), count).min(nodes.len());
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

    /// The areas of all nodes with children.
    fn total(&self) -> f64 {
        self.areas.iter().zip(&self.children).filter(|(_, c)| c[1] != 0).map(|(&a, _)| f64::from(a)).sum()
    }

    fn sibling(&self, node: u32) -> u32 {
        let [a, b] = self.children[self.parents[node as usize] as usize];
        if a == node { b } else { a }
    }

    /// The best place for a node that is not the root, if it is better than its own.
    fn search(&self, node: u32, costs: &Costs, stack: &mut Vec<(f32, u32)>) -> Option<Reinsertion> {
        let parent = self.parents[node as usize];
        let sibling = self.sibling(node);
        if parent == 0 {
            return None;
        }
        let (bounds, area) = (self.bounds[node as usize], self.areas[node as usize]);
        let mut best = Reinsertion { node, to: 0, gain: 0.0 };
        // Without the node its parent is no longer needed, and boxes above shrink.
        let mut saved = self.areas[parent as usize];
        let mut around = self.bounds[sibling as usize];
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
                around = around.union(self.bounds[side as usize]);
                saved += self.areas[pivot as usize] - around.area(costs.pad);
            }
            if pivot == 0 {
                break;
            }
            side = self.sibling(pivot);
            pivot = self.parents[pivot as usize];
        }
        (best.gain > 0.0 && best.to != sibling && best.to != parent && best.to != 0).then_some(best)
    }

    /// The nodes whose links a move changes.
    fn changed(&self, m: &Reinsertion) -> [u32; 5] {
        let parent = self.parents[m.node as usize];
        [m.node, m.to, self.sibling(m.node), parent, self.parents[m.to as usize]]
    }

    /// Whether nothing that a move changes was changed before, and its place is not below the node by now.
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
        // The parent is free now, and becomes the parent in the new place.
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

    /// The tree in depth-first order again.
    fn into_tree(self, old: &BinaryTree, costs: &Costs) -> BinaryTree {
        let mut tree = BinaryTree::default();
        tree.nodes.reserve_exact(old.nodes.len());
        tree.ids.reserve_exact(old.ids.len());
        // Nodes still to append, and of which node each is the right child.
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
