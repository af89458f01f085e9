//! From boxes to trees.

use std::fmt;

use super::binned_sah::{Builder, Item};
use crate::bvh2::{Bvh2, Node};
use crate::{Aabb, MAX_DEPTH};

/// The most primitives one tree holds: positions need a spare bit.
pub(crate) const MAX_PRIMITIVES: usize = (u32::MAX / 2) as usize;

/// How to build a tree. None of it changes which primitives a ray meets; only the time it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bvh2Options {
    /// Threads to use: 0 for as many as the machine offers, 1 for the calling thread only. The tree is the same,
    /// bit for bit, for every number. Where threads cannot be started the calling thread does their work.
    pub threads: usize,
    /// Candidate planes per axis, plus one. Taken as 2..=32 when outside; 16 by default.
    pub bins: u8,
    /// The most primitives in a leaf; 0 is taken as 1; 4 by default.
    pub max_leaf: u8,
}

impl Default for Bvh2Options {
    fn default() -> Bvh2Options {
        Bvh2Options { threads: 0, bins: 16, max_leaf: 4 }
    }
}

/// The size and the quality of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bvh2Stats {
    /// Nodes; each has two children and takes 64 bytes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Nodes on the longest way from the root to a leaf; at most [`MAX_DEPTH`].
    pub max_depth: usize,
    /// Primitives left out because their box was not [valid](Aabb::is_valid): see [`Bvh2::dropped`].
    pub dropped: usize,
    /// Memory of nodes and primitive order.
    pub bytes: usize,
    /// Expected work of a random line that meets the root's box: 1 for each pair of boxes, 1 for each primitive.
    pub sah_cost: f64,
}

/// Why a tree was not built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// More boxes than the 2^31 - 1 that positions can number.
    TooManyPrimitives {
        /// How many there were.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A triangle names a vertex that is not there.
    VertexOutOfRange {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The tree does not fit into [`BuildOptions::memory_limit`](super::BuildOptions::memory_limit), or memory ran out.
    OutOfMemory {
        /// Bytes it would take.
        needed: usize,
    },
    /// [`BuildOptions::cancel`](super::BuildOptions::cancel) was set.
    Cancelled,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BuildError::TooManyPrimitives { count, limit } => {
                write!(f, "{count} primitives in one tree, of at most {limit}")
            }
            BuildError::VertexOutOfRange { triangle, vertex, vertices } => {
                write!(
                    f,
                    "triangle {triangle} names vertex {vertex}, but there are {vertices}, counted from 0"
                )
            }
            BuildError::OutOfMemory { needed } => {
                write!(f, "a tree of {needed} bytes exceeds the memory there is")
            }
            BuildError::Cancelled => write!(f, "the build was cancelled"),
        }
    }
}

impl std::error::Error for BuildError {}

impl Bvh2 {
    /// Builds the tree over the boxes of primitives `0..bounds.len()`.
    ///
    /// Boxes that are not [valid](Aabb::is_valid) are left out and listed by [`dropped`](Self::dropped). The one
    /// possible error is [`BuildError::TooManyPrimitives`].
    pub fn build(bounds: &[Aabb], options: &Bvh2Options) -> Result<Bvh2, BuildError> {
        check_count(bounds.len())?;
        let mut items = Vec::with_capacity(bounds.len());
        let mut dropped = Vec::new();
        for (index, &bounds) in (0..).zip(bounds) {
            if bounds.is_valid() {
                items.push(Item { bounds, index });
            } else {
                dropped.push(index);
            }
        }
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            n => n,
        };
        let nodes = Builder::new(options).build(&mut items, threads);
        let order: Vec<u32> = items.iter().map(|item| item.index).collect();
        let stats = stats(&nodes, order.len(), dropped.len());
        Ok(Bvh2::from_parts(nodes, order, dropped, stats))
    }
}

fn check_count(count: usize) -> Result<(), BuildError> {
    if count > MAX_PRIMITIVES {
        Err(BuildError::TooManyPrimitives { count, limit: MAX_PRIMITIVES })
    } else {
        Ok(())
    }
}

fn stats(nodes: &[Node], primitives: usize, dropped: usize) -> Bvh2Stats {
    let mut stats = Bvh2Stats {
        nodes: nodes.len(),
        dropped,
        bytes: size_of_val(nodes) + primitives * size_of::<u32>(),
        ..Bvh2Stats::default()
    };
    let Some(root) = nodes.first() else { return stats };
    let root_area = root.bounds(0).union(root.bounds(1)).half_area();
    let mut depths = vec![1; nodes.len()];
    let mut cost = root_area;
    for (i, node) in nodes.iter().enumerate() {
        stats.max_depth = stats.max_depth.max(depths[i]);
        for side in 0..2 {
            let area = node.bounds(side).half_area();
            if let Some(leaf) = node.leaf(side) {
                stats.leaves += usize::from(!leaf.is_empty());
                cost += area * leaf.len() as f64;
            } else {
                depths[node.child(side)] = depths[i] + 1;
                cost += area;
            }
        }
    }
    debug_assert!(stats.max_depth <= MAX_DEPTH);
    // Everything in one point: whoever meets it meets everything.
    stats.sah_cost = if root_area > 0.0 { cost / root_area } else { (nodes.len() + primitives) as f64 };
    stats
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_need_a_spare_bit() {
        assert_eq!(check_count(MAX_PRIMITIVES), Ok(()));
        let error = check_count(MAX_PRIMITIVES + 1).unwrap_err();
        assert_eq!(error, BuildError::TooManyPrimitives { count: 1 << 31, limit: MAX_PRIMITIVES });
        assert_eq!(error.to_string(), "2147483648 primitives in one tree, of at most 2147483647");
    }

    #[test]
    fn the_cost_of_two_leaves_is_counted_by_area() {
        // Two unit cubes at the ends of a 1 x 1 x 4 box: half areas 3, 3 and 9.
        let a = Aabb::new([0.0; 3], [1.0; 3]);
        let b = Aabb::new([0.0, 0.0, 3.0], [1.0, 1.0, 4.0]);
        let options = Bvh2Options { max_leaf: 1, ..Bvh2Options::default() };
        let stats = *Bvh2::build(&[a, b], &options).unwrap().stats();
        assert_eq!((stats.nodes, stats.leaves, stats.max_depth, stats.bytes), (1, 2, 1, 64 + 8));
        assert!((stats.sah_cost - (1.0 + 3.0 / 9.0 + 3.0 / 9.0)).abs() < 1e-12);
    }
}
