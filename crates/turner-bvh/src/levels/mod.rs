//! Trees over placed trees.
//!
//! A [`Group`] holds instances (an object and an affine transform, which may move) and primitives of its own that the caller
//! meets. An object is a mesh, a moving mesh, or another group, and so on for [`MAX_LEVELS`] groups.
//!
//! **What is exact.** A ray goes into an instance by the inverse of its transform, computed in double precision and rounded
//! once; then `origin' = ((c0 x + c1 y) + c2 z) + c3` with the columns of that matrix, the direction likewise without c3,
//! each operation rounded to single precision. t is the same inside and outside. The hit found is the nearest of all
//! instances' hits of that ray, equally near ones decided by instance and then primitive: what a search without any tree
//! finds. `bounds` says why boxes around instances lose none of it.
//!
//! t is kept in units of powers of two of the ray's own; where such a unit takes it out of the normal numbers (t below
//! 1e-30 of the scene, say) it is rounded.

mod bounds;
mod group;
mod leaves;
mod matrix;
mod plan;
mod search;
#[cfg(test)]
pub(crate) mod tests;

pub use group::{Group, GroupError, GroupParts, GroupStats, Instance, Object};
pub use matrix::inverse;
pub use search::Visit;

/// The most groups one within the other, the outermost counted.
pub const MAX_LEVELS: usize = 8;
