//! What a builder may be asked for, and what it answers.

use std::fmt;
use std::sync::atomic::AtomicBool;

use crate::InstructionSet;

/// How much work goes into a tree before the first ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Quality {
    /// For geometry that changes with every picture.
    Fast,
    /// Binned SAH on all axes.
    #[default]
    Balanced,
    /// Spatial splits and reinsertion; over triangles only if that pays, otherwise the balanced tree.
    High,
}

/// How to build a tree. None of it changes which primitives a ray meets; only the time and memory it takes.
#[derive(Clone, Copy, Default)]
pub struct BuildOptions<'a> {
    /// How much work goes into the tree.
    pub quality: Quality,
    /// Threads to use: 0 for as many as the machine offers, 1 for the calling thread only. The tree is the same,
    /// bit for bit, for every number.
    pub threads: usize,
    /// Bytes the build may take at its peak, the finished tree included; `None` for no limit. What high quality
    /// would spend beyond it is saved: first references by spatial splits, then all that `Balanced` does without.
    /// A tree that does not fit at all is an error.
    pub memory_limit: Option<usize>,
    /// What searches of the tree will use; by default the best that this machine has.
    pub instruction_set: InstructionSet,
    /// Called now and then, from any thread, with the share of the work that is done: 0 to 1.
    pub progress: Option<&'a (dyn Fn(f32) + Sync)>,
    /// Set it to end the build early, with [`BuildError::Cancelled`](super::BuildError::Cancelled).
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

/// The size and the quality of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildStats {
    /// Primitives in the tree.
    pub primitives: usize,
    /// Primitives left out because a number of theirs was NaN or infinite.
    pub non_finite: usize,
    /// Triangles left out because two of their corners coincide: no ray meets them.
    pub degenerate: usize,
    /// References to primitives in leaves: more than `primitives` where spatial splits cut some.
    pub references: usize,
    /// Nodes of eight children; each takes 256 bytes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Blocks of eight triangles (of one primitive in a tree over boxes).
    pub blocks: usize,
    /// Nodes on the longest way from the root to a leaf.
    pub max_depth: usize,
    /// Bytes of the finished tree: nodes, blocks, and whatever else a ray may touch.
    pub bytes: usize,
    /// Expected work of a random line that meets the root's box: 1 for each node and each block.
    pub sah_cost: f64,
}
