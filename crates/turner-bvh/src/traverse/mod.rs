//! Searching trees of wide nodes.
//!
//! - one ray at a time: `single`
//! - many rays: `batch` chooses among
//!   - rays that have nothing in common, several in turn: `interleaved`
//!   - rays that run together, as packets: `packet`
//!   - trees of few triangles, a ray per lane: `few`

mod batch;
mod few;
mod interleaved;
mod leaves;
mod packet;
mod ray;
mod rows;
mod setup;
mod single;
mod stack;

pub(crate) use batch::{any_batch, any_triangles, closest_batch, closest_triangles};
#[cfg(test)]
pub(crate) use interleaved::{any as any_interleaved, closest as closest_interleaved};
pub(crate) use leaves::{Blocks, Leaves, PacketLeaves};
pub(crate) use ray::{FARTHEST, SearchRay, Space};
use setup::{GROUP, prepare};
pub(crate) use single::{any, closest};

use crate::InstructionSet;
use crate::node::{ChildRef, WideNode};

/// What a search goes through.
#[derive(Clone, Copy)]
pub(crate) struct Tree<'a, L> {
    pub(crate) nodes: &'a [WideNode],
    pub(crate) leaves: &'a L,
    pub(crate) space: Space,
    pub(crate) instruction_set: InstructionSet,
}

impl<L> Tree<'_, L> {
    #[inline(always)]
    pub(crate) fn node(&self, child: ChildRef) -> &WideNode {
        debug_assert!(child.index() < self.nodes.len());
        // SAFETY: builders make references to nodes that are there; a search starts at 0 if there are any.
        unsafe { self.nodes.get_unchecked(child.index()) }
    }
}
