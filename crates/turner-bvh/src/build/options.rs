//! Options and statistics of the wide builders.

use std::fmt;
use std::sync::atomic::AtomicBool;

use crate::InstructionSet;

/// How much time the builder spends to make rays faster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Quality {
    /// Binned SAH on one axis: for geometry that changes with every image.
    Fast,
    /// Binned SAH on all three axes.
    #[default]
    Balanced,
    /// Adds spatial splits and reinsertion. Over triangles, if that does not pay, the result is the balanced BVH.
    High,
}

/// How to build a BVH. The options change speed and memory, never which primitives a ray hits.
#[derive(Clone, Copy, Default)]
pub struct BuildOptions<'a> {
    /// Time spent on the build against speed of the rays.
    pub quality: Quality,
    /// Number of threads: 0 for all that the machine offers, 1 for the calling thread only. The BVH is the same bit
    /// for bit for any value.
    pub threads: usize,
    /// Peak memory of the build in bytes, including the finished BVH; `None` for no limit. To stay within the limit,
    /// `High` first reduces spatial splits and then builds as `Balanced` does. If even that does not fit, the build
    /// returns an error.
    pub memory_limit: Option<usize>,
    /// Instruction set for traversal; by default the best that this machine supports.
    pub instruction_set: InstructionSet,
    /// Called from any thread with the fraction of the work that is done, from 0 to 1.
    pub progress: Option<&'a (dyn Fn(f32) + Sync)>,
    /// Set it to true to stop the build with [`BuildError::Cancelled`](super::BuildError::Cancelled).
    pub cancel: Option<&'a AtomicBool>,
}

impl fmt::Debug for BuildOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BuildOptions")
            .field("quality", &self.quality)
            .field("threads", &self.threads)
            .field("memory_limit", &self.memory_limit)
            .field("instruction_set", &self.instruction_set)
            .finish_non_exhaustive()
    }
}

/// Size and quality of a BVH.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildStats {
    /// Primitives in the BVH.
    pub primitives: usize,
    /// Primitives omitted because a coordinate is NaN or infinite.
    pub non_finite: usize,
    /// Triangles omitted because two of their vertices coincide: no ray hits them.
    pub degenerate: usize,
    /// References to primitives in leaves. More than `primitives` if spatial splits duplicated some.
    pub references: usize,
    /// Nodes. A node has eight children and takes 256 bytes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Blocks: of eight triangles, or of one primitive in a BVH over boxes.
    pub blocks: usize,
    /// Nodes on the longest path from the root to a leaf.
    pub max_depth: usize,
    /// Bytes of the finished BVH: nodes, blocks and everything else that traversal reads.
    pub bytes: usize,
    /// SAH cost: the expected work for a random line through the root's box, 1 per node and 1 per block.
    pub sah_cost: f64,
}
