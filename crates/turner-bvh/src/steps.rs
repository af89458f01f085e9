//! Counts the nodes and blocks that a ray visits, for debug views and statistics.
//!
//! Works in double precision, without SIMD and without an order, so that counts are the same with every
//! [`InstructionSet`](crate::InstructionSet).

use std::ops::Range;

use crate::node::{ChildRef, MAX_WIDE_DEPTH, WideNode};
use crate::{BoxBvh, Bvh, Ray};

/// What a ray visits in a BVH over triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps {
    /// Nodes.
    pub nodes: u64,
    /// Blocks of eight triangles in leaves.
    pub blocks: u64,
}

impl Bvh {
    /// Counts what the ray intersects with `t_min <= t <= t_max`. With `t_max` at the nearest hit, that is what
    /// traversal in front-to-back order must visit.
    pub fn steps(&self, ray: &Ray) -> Steps {
        let mut blocks = 0;
        let mut walk = |nodes| walk(nodes, self.space.unscale, ray, |leaf| blocks += leaf.blocks() as u64);
        let nodes = walk(&self.nodes) + self.changed.as_ref().map_or(0, |changed| walk(changed.nodes()));
        Steps { nodes, blocks }
    }
}

impl BoxBvh {
    /// Counts the nodes that the ray intersects with `t_min <= t <= t_max`. `leaf` gets the primitives of each leaf
    /// that it intersects, as a range of positions in [`order`](Self::order).
    pub fn steps(&self, ray: &Ray, mut leaf: impl FnMut(Range<u32>)) -> u64 {
        walk(&self.nodes, self.space.unscale, ray, |child| {
            let first = child.first_block() as u32;
            leaf(first..first + child.blocks() as u32);
        })
    }
}

/// Visits all nodes and leaves whose boxes the ray intersects; returns the number of nodes.
fn walk(nodes: &[WideNode], unscale: f32, ray: &Ray, mut leaf: impl FnMut(ChildRef)) -> u64 {
    // Each level leaves at most seven children on the stack.
    let mut stack = [ChildRef::EMPTY; 8 * MAX_WIDE_DEPTH];
    let (mut count, mut height) = (0, 0);
    if !nodes.is_empty() && ray.is_valid() {
        (stack[0], height) = (ChildRef::node(0), 1);
    }
    while height > 0 {
        height -= 1;
        let child = stack[height];
        if child.is_leaf() {
            leaf(child);
            continue;
        }
        let Some(node) = nodes.get(child.index()) else { continue };
        count += 1;
        for (i, child) in node.children.iter().enumerate() {
            if *child != ChildRef::EMPTY
                && height < stack.len()
                && intersects(node, i, f64::from(unscale), ray)
            {
                stack[height] = *child;
                height += 1;
            }
        }
    }
    count
}

/// Whether a ray intersects the box of a child.
fn intersects(node: &WideNode, child: usize, unscale: f64, ray: &Ray) -> bool {
    let (mut first, mut last) = (f64::from(ray.t_min), f64::from(ray.t_max));
    for axis in 0..3 {
        let (o, d) = (f64::from(ray.origin[axis]), f64::from(ray.direction[axis]));
        let [low, high] = node.planes[axis].map(|planes| f64::from(planes[child]) * unscale - o);
        if d == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (low / d, high / d);
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    first <= last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aabb, BuildOptions, Triangles};

    /// Small triangles across the z axis, one behind the other, so far apart that each has its own box.
    fn row(count: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let corners = |i: usize| {
            let z = 100.0 * i as f32;
            [[-1.0, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]]
        };
        let positions = (0..count).flat_map(corners).collect();
        (positions, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
    }

    #[test]
    fn nodes_behind_t_max_or_off_the_ray_are_not_counted() {
        let (positions, triangles) = row(1000);
        let mesh = Triangles { positions: &positions, triangles: &triangles };
        let bvh = Bvh::build(&mesh, &BuildOptions::default()).unwrap();
        let along = Ray::new([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
        let all = bvh.steps(&along);
        // Everything.
        assert_eq!((all.nodes, all.blocks), (bvh.nodes.len() as u64, bvh.blocks.len() as u64));
        let near = bvh.steps(&Ray { t_max: 1.0, ..along });
        assert!(near.blocks == 1 && near.nodes < 6, "{near:?}");
        let half = bvh.steps(&Ray { t_max: 50_000.0, ..along });
        assert!(half.blocks.abs_diff(all.blocks / 2) <= 2, "{half:?} of {all:?}");
        let off_ray = bvh.steps(&Ray::new([5.0, 0.0, -1.0], [0.0, 0.0, 1.0]));
        assert_eq!((off_ray.nodes, off_ray.blocks), (1, 0));
        assert_eq!(bvh.steps(&Ray::new([f32::NAN; 3], [0.0, 0.0, 1.0])), Steps::default());
    }

    #[test]
    fn leaves_of_boxes_are_those_of_traversal() {
        let boxes: Vec<Aabb> = (0..200)
            .map(|i| {
                let p = [i * 7 % 31, i * 13 % 29, i * 17 % 23].map(|v| v as f32);
                Aabb::new(p, p.map(|v| v + 1.5))
            })
            .collect();
        let bvh = BoxBvh::build(&boxes, &BuildOptions::default()).unwrap();
        let (mut nodes, mut visited, mut more) = (0, 0, 0);
        for i in 0..100u32 {
            // From one side, each a little higher and further to the side.
            let position = [i % 10, i / 10].map(|v| 3.0 * v as f32 + 0.4);
            let ray = Ray::new([-1.0, position[0], position[1]], [1.0, 0.1 - 0.02 * (i % 7) as f32, 0.05]);
            let (mut walked, mut searched) = (Vec::new(), Vec::new());
            nodes += bvh.steps(&ray, |leaf| walked.extend(leaf));
            bvh.closest(&ray, |leaf, t_max| {
                searched.extend(leaf);
                t_max
            });
            // Traversal pads the boxes a little.
            assert!(walked.iter().all(|leaf| searched.contains(leaf)), "ray {i}: {walked:?} {searched:?}");
            visited += walked.len();
            more += searched.len() - walked.len();
        }
        assert!(
            nodes > 200 && visited > 40 && 10 * more < visited,
            "{nodes} nodes, {visited} boxes, {more} more"
        );
    }
}
