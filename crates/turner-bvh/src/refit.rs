//! New boxes for a tree whose primitives have moved: the same nodes, in time proportional to their number.

use std::fmt;

use crate::build::wide::{NO_PRIMITIVE, set_order};
use crate::bvh::scale;
use crate::node::{ChildRef, WideNode};
use crate::traverse::Space;
use crate::triangle::Block;
use crate::{Aabb, Bvh, Triangles};

/// Why a tree was not refitted; it is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// There are more or fewer primitives than the tree was built over.
    Count {
        /// How many there were.
        built: usize,
        /// How many there are.
        given: usize,
    },
    /// A triangle names a vertex that is not there.
    VertexOutOfRange {
        /// Number of the triangle.
        triangle: usize,
        /// Number of the vertex.
        vertex: u32,
    },
    /// A primitive that was left out when the tree was built (its numbers were not finite, or it had no extent) could
    /// be hit now: the tree has no place for it.
    LeftOut {
        /// Its number.
        primitive: usize,
    },
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            RefitError::Count { built, given } => {
                write!(f, "the tree was built over {built} primitives, not {given}")
            }
            RefitError::VertexOutOfRange { triangle, vertex } => {
                write!(f, "triangle {triangle} names vertex {vertex}, which is not there")
            }
            RefitError::LeftOut { primitive } => {
                write!(f, "primitive {primitive} was left out when the tree was built")
            }
        }
    }
}

impl std::error::Error for RefitError {}

/// Sets all boxes from those of the leaves, bottom-up, and the order of children after them. Empty places, and leaves
/// whose box is not valid, get the empty box.
pub(crate) fn refit(nodes: &mut [WideNode], leaf: impl Fn(ChildRef) -> Aabb) {
    let mut boxes = vec![Aabb::EMPTY; nodes.len()];
    // Depth first: children come after their parents.
    for (index, node) in nodes.iter_mut().enumerate().rev() {
        let mut all = Aabb::EMPTY;
        for i in 0..8 {
            let child = node.children[i];
            let bounds = match child {
                ChildRef::EMPTY => continue,
                leaf_child if leaf_child.is_leaf() => leaf(leaf_child),
                node => {
                    debug_assert!(node.index() > index);
                    boxes[node.index()]
                }
            };
            let there = (0..3).all(|axis| bounds.min[axis] <= bounds.max[axis]);
            let bounds = if there { bounds } else { Aabb::EMPTY };
            node.set(i, bounds, child);
            all = all.union(bounds);
        }
        set_order(node);
        boxes[index] = all;
    }
}

/// The primitives that are in no leaf.
pub(crate) fn left_out(slots: impl Iterator<Item = u32>, count: usize) -> Vec<u32> {
    let mut there = vec![false; count];
    for id in slots.filter(|&id| id != NO_PRIMITIVE) {
        there[id as usize] = true;
    }
    (0..count as u32).filter(|&id| !there[id as usize]).collect()
}

/// Whether every number is finite.
pub(crate) fn finite(corners: &[[f32; 3]]) -> bool {
    corners.iter().flatten().all(|x| x.is_finite())
}

