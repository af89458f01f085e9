//! Builders of trees with eight children to a node.

mod simple;
pub(crate) use simple::build;

use super::BuildError;
use super::options::{BuildOptions, BuildStats};
use crate::Aabb;
use crate::node::WideNode;

/// What a tree is built over.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Source<'a> {
    /// Triangles; every position is multiplied by `scale`, a power of two, before use.
    Triangles { positions: &'a [[f32; 3]], triangles: &'a [[u32; 3]], scale: f32 },
    /// Boxes of anything, scaled likewise.
    Boxes { boxes: &'a [Aabb], scale: f32 },
}

impl Source<'_> {
    /// Primitives in a block: leaves hold whole blocks.
    pub(crate) fn block_width(&self) -> usize {
        match self {
            Source::Triangles { .. } => 4,
            Source::Boxes { .. } => 1,
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
