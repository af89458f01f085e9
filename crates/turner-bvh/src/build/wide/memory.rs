//! Estimates the memory of a build before it starts.

use super::super::{BuildError, BuildOptions, Quality};
use super::Source;

/// How to build within the memory limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Plan {
    pub(super) quality: Quality,
    /// Duplicate references that spatial splits may add.
    pub(super) budget: usize,
}

/// Spatial splits may add one reference per this many primitives.
const PRIMITIVES_PER_DUPLICATE: usize = 2;

/// The plan of the highest quality that fits.
pub(super) fn plan(source: &Source<'_>, options: &BuildOptions<'_>) -> Result<Plan, BuildError> {
    let count = source.len();
    let budget = match source {
        Source::Triangles { .. } => count / PRIMITIVES_PER_DUPLICATE,
        Source::Boxes { .. } => 0,
    };
    let wanted = options.quality;
    let mut plans = vec![Plan { quality: wanted, budget: if wanted == Quality::High { budget } else { 0 } }];
    if wanted == Quality::High {
        plans.push(Plan { quality: Quality::High, budget: 0 });
        plans.push(Plan { quality: Quality::Balanced, budget: 0 });
    }
    let Some(limit) = options.memory_limit else { return Ok(plans[0]) };
    let needed = plans.iter().map(|plan| peak(source, plan));
    match plans.iter().zip(needed.clone()).find(|(_, needed)| *needed <= limit) {
        Some((plan, _)) => Ok(*plan),
        None => Err(BuildError::OutOfMemory { needed: needed.min().unwrap_or(0) }),
    }
}

/// Peak memory of the build in bytes, assuming that leaf blocks are half full.
fn peak(source: &Source<'_>, plan: &Plan) -> usize {
    let references = source.len() + plan.budget;
    // Bytes per reference: as a primitive; of nodes and slots; of blocks.
    let (prim, tree, block) = match source {
        Source::Triangles { .. } => (32, 30, 80),
        Source::Boxes { .. } => (32, 80, 0),
    };
    let binary = match (plan.quality, source) {
        (Quality::High, Source::Triangles { .. }) => 32 + 2 * 48 + 40,
        (Quality::High, Source::Boxes { .. }) => 32 + 4 * 64 + 100,
        _ => 0,
    };
    // The peak is one of: primitives and subtrees; subtrees and the assembled tree; the tree and its blocks.
    let each = (prim + tree).max(2 * tree).max(tree + block) + binary;
    references.saturating_mul(each).saturating_add(1 << 16)
}
