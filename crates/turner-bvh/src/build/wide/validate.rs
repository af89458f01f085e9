//! Validates the complete structure of a wide BVH.

use super::{NO_PRIMITIVE, Source, WideTree};
use crate::Aabb;
use crate::node::{ChildRef, MAX_WIDE_DEPTH, WideNode};

/// The box of a usable primitive.
pub(super) fn primitive_box(source: &Source<'_>, id: usize) -> Option<Aabb> {
    match *source {
        Source::Triangles { positions, triangles, scale } => {
            let p = triangles[id].map(|v| positions[v as usize].map(|x| x * scale));
            let distinct = p[0] != p[1] && p[1] != p[2] && p[2] != p[0];
            let bounds = p.iter().fold(Aabb::EMPTY, |b, &p| b.grow(p));
            let finite = p.iter().flatten().all(|x| x.is_finite());
            (finite && distinct).then_some(bounds)
        }
        Source::Boxes { boxes, scale, .. } => {
            let b = Aabb::new(boxes[id].min.map(|x| x * scale), boxes[id].max.map(|x| x * scale));
            b.is_valid().then_some(b)
        }
    }
}

/// Checks everything that traversal relies on. With `unsplit`, every primitive must be in exactly one leaf.
pub(super) fn validate(tree: &WideTree, source: &Source<'_>, unsplit: bool) -> Result<(), String> {
    let mut check = Check {
        tree,
        source,
        unsplit,
        next_node: 0,
        next_block: 0,
        leaf_boxes: vec![Vec::new(); source.len()],
        max_depth: 0,
        leaves: 0,
        references: 0,
    };
    if !tree.nodes.is_empty() {
        check.node(ChildRef::node(0), &mut Vec::new())?;
    }
    check.totals()
}

struct Check<'a> {
    tree: &'a WideTree,
    source: &'a Source<'a>,
    unsplit: bool,
    next_node: usize,
    next_block: usize,
    /// For each primitive, the boxes of the leaves it is in.
    leaf_boxes: Vec<Vec<Aabb>>,
    max_depth: usize,
    leaves: usize,
    references: usize,
}

impl Check<'_> {
    fn node(&mut self, reference: ChildRef, ancestors: &mut Vec<Aabb>) -> Result<(), String> {
        let index = reference.index();
        if index != self.next_node || index >= self.tree.nodes.len() {
            return Err(format!("node {index} should be {}", self.next_node));
        }
        self.next_node += 1;
        let depth = ancestors.len() + 1;
        self.max_depth = self.max_depth.max(depth);
        if depth > MAX_WIDE_DEPTH {
            return Err(format!("node {index} is at depth {depth}"));
        }
        let node = &self.tree.nodes[index];
        check_order(node).map_err(|e| format!("node {index}: {e}"))?;
        let mut used = 0;
        for child in 0..8 {
            let (bounds, reference) = (node.bounds(child), node.children[child]);
            if reference == ChildRef::EMPTY {
                if bounds != Aabb::EMPTY {
                    return Err(format!("empty child {child} of node {index} has the box {bounds:?}"));
                }
                continue;
            }
            used += 1;
            if !bounds.is_valid() {
                return Err(format!("child {child} of node {index} has the box {bounds:?}"));
            }
            if let Some(outer) = ancestors.last().filter(|outer| !outer.contains(bounds)) {
                return Err(format!("{bounds:?} of node {index} exceeds {outer:?}"));
            }
            ancestors.push(bounds);
            if reference.is_leaf() {
                self.leaf(reference, bounds)?;
            } else {
                self.node(reference, ancestors)?;
            }
            ancestors.pop();
        }
        if used == 0 || used == 1 && index != 0 {
            return Err(format!("node {index} has {used} children"));
        }
        Ok(())
    }

    fn leaf(&mut self, leaf: ChildRef, bounds: Aabb) -> Result<(), String> {
        let width = self.source.block_width();
        let first = leaf.first_block();
        if first != self.next_block || leaf.blocks() == 0 {
            return Err(format!("leaf {leaf:?} begins at block {first}, not at {}", self.next_block));
        }
        self.next_block += leaf.blocks();
        self.leaves += 1;
        let Some(slots) = self.tree.slots.get(first * width..self.next_block * width) else {
            return Err(format!("leaf {leaf:?} is beyond the slots"));
        };
        let used = slots.iter().position(|&id| id == NO_PRIMITIVE).unwrap_or(slots.len());
        self.references += used;
        if slots[used..].iter().any(|&id| id != NO_PRIMITIVE) || used + width <= slots.len() {
            return Err(format!("leaf {leaf:?} has gaps: {slots:?}"));
        }
        if !slots[..used].is_sorted_by(|a, b| a < b) {
            return Err(format!("leaf {leaf:?} is not in order: {slots:?}"));
        }
        for &id in &slots[..used] {
            let Some(of_primitive) = self.leaf_boxes.get_mut(id as usize) else {
                return Err(format!("primitive {id} does not exist"));
            };
            of_primitive.push(bounds);
        }
        Ok(())
    }

    fn totals(&self) -> Result<(), String> {
        let (tree, stats) = (self.tree, &self.tree.stats);
        let mut primitives = 0;
        for (id, leaf_boxes) in self.leaf_boxes.iter().enumerate() {
            let expected = primitive_box(self.source, id);
            primitives += usize::from(expected.is_some());
            match (expected, leaf_boxes.len()) {
                (None, 0) => {}
                (None, _) => return Err(format!("primitive {id} should have been omitted")),
                (Some(_), 0) => return Err(format!("primitive {id} is missing")),
                (Some(b), 1) if leaf_boxes[0].contains(b) => {}
                (Some(b), 1) => {
                    return Err(format!("primitive {id} {b:?} exceeds {:?}", leaf_boxes[0]));
                }
                (Some(_), n) if self.unsplit => return Err(format!("primitive {id} is in {n} leaves")),
                (Some(_), _) => check_cover(self.source, id, leaf_boxes)?,
            }
        }
        let expected = (self.next_node, self.next_block * self.source.block_width());
        if expected != (tree.nodes.len(), tree.slots.len()) {
            return Err(format!("{expected:?} of {} nodes, {} slots", tree.nodes.len(), tree.slots.len()));
        }
        let counted =
            (primitives, self.references, self.next_node, self.leaves, self.next_block, self.max_depth);
        let said =
            (stats.primitives, stats.references, stats.nodes, stats.leaves, stats.blocks, stats.max_depth);
        if counted != said || stats.primitives + stats.non_finite + stats.degenerate != self.source.len() {
            return Err(format!("counted {counted:?}, but {stats:?}"));
        }
        Ok(())
    }
}

