//! Validates the structure of a [`Bvh2`].

use crate::bvh2::Node;
use crate::{Aabb, Bvh2, MAX_DEPTH};

impl Bvh2 {
    /// Checks the BVH against the boxes it was built from and reports the first defect:
    ///
    /// * each primitive is in exactly one leaf, or dropped if its box is not valid;
    /// * the box of each child contains the boxes of all primitives below it;
    /// * nodes are in depth-first order, each has one parent, and none is deeper than [`MAX_DEPTH`].
    pub fn validate(&self, bounds: &[Aabb]) -> Result<(), String> {
        self.check_order(bounds)?;
        let leaf_boxes: Vec<Aabb> = self.order().iter().map(|&i| bounds[i as usize]).collect();
        check_nodes(self.nodes(), &leaf_boxes)
    }

    fn check_order(&self, bounds: &[Aabb]) -> Result<(), String> {
        let mut seen = vec![false; bounds.len()];
        for (list, valid) in [(self.order(), true), (self.dropped(), false)] {
            for &index in list {
                let Some(seen) = seen.get_mut(index as usize) else {
                    return Err(format!("primitive {index} of {}", bounds.len()));
                };
                if std::mem::replace(seen, true) {
                    return Err(format!("primitive {index} occurs twice"));
                }
                if bounds[index as usize].is_valid() != valid {
                    return Err(format!("primitive {index} is on the wrong list"));
                }
            }
        }
        match seen.iter().position(|seen| !seen) {
            Some(index) => Err(format!("primitive {index} is missing")),
            None => Ok(()),
        }
    }
}

/// Walks depth first and expects nodes and positions to appear in order, each once.
fn check_nodes(nodes: &[Node], leaf_boxes: &[Aabb]) -> Result<(), String> {
    let (mut next_node, mut next_position) = (0, 0);
    // Children still to visit, the next one last: node, side, and the boxes of its ancestors.
    let mut pending: Vec<(usize, usize, Vec<Aabb>)> = Vec::new();
    if !nodes.is_empty() {
        next_node = 1;
        pending.extend([(0, 1, Vec::new()), (0, 0, Vec::new())]);
    }
    while let Some((index, side, mut ancestors)) = pending.pop() {
        let node = &nodes[index];
        ancestors.push(node.bounds(side));
        if ancestors.len() > MAX_DEPTH {
            return Err(format!("node {index} is deeper than {MAX_DEPTH}"));
        }
        if let Some(positions) = node.leaf(side) {
            if positions.is_empty() && node.bounds(side) == Aabb::EMPTY {
                continue;
            }
            if positions.start as usize != next_position {
                return Err(format!("the leaf at {} should be at {next_position}", positions.start));
            }
            next_position = positions.end as usize;
            let Some(boxes) = leaf_boxes.get(positions.start as usize..next_position) else {
                return Err(format!("the leaf {positions:?} is beyond {}", leaf_boxes.len()));
            };
            for b in boxes {
                if let Some(outer) = ancestors.iter().position(|outer| !outer.contains(*b)) {
                    return Err(format!("{b:?} in leaf {positions:?} exceeds the box at depth {outer}"));
                }
            }
        } else {
            let child = node.child(side);
            if child != next_node || child >= nodes.len() {
                return Err(format!(
                    "child {child} of node {index} should be {next_node} of {}",
                    nodes.len()
                ));
            }
            next_node += 1;
            pending.extend([(child, 1, ancestors.clone()), (child, 0, ancestors)]);
        }
    }
    if (next_node, next_position) != (nodes.len(), leaf_boxes.len()) {
        return Err(format!(
            "{next_node} of {} nodes and {next_position} of {} primitives can be reached",
            nodes.len(),
            leaf_boxes.len()
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bvh2Options;
    use crate::bvh2::Child;

    fn unit(x: f32) -> Aabb {
        Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])
    }

    fn node(left: (Aabb, Child), right: (Aabb, Child)) -> Node {
        Node::new([left, right])
    }

    #[test]
    fn a_valid_bvh_passes_and_other_boxes_fail() {
        let mut boxes: Vec<Aabb> = (0..100).map(|i| unit(i as f32)).collect();
        let bvh = Bvh2::build(&boxes, &Bvh2Options::default()).unwrap();
        bvh.validate(&boxes).unwrap();
        assert!(bvh.validate(&boxes[..99]).unwrap_err().contains("primitive"));
        boxes[50] = boxes[50].grow([50.0, 2.0, 0.0]);
        assert!(bvh.validate(&boxes).unwrap_err().contains("exceeds the box"));
        boxes[50] = Aabb::EMPTY;
        assert!(bvh.validate(&boxes).unwrap_err().contains("wrong list"));
        boxes[50] = unit(50.0);
        boxes.push(unit(3.0));
        assert!(bvh.validate(&boxes).unwrap_err().contains("missing"));
    }

    #[test]
    fn each_broken_node_is_found() {
        let boxes = [unit(0.0), unit(2.0), unit(4.0)];
        let all = boxes[0].union(boxes[2]);
        let (a, b, c) = (Child::leaf(0, 1), Child::leaf(1, 1), Child::leaf(2, 1));
        let lower = node((boxes[1], b), (boxes[2], c));
        let good = [node((boxes[0], a), (all, Child::node(1))), lower];
        assert_eq!(check_nodes(&good, &boxes), Ok(()));
        for (what, bad) in [
            ("a loop", vec![node((boxes[0], a), (all, Child::node(0))), lower]),
            ("out of range", vec![node((boxes[0], a), (all, Child::node(1)))]),
            (
                "unreachable node",
                vec![node((boxes[0], Child::leaf(0, 3)), (Aabb::EMPTY, Child::leaf(0, 0))), lower],
            ),
            ("a primitive twice", vec![node((all, a), (all, Child::leaf(0, 2)))]),
            ("a primitive omitted", vec![node((boxes[0], a), (boxes[1], b))]),
            ("positions beyond the end", vec![node((boxes[0], a), (all, Child::leaf(1, 9)))]),
            ("a box too small", vec![node((boxes[0], a), (boxes[1], Child::leaf(1, 2)))]),
            ("a box above too small", vec![node((boxes[0], a), (boxes[1], Child::node(1))), lower]),
        ] {
            assert!(check_nodes(&bad, &boxes).is_err(), "{what}");
        }
    }
}
