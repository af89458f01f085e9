//! Builders for BVHs with eight children per node.
//!
//! The build has four stages:
//!
//! ```text
//!   load            primitives -> boxes and centres                           load, prims
//!   binary tree     top-down SAH splits: bins for large sets,                 top, binary, bins,
//!                   full sweeps for small ones; `High` adds spatial splits    sweep, high, spatial,
//!                   and reinsertion                                           reinsertion
//!   collapse        the optimal cut of each binary tree into wide nodes       collapse
//!   assemble        subtrees of all threads into one array, depth first       assembly
//! ```
//!
//! The SAH cost (see [`super`]) counts 1 per node and 1 per block of a leaf, weighted by surface area.
//! Binary splits come first because good criteria for them are known. Collapsing then removes binary levels:
//!
//! ```text
//!              o                                        o
//!          /       \          three binary levels      / / | | | | \ \
//!        o           o        become one node of       a b c d e f g h
//!      /   \       /   \      eight children
//!     o     o     o     o
//!    / \   / \   / \   / \
//!    a b   c d   e f   g h
//! ```
//!
//! The BVH depends on the primitives and the quality only, never on threads or machine: every split follows from
//! minima, maxima and counts of a set, or from a total order of its primitives.

mod assembly;
mod binary;
mod bins;
mod clip;
mod collapse;
mod high;
mod lanes;
mod load;
mod memory;
mod octants;
mod parallel;
mod prims;
mod reinsertion;
mod spatial;
mod sweep;
#[cfg(test)]
mod tests;
mod top;
#[cfg(test)]
mod validate;

pub(crate) use octants::set_order;

use super::BuildError;
use super::options::{BuildOptions, BuildStats, Quality};
use crate::Aabb;
use crate::node::{MAX_BLOCKS, WideNode};
use crate::triangle::{BLOCK, Block};

/// The primitives that a BVH is built over.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Source<'a> {
    /// Triangles. Every position is first multiplied by `scale`, a power of two.
    Triangles { positions: &'a [[f32; 3]], triangles: &'a [[u32; 3]], scale: f32 },
    /// Boxes of any primitives, scaled likewise. A leaf tests `width` of them at once.
    Boxes { boxes: &'a [Aabb], scale: f32, width: usize },
}

impl Source<'_> {
    /// Primitives in a block. Leaves consist of complete blocks.
    pub(crate) fn block_width(&self) -> usize {
        match self {
            Source::Triangles { .. } => BLOCK,
            Source::Boxes { width, .. } => *width,
        }
    }

    /// Number of primitives, including those that the builder omits.
    pub(crate) fn len(&self) -> usize {
        match self {
            Source::Triangles { triangles, .. } => triangles.len(),
            Source::Boxes { boxes, .. } => boxes.len(),
        }
    }
}

/// Nodes, and the primitives that their leaves hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct WideTree {
    /// Depth first, root at 0; empty if there are no primitives.
    pub(crate) nodes: Vec<WideNode>,
    /// Block `b` holds primitives `slots[b * width..(b + 1) * width]`. [`NO_PRIMITIVE`] pads a leaf's last block.
    pub(crate) slots: Vec<u32>,
    pub(crate) stats: BuildStats,
}

/// An unused slot of a block.
pub(crate) const NO_PRIMITIVE: u32 = u32::MAX;

/// The BVH of quality `High` is used if its SAH cost is at most this fraction of the balanced BVH's. Otherwise the
/// balanced BVH is used, which is smaller and has no duplicate references. Architecture: cost ratio 0.94, rays take
/// 1.07 times as long. Thin sticks: cost ratio 0.80, rays take 0.83 times as long.
const MAX_COST_RATIO: f64 = 0.9;

