//! Bounding volume hierarchies: which of a million things may a ray meet?
//!
//! A tree is built over the [boxes](Aabb) of primitives and knows nothing else about them. A search hands out ranges
//! of primitives and the caller intersects these with whatever it keeps: spheres, triangles, whole other trees.
//!
//! ```
//! use turner_bvh::{Aabb, Bvh2Options, Bvh2, Ray};
//!
//! // Ten flat squares across the z axis.
//! let z: Vec<f32> = (0..10).map(|i| 10.0 - i as f32).collect();
//! let boxes: Vec<Aabb> = z.iter().map(|&z| Aabb::new([-1.0, -1.0, z], [1.0, 1.0, z])).collect();
//! let bvh = Bvh2::build(&boxes, &Bvh2Options::default())?;
//!
//! // In leaf order, each leaf is a slice.
//! let in_order: Vec<f32> = bvh.order().iter().map(|&i| z[i as usize]).collect();
//! let ray = Ray::new([0.0, 0.0, 3.5], [0.0, 0.0, 1.0]);
//! let t = bvh.closest(&ray, |range, t_max| {
//!     in_order[range.start as usize..range.end as usize]
//!         .iter()
//!         .map(|z| (z - ray.origin[2]) / ray.direction[2])
//!         .filter(|&t| t >= ray.t_min)
//!         .fold(t_max, f32::min)
//! });
//! assert_eq!(t, 0.5);
//! # Ok::<(), turner_bvh::BuildError>(())
//! ```
//!
//! # Exactness
//!
//! Box tests never miss: whatever box a ray meets in exact arithmetic is searched, for every finite ray and box, and
//! boxes as near as the nearest hit so far are searched too. So the hit a caller finds is a property of its primitives
//! alone, not of the tree, as long as a primitive's box holds every point at which its own arithmetic may report a
//! hit. Trees do not depend on the number of threads that build them.

mod aabb;
mod build;
mod bvh;
mod bvh2;
mod bvh4;
mod compact;
mod custom;
pub mod generate;
mod hit;
pub mod lanes;
mod levels;
mod motion;
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
mod traverse;
mod triangle;
mod validate;

pub use aabb::Aabb;
pub use build::{BuildError, BuildOptions, BuildStats, Bvh2Options, Bvh2Stats, Quality};
#[doc(hidden)]
pub use build::{build_stats, build_stats_of_boxes};
pub use bvh::{Bvh, Triangles};
pub use bvh2::{Bvh2, MAX_DEPTH};
pub use bvh4::Bvh4;
pub use compact::CompactBvh;
pub use custom::BoxBvh;
pub use hit::Hit;
pub use levels::{Group, GroupError, GroupParts, GroupStats, Instance, MAX_LEVELS, Object, Visit, inverse};
pub use motion::{MovingBvh, MovingTriangles};
pub use ray::Ray;
pub use rays::RayBlock;
pub use refit::RefitError;
pub use simd::Kernel;
pub use spheres::{NearestBlock, Spheres};
