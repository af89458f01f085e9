//! From primitives to trees.

mod binned_sah;
mod bvh2;
mod options;
pub(crate) mod wide;

pub use bvh2::{BuildError, Bvh2Options, Bvh2Stats};
pub use options::{BuildOptions, BuildStats, Quality};
pub use wide::{build_stats, build_stats_of_boxes};
