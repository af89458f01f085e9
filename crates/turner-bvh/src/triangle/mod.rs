//! Triangles: the watertight intersection test, and the blocks that leaves store.

mod block;
mod fill;
mod woop;

pub(crate) use block::{BLOCK, Block};
pub(crate) use fill::fill_blocks;
pub(crate) use woop::{Axes, Corners, MIN_EDGE_SUM, Shear, depth, distance, edge_test, precise, weights};
