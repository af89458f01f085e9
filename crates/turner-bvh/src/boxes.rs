//! The boxes of a BVH by depth, for drawings.

use crate::node::WideNode;
use crate::{Aabb, BoxBvh, Bvh};

/// The boxes of a level, in breadth-first order: for depth 0 the box of everything, for depth 1 those of the root's children,
/// and so on. A leaf above that depth is represented by its own box, so the boxes of each depth contain everything. At most
/// `limit` boxes; the level above is returned where a level has more.
fn boxes(nodes: &[WideNode], unscale: f32, depth: u32, limit: usize) -> Vec<Aabb> {
    let Some(root) = nodes.first() else { return Vec::new() };
    let filled = |node: &WideNode| {
        let slots = (0..8).map(|i| (node.bounds(i), node.children[i]));
        slots.filter(|(_, child)| !child.is_leaf() || child.blocks() > 0).collect::<Vec<_>>()
    };
    let all = filled(root).iter().fold(Aabb::EMPTY, |all, (bounds, _)| all.union(*bounds));
    // Boxes of the present level, with their nodes if they are no leaves.
    let mut level = vec![(all, Some(0))];
    level.truncate(limit);
    for _ in 0..depth {
        let mut next = Vec::with_capacity(level.len());
        for (bounds, node) in &level {
            match node.and_then(|node: usize| nodes.get(node)) {
                Some(node) => {
                    let child =
                        |(b, c): (Aabb, crate::node::ChildRef)| (b, (!c.is_leaf()).then(|| c.index()));
                    next.extend(filled(node).into_iter().map(child));
                }
                None => next.push((*bounds, None)),
            }
            if next.len() > limit {
                break;
            }
        }
        if next.len() > limit {
            break;
        }
        let is_same = level.iter().all(|(_, node)| node.is_none());
        level = next;
        if is_same {
            break;
        }
    }
    let of = |b: &Aabb| Aabb::new(b.min.map(|x| x * unscale), b.max.map(|x| x * unscale));
    level.iter().map(|(b, _)| of(b)).collect()
}

impl Bvh {
    /// The boxes of the nodes at a depth, at most `limit`: one at depth 0, their children at depth 1, and so on. Leaves above
    /// that depth count with their own boxes, so that the boxes contain all triangles. Where a depth has more than `limit`
    /// boxes, those of the deepest one that has not are returned.
    pub fn boxes(&self, depth: u32, limit: usize) -> Vec<Aabb> {
        boxes(&self.nodes, self.space.unscale, depth, limit)
    }
}

impl BoxBvh {
    /// The boxes of the nodes at a depth, as for [`Bvh::boxes`].
    pub fn boxes(&self, depth: u32, limit: usize) -> Vec<Aabb> {
        boxes(&self.nodes, self.space.unscale, depth, limit)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Aabb, BoxBvh, BuildOptions};

    #[test]
    fn each_depth_contains_all_boxes_and_gets_tighter() {
        let at = |i: u32| [(i % 16) as f32 * 3.0, (i / 16 % 16) as f32 * 2.0, (i / 256) as f32];
        let given: Vec<Aabb> = (0..2048).map(|i| Aabb::new(at(i), at(i).map(|v| v + 0.5))).collect();
        let bvh = BoxBvh::build(&given, &BuildOptions::default()).unwrap();
        let volume = |boxes: &[Aabb]| -> f32 {
            boxes.iter().map(|b| (0..3).map(|a| b.max[a] - b.min[a]).product::<f32>()).sum()
        };
        let contains =
            |b: &Aabb, inner: &Aabb| (0..3).all(|a| b.min[a] <= inner.min[a] && b.max[a] >= inner.max[a]);
        let mut last = (0, f32::INFINITY);
        for depth in 0..4 {
            let boxes = bvh.boxes(depth, 10_000);
            assert!(given.iter().all(|g| boxes.iter().any(|b| contains(b, g))), "{depth}");
            assert!(boxes.len() > last.0 && volume(&boxes) < last.1, "{depth}: {} boxes", boxes.len());
            last = (boxes.len(), volume(&boxes));
        }
        assert_eq!(bvh.boxes(0, 10), vec![bvh.bounds()]);
        // Too many for the limit: the level above.
        assert_eq!(bvh.boxes(30, 8), bvh.boxes(1, 8));
        assert!(bvh.boxes(30, 0).is_empty());
    }
}
