//! Bounding volume hierarchies: which of a million things does a ray meet?
//!
//! [`Bvh`] is the tree over triangles. [`BoxBvh`] takes boxes of anything and knows nothing else about them: with trees of
//! triangles in its leaves it is the upper of two levels, and it follows what moves by [refitting](BoxBvh::refit).
//!
//! ```
//! use turner_bvh::{BuildOptions, Bvh, Ray, Triangles};
//!
//! // A pyramid.
//! let positions = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
//! let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 2, 1], [0, 3, 2]];
//! let bvh = Bvh::build(&Triangles { positions: &positions, triangles: &triangles }, &BuildOptions::default())?;
//!
//! let down = Ray::new([0.5, 3.0, 0.1], [0.0, -1.0, 0.0]);
//! let hit = bvh.intersect(&down).expect("the pyramid is below");
//! assert_eq!((hit.t, hit.primitive), (2.5, 1));
//! assert!(!bvh.occluded(&Ray { t_max: 2.0, ..down }));
//! # Ok::<(), turner_bvh::BuildError>(())
//! ```
//!
//! # Exactness
//!
//! Box tests never miss: whatever a ray hits, the boxes around it are searched, and boxes as near as the nearest hit so
//! far are searched too. So the hit is a property of the primitives alone — the nearest t, then the lowest number — and not
//! of the tree, of the [`InstructionSet`], of the number of threads or of the rays beside it. For triangles the rounding that this takes
//! care of is bounded in `traverse/ray.rs`; for [`Bvh2`] and [`BoxBvh`] it holds as long as a
//! primitive's box holds every point at which its own arithmetic may report a hit.
//!
//! # Memory
//!
//! A node has eight children and takes 256 bytes, a block of eight triangles 320: 46 to 54 bytes per triangle, measured on
//! scans, terrain, architecture and thin sticks. A search needs no heap.

mod aabb;
mod build;
mod bvh;
mod bvh2;
mod changed;
mod custom;
pub mod generate;
mod hit;
pub mod lanes;
mod node;
#[cfg(test)]
mod oracle;
mod ray;
mod rays;
mod refit;
mod search;
mod simd;
mod slabs;
mod spheres;
mod steps;
mod traverse;
mod triangle;
mod validate;

pub use aabb::Aabb;
pub use build::{BuildError, BuildOptions, BuildStats, Bvh2Options, Bvh2Stats, Quality};
#[doc(hidden)]
pub use build::{build_stats, build_stats_of_boxes};
pub use bvh::{Bvh, Triangles};
pub use bvh2::{Bvh2, MAX_DEPTH};
pub use changed::{ChangedMesh, Kept};
pub use custom::BoxBvh;
pub use hit::Hit;
pub use ray::Ray;
pub use rays::RayBlock;
pub use refit::RefitError;
pub use simd::InstructionSet;
pub use spheres::{NearestBlock, Spheres};
pub use steps::Steps;
