//! Building the scalar binary BVH ([`Bvh2`]): options, statistics and errors.

use std::fmt;

use super::binned_sah::{Builder, Item};
use crate::bvh2::{Bvh2, Node};
use crate::{Aabb, MAX_DEPTH};

/// The most primitives in one BVH. A position in the leaf order needs 31 bits; the spare bit marks a leaf.
pub(crate) const MAX_PRIMITIVES: usize = (u32::MAX / 2) as usize;

/// How to build a [`Bvh2`]. The options change speed and memory, never which primitives a ray hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bvh2Options {
    /// Number of threads: 0 for all that the machine offers, 1 for the calling thread only. The BVH is the same bit
    /// for bit for any value. If a thread cannot be started, the calling thread does its work.
    pub threads: usize,
    /// Bins per axis: one more than the candidate split planes. Clamped to 2..=32; 16 by default.
    pub bins: u8,
    /// The most primitives in a leaf. 0 is read as 1; 4 by default.
    pub max_leaf: u8,
}

impl Default for Bvh2Options {
    fn default() -> Bvh2Options {
        Bvh2Options { threads: 0, bins: 16, max_leaf: 4 }
    }
}

/// Size and quality of a [`Bvh2`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bvh2Stats {
    /// Nodes. A node has two children and takes 64 bytes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Nodes on the longest path from the root to a leaf; at most [`MAX_DEPTH`].
    pub max_depth: usize,
    /// Primitives omitted because their box is not [valid](Aabb::is_valid); see [`Bvh2::dropped`].
    pub dropped: usize,
    /// Bytes of the nodes and of the primitive order.
    pub bytes: usize,
    /// SAH cost: the expected work for a random line through the root's box, 1 per pair of boxes and 1 per primitive.
    pub sah_cost: f64,
}

/// Why a BVH could not be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// More primitives than one BVH can index.
    TooManyPrimitives {
        /// Number of primitives given.
        count: usize,
        /// The most that are allowed.
        limit: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    VertexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// The BVH does not fit into [`BuildOptions::memory_limit`](super::BuildOptions::memory_limit), or memory ran out.
    OutOfMemory {
        /// Bytes needed.
        needed: usize,
    },
    /// [`BuildOptions::cancel`](super::BuildOptions::cancel) was set.
    Cancelled,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BuildError::TooManyPrimitives { count, limit } => {
                write!(f, "{count} primitives exceed the limit of {limit} for one BVH")
            }
            BuildError::VertexOutOfRange { triangle, vertex, vertices } => {
                write!(
                    f,
                    "triangle {triangle} refers to vertex {vertex}, but the mesh has {vertices} vertices, counted from 0"
                )
            }
            BuildError::OutOfMemory { needed } => {
                write!(f, "a BVH of {needed} bytes does not fit into memory")
            }
            BuildError::Cancelled => write!(f, "the BVH build was cancelled"),
        }
    }
}

impl std::error::Error for BuildError {}

impl Bvh2 {
    /// Builds a BVH over the boxes of primitives `0..bounds.len()`.
    ///
    /// Boxes that are not [valid](Aabb::is_valid) are omitted and listed by [`dropped`](Self::dropped). The only error
    /// is [`BuildError::TooManyPrimitives`].
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
            0 => turner_host::thread::available(),
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
    // All boxes are one point: a line that hits the root visits every node and every primitive.
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
        assert_eq!(error.to_string(), "2147483648 primitives exceed the limit of 2147483647 for one BVH");
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
