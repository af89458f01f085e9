//! High-quality binary trees: top-down SAH with object splits and spatial splits (SBVH; Stich, Friedrich, Dietrich
//! 2009).
//!
//! An object split divides the primitives; a spatial split divides space and references a straddling triangle on both
//! sides ([`spatial`](super::spatial)). A spatial split is tried only where the boxes of the best object split overlap
//! by more than a fraction of the root's area, and is taken if it is cheaper and its duplicates fit the budget.
//!
//! All sets above [`MAX_TASK`] are split level by level; the subtrees below are independent tasks. The budget of
//! duplicates is divided in proportion to the primitives, so the tree does not depend on threads.
//! [`reinsertion`](super::reinsertion) then improves the finished tree.

use super::super::BuildError;
use super::binary::{BinaryBuilder, BinaryTree};
use super::bins::{Grid, best_split, halve, partition};
use super::parallel::{Progress, each};
use super::prims::{Bounds, Costs, Prim, Set};
use super::spatial::{SpatialBins, Triangles, cut};
use super::sweep::MAX_SWEEP;

/// Sets up to this size are built by one thread. The tree does not depend on it.
const MAX_TASK: usize = 1 << 14;

/// Bins per axis for object splits.
const BINS: usize = 32;

/// Below this depth sets are halved.
const MAX_DEPTH: usize = 96;

/// A spatial split is tried if the overlap of the best object split exceeds this fraction of the root's area.
const MIN_OVERLAP: f32 = 1e-5;

/// The overlap must also exceed this fraction of the set's area. Scans rarely reach it, which halves the build time
/// there.
const MIN_RELATIVE_OVERLAP: f32 = 0.2;

/// A set that owns its primitives.
struct Owned {
    prims: Vec<Prim>,
    measures: Measures,
}

/// Bounds, budget and depth of a set.
#[derive(Clone, Copy)]
struct Measures {
    bounds: Bounds,
    centers: Bounds,
    /// Duplicate references that spatial splits may add.
    budget: usize,
    depth: usize,
}

/// The parts of a set: the first has the first `middle` primitives.
struct Parts {
    middle: usize,
    measures: [Measures; 2],
}

/// A node of the binary tree above the tasks.
enum Upper {
    Waiting(Owned),
    Inner { bounds: Bounds, children: [usize; 2] },
    Done(BinaryTree),
    Taken,
}

pub(super) struct High<'a> {
    pub(super) costs: Costs,
    pub(super) triangles: Option<Triangles<'a>>,
    pub(super) threads: usize,
    pub(super) progress: &'a Progress<'a>,
}

impl High<'_> {
    /// Builds the binary tree of the set, with at most `budget` duplicate references.
    pub(super) fn build(
        &self,
        prims: Vec<Prim>,
        bounds: Bounds,
        centers: Bounds,
        budget: usize,
    ) -> Result<BinaryTree, BuildError> {
        let root_area = bounds.area(self.costs.pad);
        let worker = || Worker {
            binary: BinaryBuilder::new(self.costs, BINS, false),
            spatial: SpatialBins::new(),
            room: Vec::new(),
            triangles: self.triangles,
            root_area,
        };
        let measures = Measures { bounds, centers, budget, depth: 0 };
        let mut upper = vec![Upper::Waiting(Owned { prims, measures })];
        // Split all large sets of a level in parallel until only tasks are left.
        loop {
            let large: Vec<(usize, Owned)> = upper
                .iter_mut()
                .enumerate()
                .filter_map(|(i, node)| match node {
                    Upper::Waiting(set) if set.prims.len() > MAX_TASK => {
                        match std::mem::replace(node, Upper::Taken) {
                            Upper::Waiting(set) => Some((i, set)),
                            _ => None,
                        }
                    }
                    _ => None,
                })
                .collect();
            if large.is_empty() {
                break;
            }
            let split = each(self.threads, large, |(index, set)| {
                let (count, bounds) = (set.prims.len(), set.measures.bounds);
                let parts = worker().split_owned(set);
                self.progress.advance(count).map(|()| (index, bounds, parts))
            });
            for result in split {
                let (index, bounds, parts) = result?;
                let children = [upper.len(), upper.len() + 1];
                upper.extend(parts.map(Upper::Waiting));
                upper[index] = Upper::Inner { bounds, children };
            }
        }
        let tasks: Vec<(usize, Owned)> = upper
            .iter_mut()
            .enumerate()
            .filter_map(|(i, node)| match std::mem::replace(node, Upper::Taken) {
                Upper::Waiting(set) => Some((i, set)),
                other => {
                    *node = other;
                    None
                }
            })
            .collect();
        let done = each(self.threads, tasks, |(index, mut set)| {
            let count = set.prims.len();
            let mut worker = worker();
            worker.subtree(&mut set.prims, 0, set.measures);
            self.progress.advance(super::top::work_of(count) / 2).map(|()| (index, worker.binary.tree))
        });
        for result in done {
            let (index, tree) = result?;
            upper[index] = Upper::Done(tree);
        }
        let mut tree = BinaryTree::default();
        join(&mut upper, 0, &mut tree, &self.costs);
        Ok(tree)
    }
}

