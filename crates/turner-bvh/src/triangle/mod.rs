//! Triangles: how a ray meets one, and how leaves hold them.

mod block;
mod woop;

pub(crate) use block::{BLOCK, Block};
pub(crate) use woop::{Axes, Corners, Shear, corners_meet, distance, precise, weights};
