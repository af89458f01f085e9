//! Builders of trees with eight children to a node.
//!
//! A tree depends on its primitives and the quality asked for, not on threads or on the machine: every split is decided
//! by minima, maxima and counts of a set, or by an order in which no two primitives are equal.

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

/// What a tree is built over.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Source<'a> {
    /// Triangles; every position is multiplied by `scale`, a power of two, before use.
    Triangles { positions: &'a [[f32; 3]], triangles: &'a [[u32; 3]], scale: f32 },
    /// Boxes of anything, scaled likewise, of which leaves test `width` at once.
    Boxes { boxes: &'a [Aabb], scale: f32, width: usize },
}

impl Source<'_> {
    /// Primitives in a block: leaves hold whole blocks.
    pub(crate) fn block_width(&self) -> usize {
        match self {
            Source::Triangles { .. } => BLOCK,
            Source::Boxes { width, .. } => *width,
        }
    }

    /// Primitives, usable or not.
    pub(crate) fn len(&self) -> usize {
        match self {
            Source::Triangles { triangles, .. } => triangles.len(),
            Source::Boxes { boxes, .. } => boxes.len(),
        }
    }
}

/// Nodes, and which primitives their leaves hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct WideTree {
    /// Depth first, the root at 0; empty if there are no primitives.
    pub(crate) nodes: Vec<WideNode>,
    /// Block `b` holds primitives `slots[b * width..(b + 1) * width]`; [`NO_PRIMITIVE`] fills a leaf's last block.
    pub(crate) slots: Vec<u32>,
    pub(crate) stats: BuildStats,
}

/// An empty place in a block.
pub(crate) const NO_PRIMITIVE: u32 = u32::MAX;

/// Where the tree of high quality is not cheaper than this share of the balanced one, by the surface area heuristic, the
/// balanced one is taken: it is smaller, and rays find no triangle twice in it. Of architecture the tree of high quality
/// costs 0.94, and rays take 1.07 times as long; of thin sticks 0.80, and they take 0.83.
const WORTH_IT: f64 = 0.9;

/// Like [`build`], but where high quality does not pay the tree is the balanced one.
pub(crate) fn build_best(source: &Source<'_>, options: &BuildOptions<'_>) -> Result<WideTree, BuildError> {
    let tree = build(source, options)?;
    if options.quality != Quality::High {
        return Ok(tree);
    }
    let options = BuildOptions { quality: Quality::Balanced, progress: None, ..*options };
    let balanced = match build(source, &options) {
        // Not both fit.
        Err(BuildError::OutOfMemory { .. }) => return Ok(tree),
        balanced => balanced?,
    };
    let pays = tree.stats.sah_cost <= WORTH_IT * balanced.stats.sah_cost;
    Ok(if pays { tree } else { balanced })
}

/// Builds the tree over all primitives of the source that a ray may meet.
pub(crate) fn build(source: &Source<'_>, options: &BuildOptions<'_>) -> Result<WideTree, BuildError> {
    if source.len() > MAX_BLOCKS {
        return Err(BuildError::TooManyPrimitives { count: source.len(), limit: MAX_BLOCKS });
    }
    let threads = match options.threads {
        0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
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

/// The same for a tree over boxes.
#[doc(hidden)]
pub fn build_stats_of_boxes(boxes: &[Aabb], options: &BuildOptions<'_>) -> Result<BuildStats, BuildError> {
    Ok(build(&Source::Boxes { boxes, scale: 1.0, width: 1 }, options)?.stats)
}

/// What a tree over triangles is like, without the tree: for measuring builders.
#[doc(hidden)]
pub fn build_stats(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    options: &BuildOptions<'_>,
) -> Result<BuildStats, BuildError> {
    Ok(build(&Source::Triangles { positions, triangles, scale: 1.0 }, options)?.stats)
}