/// Checks that leaf boxes cover a triangle, at sample points on it.
fn check_cover(source: &Source<'_>, id: usize, leaf_boxes: &[Aabb]) -> Result<(), String> {
    let Source::Triangles { positions, triangles, scale } = *source else {
        return Err(format!("box {id} is in {} leaves", leaf_boxes.len()));
    };
    let p = triangles[id].map(|v| positions[v as usize].map(|x| f64::from(x * scale)));
    let steps = 24;
    for i in 0..=steps {
        for j in 0..=steps - i {
            let (u, v) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
            let at: [f64; 3] = std::array::from_fn(|k| p[0][k] * (1.0 - u - v) + p[1][k] * u + p[2][k] * v);
            // The point itself is rounded.
            let slack: [f64; 3] =
                std::array::from_fn(|k| 1e-15 * p.iter().map(|p| p[k].abs()).fold(0.0, f64::max));
            let covered = leaf_boxes.iter().any(|b| {
                (0..3).all(|k| {
                    f64::from(b.min[k]) - slack[k] <= at[k] && at[k] <= f64::from(b.max[k]) + slack[k]
                })
            });
            if !covered {
                return Err(format!("no leaf of triangle {id} holds its point {at:?}: {leaf_boxes:?}"));
            }
        }
    }
    Ok(())
}

fn check_order(node: &WideNode) -> Result<(), String> {
    let used = node.children.iter().filter(|&&child| child != ChildRef::EMPTY).count();
    for (octant, &word) in node.order.iter().enumerate() {
        let slots: Vec<usize> = (0..8).rev().map(|place| (word >> (3 * place) & 7) as usize).collect();
        let mut sorted = slots.clone();
        sorted.sort_unstable();
        if sorted != (0..8).collect::<Vec<_>>() || word >> 24 != 0 {
            return Err(format!("{word:o} is not a permutation"));
        }
        if slots[..used].iter().any(|&child| node.children[child] == ChildRef::EMPTY) {
            return Err(format!("{word:o} has empty slots before others"));
        }
        // A child that the diagonal enters later must not come first.
        let entry = |child: usize| -> f64 {
            let b = node.bounds(child);
            (0..3).map(|i| f64::from(if octant >> i & 1 == 0 { b.min[i] } else { -b.max[i] })).sum()
        };
        for pair in slots[..used].windows(2) {
            let (a, b) = (entry(pair[0]), entry(pair[1]));
            let largest = (0..used).map(|i| entry(slots[i]).abs()).fold(0.0, f64::max);
            let slack: f64 = (0..8)
                .filter(|&i| node.children[i] != ChildRef::EMPTY)
                .flat_map(|i| {
                    let b = node.bounds(i);
                    b.min.into_iter().chain(b.max)
                })
                .map(|x| f64::from(x.abs()))
                .fold(largest, f64::max)
                * 1e-5
                + 1e-43;
            if a > b + slack && a.abs() < 1e38 && b.abs() < 1e38 {
                return Err(format!("octant {octant}: {} enters at {a}, {} at {b}", pair[0], pair[1]));
            }
        }
    }
    Ok(())
}
