//! Bounding volume hierarchies (BVHs): which of a million primitives does a ray hit?
//!
//! [`Bvh`] is a BVH over triangles. [`BoxBvh`] is a BVH over boxes of any primitives, which the caller intersects. With
//! the BVHs of meshes in its leaves it is the top level of a two-level BVH, and it follows moving objects by
//! [refitting](BoxBvh::refit). [`BlockBvh`] is for callers that intersect eight primitives at once.
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
//! Box tests are conservative: traversal visits every box around a hit, including boxes that are as near as the nearest
//! hit so far. So the hit is a property of the primitives alone (nearest t, then lowest index). It does not depend on
//! the BVH, the [`InstructionSet`], the number of threads or the other rays of a batch. For triangles,
//! `traverse/ray.rs` bounds the rounding error that box tests must cover. For [`Bvh2`] and [`BoxBvh`] the guarantee
//! holds if a primitive's box contains every point at which the caller's arithmetic may report a hit.
//!
//! # Memory
//!
//! A node has eight children and takes 256 bytes, a block of eight triangles 320. In total that is 46 to 54 bytes per
//! triangle, measured on scans, terrain, architecture and thin sticks. Traversal does not allocate.

mod aabb;
mod blocks;
mod boxes;
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
pub use blocks::BlockBvh;
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