impl Bvh {
    /// Takes on moved vertices, for the same triangles. Much faster than to build anew; rays become slower as far as
    /// triangles that were neighbours no longer are. Triangles whose numbers are no longer finite are not hit.
    pub fn refit(&mut self, mesh: &Triangles<'_>) -> Result<(), RefitError> {
        let (positions, triangles) = (mesh.positions, mesh.triangles);
        if triangles.len() != self.count {
            return Err(RefitError::Count { built: self.count, given: triangles.len() });
        }
        let missing = |t: &[u32; 3]| t.iter().copied().find(|&vertex| vertex as usize >= positions.len());
        if let Some((triangle, vertex)) =
            triangles.iter().enumerate().find_map(|(i, t)| Some((i, missing(t)?)))
        {
            return Err(RefitError::VertexOutOfRange { triangle, vertex });
        }
        let scale = scale(positions);
        let corners = |id: u32| triangles[id as usize].map(|i| positions[i as usize].map(|x| x * scale));
        if self.stats.non_finite + self.stats.degenerate > 0 {
            for id in left_out(self.blocks.iter().flat_map(|b| b.ids), self.count) {
                let [a, b, c] = corners(id);
                if finite(&[a, b, c]) && a != b && b != c && c != a {
                    return Err(RefitError::LeftOut { primitive: id as usize });
                }
            }
        }
        let mut boxes = Vec::with_capacity(self.blocks.len());
        for block in &mut self.blocks {
            let ids = block.ids;
            let mut bounds = Aabb::EMPTY;
            *block = Block::EMPTY;
            for (lane, id) in ids.into_iter().enumerate().filter(|(_, id)| *id != NO_PRIMITIVE) {
                let p = corners(id);
                if finite(&p) {
                    // Of the whole triangle, even where spatial splits made this leaf for a part of it.
                    bounds = p.into_iter().fold(bounds, Aabb::grow);
                    block.set(lane, id, p);
                } else {
                    block.ids[lane] = id;
                }
            }
            boxes.push(bounds);
        }
        refit(&mut self.nodes, |leaf| {
            let blocks = &boxes[leaf.first_block()..leaf.first_block() + leaf.blocks()];
            blocks.iter().copied().fold(Aabb::EMPTY, Aabb::union)
        });
        self.space = Space::of(scale, &self.nodes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Random, SceneKind};
    use crate::levels::tests::kernels;
    use crate::{BuildOptions, Hit, Quality, Ray, oracle};

    /// Towards triangles where they are now, from all around.
    fn rays(mesh: &Triangles<'_>, random: &mut Random) -> Vec<Ray> {
        let all = mesh.positions.iter().flatten().copied().filter(|x| x.is_finite());
        let reach = all.fold(0.0, |a: f32, x| a.max(x.abs()));
        (0..200)
            .map(|i| {
                let corners =
                    mesh.triangles[(i * 31) % mesh.triangles.len()].map(|v| mesh.positions[v as usize]);
                let target: [f32; 3] = std::array::from_fn(|k| corners.iter().map(|p| p[k] / 3.0).sum());
                let origin = random.in_cube().map(|x| 0.9 * x * reach);
                Ray::new(origin, std::array::from_fn(|k| target[k] - origin[k]))
            })
            .collect()
    }

    fn check(bvh: &Bvh, mesh: &Triangles<'_>, rays: &[Ray]) -> usize {
        let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize].map(|x| x * bvh.space.scale));
        let all: Vec<_> = mesh.triangles.iter().enumerate().map(|(i, t)| (i as u32, corners(t))).collect();
        let all: Vec<_> = all.into_iter().filter(|(_, t)| finite(t)).collect();
        let expected: Vec<Hit> = rays.iter().map(|ray| oracle::closest(&all, ray, &bvh.space)).collect();
        kernels(|kernel| {
            let mut hits = vec![Hit::MISS; rays.len()];
            bvh.intersect_batch(rays, &mut hits);
            for (i, ray) in rays.iter().enumerate() {
                assert_eq!(hits[i], expected[i], "{kernel} {ray:?}");
                assert_eq!(bvh.occluded(ray), expected[i].is_hit(), "{kernel} {ray:?}");
            }
        });
        expected.iter().filter(|h| h.is_hit()).count()
    }

    #[test]
    fn moved_meshes_equal_brute_force() {
        let mut random = Random::new(12);
        for (kind, quality) in [
            (SceneKind::Architecture, Quality::Balanced),
            (SceneKind::Architecture, Quality::High),
            (SceneKind::Sticks, Quality::High),
            (SceneKind::Cornell, Quality::Fast),
        ] {
            let scene = kind.generate(2_000);
            let mesh = &scene.meshes[0];
            let first = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
            let options = BuildOptions { quality, ..BuildOptions::default() };
            let mut bvh = Bvh::build(&first, &options).unwrap();
            // Bent, scattered, far away, and back again.
            for round in 0..4 {
                let mut positions = mesh.positions.clone();
                for p in &mut positions {
                    match round {
                        0 => p[0] += 0.3 * p[1] * p[1],
                        1 => *p = random.in_cube(),
                        2 => *p = p.map(|x| 1e13 * x),
                        _ => {}
                    }
                }
                if round == 1 {
                    positions[5][1] = f32::NAN;
                }
                let moved = Triangles { positions: &positions, triangles: &mesh.triangles };
                bvh.refit(&moved).unwrap();
                let hits = check(&bvh, &moved, &rays(&moved, &mut random));
                assert!(hits > 100, "{kind:?} {round}: {hits}");
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let mesh = Triangles { positions: &positions, triangles: &triangles };
        let mut bvh = Bvh::build(&mesh, &BuildOptions::default()).unwrap();
        assert_eq!(bvh.stats().degenerate, 1);
        bvh.refit(&mesh).unwrap();
        let less = Triangles { triangles: &triangles[1..], ..mesh };
        assert_eq!(bvh.refit(&less), Err(RefitError::Count { built: 2, given: 1 }));
        let fewer = Triangles { positions: &positions[1..], ..mesh };
        assert_eq!(bvh.refit(&fewer), Err(RefitError::VertexOutOfRange { triangle: 1, vertex: 3 }));
        let mut moved = positions;
        moved[3] = [1.0; 3];
        let grown = Triangles { positions: &moved, ..mesh };
        assert_eq!(bvh.refit(&grown), Err(RefitError::LeftOut { primitive: 1 }));
        assert!(bvh.intersect(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])).is_some());
    }
}
