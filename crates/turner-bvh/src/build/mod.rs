//! Builders: from primitives to a BVH.
//!
//! A bounding volume hierarchy (BVH) stores primitives in a tree of nested boxes. A ray that misses a box misses
//! everything in it, so a good BVH needs few box tests per ray:
//!
//! ```text
//!   +-----------------------------+            root
//!   | +---------+                 |           /    \
//!   | | a       |    +----------+ |          L      R
//!   | |     b   |    | c      d | |         / \    / \
//!   | +--- L ---+    +--- R ----+ |        a   b  c   d
//!   +-----------------------------+
//! ```
//!
//! All builders minimise the surface area heuristic (SAH; Goldsmith and Salmon 1987, MacDonald and Booth 1990).
//! A random line that hits a convex box hits a convex box inside it with probability `area(inner) / area(outer)`,
//! so a BVH costs the sum over its nodes and leaf blocks of their area, divided by the root's area.
//!
//! - [`wide`] builds the BVHs that renderers use, with eight children per node: [`Bvh`](crate::Bvh) and
//!   [`BoxBvh`](crate::BoxBvh).
//! - `binned_sah` builds the scalar binary [`Bvh2`](crate::Bvh2), which the tests compare against.

mod binned_sah;
mod bvh2;
mod options;
pub(crate) mod wide;

pub use bvh2::{BuildError, Bvh2Options, Bvh2Stats};
pub use options::{BuildOptions, BuildStats, Quality};
pub use wide::{build_stats, build_stats_of_boxes};
