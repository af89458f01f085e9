//! Joins the subtrees that threads built separately into one array of nodes and one of slots.

use std::mem::MaybeUninit;

use super::super::{BuildError, BuildStats};
use super::collapse::Subtree;
use super::octants::set_order;
use super::parallel::each;
use super::{NO_PRIMITIVE, Source, WideTree};
use crate::Aabb;
use crate::node::{ChildRef, MAX_BLOCKS, WideNode};

/// A node above the subtrees.
#[derive(Clone, Debug, Default)]
pub(super) struct TopNode {
    pub(super) children: Vec<(Aabb, TopChild)>,
}

/// Index of a top node or of a subtree.
#[derive(Clone, Copy, Debug)]
pub(super) enum TopChild {
    Node(usize),
    Subtree(usize),
}

/// A subtree and its destination in the final arrays.
struct Move<'a> {
    subtree: Subtree,
    first_node: usize,
    first_block: usize,
    nodes: &'a mut [MaybeUninit<WideNode>],
    slots: &'a mut [MaybeUninit<u32>],
}

/// Joins all parts depth first. Without top nodes, the only subtree is the result.
pub(super) fn assemble(
    source: &Source<'_>,
    top: &[TopNode],
    subtrees: Vec<Subtree>,
    threads: usize,
) -> Result<WideTree, BuildError> {
    let node_count = top.len() + subtrees.iter().map(|s| s.nodes.len()).sum::<usize>();
    let slot_count = subtrees.iter().map(|s| s.slots.len()).sum::<usize>();
    let width = source.block_width();
    let stats = BuildStats {
        references: subtrees.iter().map(|s| s.references).sum(),
        nodes: node_count,
        leaves: subtrees.iter().map(|s| s.leaves).sum(),
        blocks: slot_count / width,
        max_depth: subtrees.iter().map(|s| s.max_depth).max().unwrap_or(0),
        ..BuildStats::default()
    };
    if stats.blocks > MAX_BLOCKS {
        return Err(BuildError::TooManyPrimitives { count: stats.blocks, limit: MAX_BLOCKS });
    }
    let needed = node_count * size_of::<WideNode>() + slot_count * size_of::<u32>();
    let mut tree = WideTree { nodes: Vec::new(), slots: Vec::new(), stats };
    tree.nodes.try_reserve_exact(node_count).map_err(|_| BuildError::OutOfMemory { needed })?;
    tree.slots.try_reserve_exact(slot_count).map_err(|_| BuildError::OutOfMemory { needed })?;

    let mut subtrees: Vec<Option<Subtree>> = subtrees.into_iter().map(Some).collect();
    let mut layout = Layout {
        top,
        subtrees: &mut subtrees,
        nodes: &mut tree.nodes.spare_capacity_mut()[..node_count],
        slots: &mut tree.slots.spare_capacity_mut()[..slot_count],
        width,
        next_node: 0,
        next_block: 0,
        moves: Vec::new(),
        top_nodes: Vec::new(),
    };
    let root = if top.is_empty() { TopChild::Subtree(0) } else { TopChild::Node(0) };
    if node_count > 0 {
        layout.assign(root);
    }
    let (moves, mut top_nodes) = (layout.moves, layout.top_nodes);
    let work: f64 = each(threads, moves, relocate).into_iter().sum();
    top_nodes.iter_mut().for_each(|(node, _)| set_order(node));
    let top_work: f64 = top_nodes.iter().map(|(node, _)| work_below(node)).sum();
    for (node, target) in top_nodes {
        target.write(node);
    }
    // SAFETY: the layout assigned every element exactly once, to a top node or to a subtree, and all were written.
    unsafe {
        tree.nodes.set_len(node_count);
        tree.slots.set_len(slot_count);
    }
    if let Some(root) = tree.nodes.first() {
        let area = (0..8).map(|i| root.bounds(i)).fold(Aabb::EMPTY, Aabb::union).half_area();
        let count = (tree.stats.nodes + tree.stats.blocks) as f64;
        tree.stats.sah_cost = if area > 0.0 { 1.0 + (work + top_work) / area } else { count };
    }
    debug_assert!(tree.slots.iter().all(|&id| id == NO_PRIMITIVE || (id as usize) < source.len()));
    Ok(tree)
}

/// Assigns a destination to each part.
struct Layout<'a> {
    top: &'a [TopNode],
    subtrees: &'a mut [Option<Subtree>],
    nodes: &'a mut [MaybeUninit<WideNode>],
    slots: &'a mut [MaybeUninit<u32>],
    width: usize,
    next_node: usize,
    next_block: usize,
    moves: Vec<Move<'a>>,
    top_nodes: Vec<(WideNode, &'a mut MaybeUninit<WideNode>)>,
}

impl Layout<'_> {
    fn assign(&mut self, child: TopChild) -> ChildRef {
        match child {
            TopChild::Subtree(index) => {
                let subtree = self.subtrees[index].take().expect("each subtree has exactly one parent");
                let nodes = self.nodes.split_off_mut(..subtree.nodes.len()).expect("room for all nodes");
                let slots = self.slots.split_off_mut(..subtree.slots.len()).expect("room for all slots");
                let (first_node, first_block) = (self.next_node, self.next_block);
                self.next_node += nodes.len();
                self.next_block += slots.len() / self.width;
                let root = subtree.root.unwrap_or(ChildRef::EMPTY);
                self.moves.push(Move { subtree, first_node, first_block, nodes, slots });
                moved(root, first_node, first_block)
            }
            TopChild::Node(index) => {
                let target = self.nodes.split_off_first_mut().expect("room for all nodes");
                let at = self.next_node;
                self.next_node += 1;
                let number = self.top_nodes.len();
                self.top_nodes.push((WideNode::EMPTY, target));
                for (i, &(bounds, child)) in self.top[index].children.iter().enumerate() {
                    let reference = self.assign(child);
                    self.top_nodes[number].0.set(i, bounds, reference);
                }
                ChildRef::node(at)
            }
        }
    }
}

fn moved(child: ChildRef, first_node: usize, first_block: usize) -> ChildRef {
    if child == ChildRef::EMPTY {
        child
    } else if child.is_leaf() {
        ChildRef::leaf(child.first_block() + first_block, child.blocks())
    } else {
        ChildRef::node(child.index() + first_node)
    }
}

/// Copies a subtree to its destination. Returns the sum over its nodes of [`work_below`].
fn relocate(task: Move<'_>) -> f64 {
    let Move { mut subtree, first_node, first_block, nodes, slots } = task;
    let mut work = 0.0;
    for (node, target) in subtree.nodes.iter_mut().zip(nodes) {
        work += work_below(node);
        for child in &mut node.children {
            *child = moved(*child, first_node, first_block);
        }
        target.write(*node);
    }
    slots.write_copy_of_slice(&subtree.slots);
    work
}

/// Sum over the node's children of their work (1 per node, 1 per block) times their half area.
fn work_below(node: &WideNode) -> f64 {
    (0..8)
        .map(|i| {
            let child = node.children[i];
            let work = if child.is_leaf() { child.blocks() } else { 1 };
            node.bounds(i).half_area() * work as f64
        })
        .sum()
}
