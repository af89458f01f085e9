//! Traversal of BVHs with eight children per node.
//!
//! A node is tested in one go: one SIMD lane per child box. The children that the ray hits are pushed on a stack in
//! front-to-back order, and entries behind the nearest hit so far are skipped:
//!
//! ```text
//!   stack <- root
//!   while stack not empty
//!       pop child; skip it if its entry t > t of the nearest hit
//!       leaf: test eight triangles at a time, keep the nearest hit
//!       node: slab test of eight boxes; push those hit, nearest on top
//! ```
//!
//! Box tests are conservative and triangle tests use the same arithmetic everywhere, so every method below finds the
//! same hits, bit for bit:
//!
//! - `single`: one ray at a time
//! - `batch`: many rays; it chooses among
//!   - `interleaved`: incoherent rays, many in flight
//!   - `packet`: coherent rays that share nodes, one ray per lane
//!   - `few`: BVHs of few triangles, one ray per lane without traversal
//!
//! `ray` derives the padding that makes box tests conservative; `setup` prepares eight rays at a time.

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
pub(crate) use ray::{MAX_COORDINATE, SearchRay, Space};
use setup::{GROUP, prepare};
pub(crate) use single::{any, closest};

use crate::InstructionSet;
use crate::node::{ChildRef, WideNode};

/// What traversal needs of a BVH.
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
        // SAFETY: builders only create references to existing nodes, and traversal starts at 0 only if there are nodes.
        unsafe { self.nodes.get_unchecked(child.index()) }
    }
}