/// Appends the tree at `index` depth first.
fn join(upper: &mut [Upper], index: usize, tree: &mut BinaryTree, costs: &Costs) {
    match std::mem::replace(&mut upper[index], Upper::Taken) {
        Upper::Done(part) => tree.append(part),
        Upper::Inner { bounds, children } => {
            let index = tree.push_inner(bounds);
            join(upper, children[0], tree, costs);
            let right = tree.nodes.len();
            join(upper, children[1], tree, costs);
            tree.finish(index, right, costs);
        }
        Upper::Waiting(_) | Upper::Taken => unreachable!("every task has run, and each node has one parent"),
    }
}

/// Scratch data of a thread.
struct Worker<'a> {
    binary: BinaryBuilder,
    spatial: SpatialBins,
    room: Vec<Prim>,
    triangles: Option<Triangles<'a>>,
    root_area: f32,
}

impl Worker<'_> {
    fn split_owned(&mut self, set: Owned) -> [Owned; 2] {
        let mut prims = set.prims;
        let parts = self.split(&mut prims, 0, set.measures);
        let right = prims.split_off(parts.middle);
        prims.shrink_to_fit();
        // The right part becomes the left child, as in `subtree`.
        let [before, behind] = parts.measures;
        [Owned { prims: right, measures: behind }, Owned { prims, measures: before }]
    }

    /// Appends the tree of `prims[start..]` and removes these primitives. Spatial splits append duplicates at the end
    /// of the vector; therefore the right part is built first.
    fn subtree(&mut self, prims: &mut Vec<Prim>, start: usize, measures: Measures) {
        let count = prims.len() - start;
        if count <= MAX_SWEEP {
            self.binary.sweep(&prims[start..]);
            prims.truncate(start);
            return;
        }
        let index = self.binary.tree.push_inner(measures.bounds);
        let parts = self.split(prims, start, measures);
        self.subtree(prims, start + parts.middle, parts.measures[1]);
        let right = self.binary.tree.nodes.len();
        self.subtree(prims, start, parts.measures[0]);
        self.binary.tree.finish(index, right, &self.binary.costs);
    }

    /// Splits `prims[start..]`, which may grow. Positions in the result are relative to `start`.
    fn split(&mut self, prims: &mut Vec<Prim>, start: usize, measures: Measures) -> Parts {
        let Measures { bounds, centers, budget, depth } = measures;
        let costs = self.binary.costs;
        let count = prims.len() - start;
        let set = &mut prims[start..];
        if depth >= MAX_DEPTH {
            return parts_of(halve(Set { prims: set, bounds, centers }), budget, depth);
        }
        let grid = Grid::new(centers, BINS.min(8 + count / 8), false);
        let object = best_split(self.binary.scratch.fill(set, &grid), &grid, count, &costs);
        let triangles = self.triangles.filter(|_| budget > 0);
        let overlap = object.map_or(f32::INFINITY, |split| {
            let [a, b] = split.bounds;
            let common = Bounds { lo: a.lo.max(b.lo), hi: a.hi.max(b.hi) };
            common.area(costs.pad)
        });
        let least = (MIN_OVERLAP * self.root_area).max(MIN_RELATIVE_OVERLAP * bounds.area(costs.pad));
        if let Some(triangles) = triangles.filter(|_| overlap > least) {
            let plane = self.spatial.best_plane(set, bounds, &triangles, &costs);
            let limit = object.map_or(f32::INFINITY, |split| split.cost);
            let plane = plane
                .filter(|plane| plane.cost < limit && plane.counts[0] + plane.counts[1] <= count + budget);
            if let Some(plane) = plane {
                self.room.clear();
                self.room.extend_from_slice(set);
                prims.truncate(start);
                let mut right = Vec::new();
                cut(&self.room, &plane, &triangles, &costs, prims, &mut right);
                let middle = prims.len() - start;
                prims.append(&mut right);
                let added = prims.len() - start - count;
                if middle > 0 && middle < prims.len() - start && added <= budget {
                    let (left, right) = prims[start..].split_at_mut(middle);
                    return parts_of([Set::of(left), Set::of(right)], budget - added, depth);
                }
                prims.truncate(start);
                prims.extend_from_slice(&self.room);
            }
        }
        let set = &mut prims[start..];
        let set = Set { prims: set, bounds, centers };
        let sets = match object {
            Some(split) => {
                let (middle, centers) = partition(set.prims, &grid, &split);
                super::binary::divide(set, middle, &split, centers)
            }
            None => halve(set),
        };
        parts_of(sets, budget, depth)
    }
}

/// Divides the budget in proportion to the primitives.
fn parts_of([left, right]: [Set<'_>; 2], budget: usize, depth: usize) -> Parts {
    let count = left.len() + right.len();
    let for_left = (budget as u128 * left.len() as u128 / count as u128) as usize;
    let measures = [(&left, for_left), (&right, budget - for_left)].map(|(set, budget)| Measures {
        bounds: set.bounds,
        centers: set.centers,
        budget,
        depth: depth + 1,
    });
    Parts { middle: left.len(), measures }
}
