//! Triangles: how a ray meets one, and how leaves hold them.

mod block;
mod woop;

pub(crate) use block::Triangle4;
pub(crate) use woop::{Corners, Shear, Weights, corners_meet, precise};