/// Like [`build`], but returns the balanced BVH where high quality gains too little.
pub(crate) fn build_best(source: &Source<'_>, options: &BuildOptions<'_>) -> Result<WideTree, BuildError> {
    let tree = build(source, options)?;
    if options.quality != Quality::High {
        return Ok(tree);
    }
    let options = BuildOptions { quality: Quality::Balanced, progress: None, ..*options };
    let balanced = match build(source, &options) {
        // There is no memory for a second BVH.
        Err(BuildError::OutOfMemory { .. }) => return Ok(tree),
        balanced => balanced?,
    };
    let pays = tree.stats.sah_cost <= MAX_COST_RATIO * balanced.stats.sah_cost;
    Ok(if pays { tree } else { balanced })
}

/// Builds a BVH over all primitives of the source that a ray can hit.
pub(crate) fn build(source: &Source<'_>, options: &BuildOptions<'_>) -> Result<WideTree, BuildError> {
    if source.len() > MAX_BLOCKS {
        return Err(BuildError::TooManyPrimitives { count: source.len(), limit: MAX_BLOCKS });
    }
    let threads = match options.threads {
        0 => turner_host::thread::available(),
        n => n,
    };
    let plan = memory::plan(source, options)?;
    let progress = parallel::Progress::new(options.progress, options.cancel, top::work_of(source.len()));
    progress.check()?;
    let mut loaded = load::load(source, threads)?;
    progress.advance(source.len())?;
    let primitives = loaded.prims.len();
    let (non_finite, degenerate) = (loaded.non_finite, loaded.degenerate);
    let costs = prims::Costs::new(source.block_width(), loaded.bounds);
    let (top, subtrees) = if primitives == 0 {
        (Vec::new(), Vec::new())
    } else if plan.quality == Quality::High {
        let triangles = match *source {
            Source::Triangles { positions, triangles, scale } => {
                Some(spatial::Triangles { positions, triangles, scale })
            }
            Source::Boxes { .. } => None,
        };
        let high = high::High { costs, triangles, threads, progress: &progress };
        let prims = std::mem::take(&mut loaded.prims);
        let tree = high.build(prims, loaded.bounds, loaded.centers, plan.budget)?;
        let tree = reinsertion::improve(tree, &costs, threads, &progress)?;
        let collapse = collapse::Collapse { tree: &tree, costs: &costs, out: collapse::Subtree::default() };
        (Vec::new(), vec![collapse.run(0, true)])
    } else {
        let set = prims::Set { bounds: loaded.bounds, centers: loaded.centers, prims: &mut loaded.prims };
        let fast = plan.quality == Quality::Fast;
        top::Top { costs, max_bins: 16, one_axis: fast, threads, progress: &progress }.build(set)?
    };
    drop(loaded);
    let mut tree = assembly::assemble(source, &top, subtrees, threads)?;
    tree.stats.primitives = primitives;
    tree.stats.non_finite = non_finite;
    tree.stats.degenerate = degenerate;
    let block_bytes = match source {
        Source::Triangles { .. } => size_of::<Block>(),
        _ => source.block_width() * size_of::<u32>(),
    };
    tree.stats.bytes = tree.nodes.len() * size_of::<WideNode>() + tree.stats.blocks * block_bytes;
    let needed = tree.stats.bytes + size_of_val(&*tree.slots);
    if options.memory_limit.is_some_and(|limit| needed > limit) {
        return Err(BuildError::OutOfMemory { needed });
    }
    progress.tell(1.0);
    Ok(tree)
}

/// Statistics of a BVH over boxes, without the BVH: for measuring builders.
#[doc(hidden)]
pub fn build_stats_of_boxes(boxes: &[Aabb], options: &BuildOptions<'_>) -> Result<BuildStats, BuildError> {
    Ok(build(&Source::Boxes { boxes, scale: 1.0, width: 1 }, options)?.stats)
}

/// Statistics of a BVH over triangles, without the BVH: for measuring builders.
#[doc(hidden)]
pub fn build_stats(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    options: &BuildOptions<'_>,
) -> Result<BuildStats, BuildError> {
    Ok(build(&Source::Triangles { positions, triangles, scale: 1.0 }, options)?.stats)
}
