//! The expression of constructive solid geometry: which combination of leaves a point must be inside.
//!
//! A difference is an intersection whose later parts are inverted, so there are two kinds of nodes: those that are
//! true if any child is, and those that are true if all children are. Each node counts its children that are true. A
//! leaf that changes updates only the nodes above it that change.

use super::Operation;

/// No node.
const NONE: u16 = u16::MAX;

/// One operation.
#[derive(Clone, Copy, Debug)]
struct Node {
    parent: u16,
    /// Whether all children have to be true, not only one.
    all: bool,
    /// Whether the parent takes the opposite of its value.
    inverted: bool,
    children: u16,
}

impl Node {
    fn value(&self, count: u16) -> bool {
        if self.all { count == self.children } else { count > 0 }
    }
}

/// The nodes of an expression; the root is first, parents come before their children.
#[derive(Clone, Debug, Default)]
pub(super) struct Expression {
    nodes: Vec<Node>,
    /// Number of true children of each node while the ray is outside all leaves.
    outside: Vec<u16>,
}

impl Expression {
    /// The number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Adds a node below another one, or the root.
    pub(super) fn add(&mut self, parent: Option<u16>, operation: Operation, inverted: bool) -> u16 {
        let parent = parent.inspect(|p| self.nodes[usize::from(*p)].children += 1);
        let all = operation != Operation::Union;
        self.nodes.push(Node { parent: parent.unwrap_or(NONE), all, inverted, children: 0 });
        self.nodes.len() as u16 - 1
    }

    /// Adds a leaf below a node.
    pub(super) fn add_leaf(&mut self, node: u16) {
        self.nodes[usize::from(node)].children += 1;
    }

    /// Completes the expression: `leaves` are all leaves as (node, inverted).
    pub(super) fn finish(&mut self, leaves: impl Iterator<Item = (u16, bool)>) {
        self.outside = vec![0; self.nodes.len()];
        for (node, inverted) in leaves {
            self.outside[usize::from(node)] += u16::from(inverted);
        }
        for i in (1..self.nodes.len()).rev() {
            let node = self.nodes[i];
            let value = node.value(self.outside[i]) != node.inverted;
            self.outside[usize::from(node.parent)] += u16::from(value);
        }
    }

    /// The counts of all nodes while the ray is outside all leaves. `N` is at least the number of nodes.
    pub(super) fn start<const N: usize>(&self) -> [u16; N] {
        let mut counts = [0; N];
        counts[..self.outside.len()].copy_from_slice(&self.outside);
        counts
    }

    /// The value of a node.
    pub(super) fn value(&self, counts: &[u16], node: u16) -> bool {
        self.nodes[usize::from(node)].value(counts[usize::from(node)])
    }

    /// What the parent of a node takes as its value.
    pub(super) fn effective(&self, counts: &[u16], node: u16) -> bool {
        self.value(counts, node) != self.nodes[usize::from(node)].inverted
    }

    /// Whether all children of the root are true, apart from one whose value is given.
    pub(super) fn others_are_true(&self, counts: &[u16], one: bool) -> bool {
        counts[0] - u16::from(one) == self.nodes[0].children - 1
    }

    /// A child of `node` became true or false.
    pub(super) fn change(&self, counts: &mut [u16], mut node: u16, mut value: bool) {
        while node != NONE {
            let at = usize::from(node);
            let Node { parent, inverted, .. } = self.nodes[at];
            let before = self.nodes[at].value(counts[at]);
            counts[at] = if value { counts[at] + 1 } else { counts[at] - 1 };
            let after = self.nodes[at].value(counts[at]);
            if before == after {
                return;
            }
            (node, value) = (parent, after != inverted);
        }
    }
}
