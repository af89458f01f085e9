//! Which rays of a tree are shown: those with the largest contributions.
//!
//! A priority queue starts with the camera ray. The ray with the largest contribution, descendants included, is shown
//! and its children enter the queue, until the budget is spent. A shown ray therefore always has a shown parent.

use std::collections::BinaryHeap;

use crate::color::Spectrum;

use super::model::{Kind, RayNode};

/// The shown part of a tree.
pub struct Shown {
    /// For each node whether it is shown.
    pub nodes: Vec<bool>,
    /// For each node the descendants that are not shown.
    pub hidden: Vec<Hidden>,
    /// Rays that the selection omits.
    pub elsewhere: Hidden,
}

/// Number and summed contribution of rays that are not shown.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hidden {
    /// Their number, shadow rays not counted.
    pub rays: u64,
    /// The sum of their contributions.
    pub contribution: Spectrum,
}

/// A ray in the queue. Larger contributions come first, then smaller indices.
#[derive(PartialEq)]
struct Candidate {
    contribution: f32,
    node: usize,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Candidate) -> std::cmp::Ordering {
        self.contribution.total_cmp(&other.contribution).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Candidate) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Shows at most `budget` rays; shadow rays come with their surfaces. With `filtered` only rays that the name
/// selects.
pub fn shown(nodes: &[RayNode], budget: usize, filtered: bool) -> Shown {
    let kept = kept(nodes, filtered);
    let mut out = Shown {
        nodes: vec![false; nodes.len()],
        hidden: vec![Hidden::default(); nodes.len()],
        elsewhere: Hidden::default(),
    };
    let mut children = vec![Vec::new(); nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        if let Some(list) = node.parent.and_then(|p| children.get_mut(p)) {
            list.push(i);
        }
    }
    let candidate = |node: usize| {
        let total = nodes.get(node).map_or(Spectrum::BLACK, |n| n.total);
        Candidate { contribution: total.map(f32::abs).max_component(), node }
    };
    let mut queue: BinaryHeap<Candidate> =
        (0..nodes.len().min(1)).filter(|&i| kept[i]).map(candidate).collect();
    let mut left = budget;
    while left > 0
        && let Some(Candidate { node, .. }) = queue.pop()
    {
        out.nodes[node] = true;
        left -= 1;
        for &child in &children[node] {
            match nodes[child].kind {
                Kind::Shadow => out.nodes[child] = true,
                _ if kept[child] => queue.push(candidate(child)),
                _ => {}
            }
        }
    }
    // Sums of the hidden rays, from the leaves upwards.
    let mut beneath: Vec<Hidden> = vec![Hidden::default(); nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        if node.kind == Kind::Shadow || out.nodes[i] {
            continue;
        }
        let own = Hidden {
            rays: beneath[i].rays + u64::from(node.traced),
            contribution: beneath[i].contribution + node.contribution,
        };
        let Some(parent) = node.parent else {
            out.elsewhere = own;
            continue;
        };
        let to = match (out.nodes[parent], kept[i]) {
            (false, _) => &mut beneath[parent],
            (true, true) => &mut out.hidden[parent],
            (true, false) => &mut out.elsewhere,
        };
        to.rays += own.rays;
        to.contribution += own.contribution;
    }
    out
}

/// Rays with a selected ancestor or descendant, or selected themselves; all without a filter.
fn kept(nodes: &[RayNode], filtered: bool) -> Vec<bool> {
    if !filtered {
        return vec![true; nodes.len()];
    }
    let mut above: Vec<bool> = vec![false; nodes.len()];
    let mut below: Vec<bool> = nodes.iter().map(|n| n.touches).collect();
    for (i, node) in nodes.iter().enumerate() {
        above[i] = node.touches || node.parent.is_some_and(|p| above[p]);
    }
    for (i, node) in nodes.iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            below[parent] |= below[i];
        }
    }
    above.into_iter().zip(below).map(|(a, b)| a || b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    /// A complete binary tree. The contribution of each leaf is its index.
    fn tree(depth: u32) -> Vec<RayNode> {
        let count = (1usize << (depth + 1)) - 1;
        let mut nodes: Vec<RayNode> = (0..count)
            .map(|i| {
                let mut node =
                    RayNode::new(Kind::Reflected, i.checked_sub(1).map(|i| i / 2), DVec3::ZERO, DVec3::X);
                node.contribution = Spectrum::grey(if 2 * i + 1 >= count { i as f32 } else { 0.0 });
                node
            })
            .collect();
        for i in (0..count).rev() {
            let own = nodes[i].contribution;
            nodes[i].total += own;
            let total = nodes[i].total;
            if let Some(p) = nodes[i].parent {
                nodes[p].total += total;
            }
        }
        nodes
    }

    #[test]
    fn the_largest_contributions_are_shown_and_the_sum_is_kept() {
        let mut nodes = tree(9);
        let all: f32 = nodes.iter().map(|n| n.contribution.r).sum();
        for filtered in [false, true] {
            nodes[700].touches = filtered;
            for budget in [1, 7, 100, 5000] {
                let shown = shown(&nodes, budget, filtered);
                let count = shown.nodes.iter().filter(|s| **s).count();
                let hidden: u64 = shown.hidden.iter().map(|h| h.rays).sum::<u64>() + shown.elsewhere.rays;
                assert_eq!(count as u64 + hidden, 1023);
                assert_eq!(count, if filtered { budget.min(10) } else { budget.min(1023) });
                let contribution = |i: usize| if shown.nodes[i] { nodes[i].contribution.r } else { 0.0 };
                let sum: f32 = (0..nodes.len()).map(contribution).sum::<f32>()
                    + shown.hidden.iter().map(|h| h.contribution.r).sum::<f32>()
                    + shown.elsewhere.contribution.r;
                assert!((sum - all).abs() < 0.5, "{sum} {all}");
                // A shown ray's parent is shown.
                assert!((1..1023).all(|i| !shown.nodes[i] || shown.nodes[(i - 1) / 2]));
            }
        }
        // Of two siblings the one with the larger contribution.
        let two = shown(&tree(9), 2, false);
        assert!(two.nodes[2] && !two.nodes[1]);
        let four = shown(&tree(9), 4, false);
        assert_eq!((four.nodes[6], four.nodes[5], four.nodes[4], four.nodes[3]), (true, false, false, false));
    }
}
