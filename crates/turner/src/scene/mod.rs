//! The prepared scene: geometry, materials and lights, complete and immutable. Camera and film are in `view`.

pub(crate) mod alpha_test;
pub(crate) mod batch;
pub(crate) mod batch_meshes;
mod bvh_boxes;
#[cfg(test)]
mod bvh_boxes_tests;
pub(crate) mod camera_visibility;
pub mod caustic_targets;
mod coincident;
pub(crate) mod emitter_batch;
pub(crate) mod emitter_list;
#[cfg(test)]
mod emitter_tests;
pub mod emitters;
pub(crate) mod footprint;
pub(crate) mod light_groups;
pub mod light_sample;
pub(crate) mod motion;
#[cfg(test)]
mod motion_tests;
#[cfg(test)]
mod moving_view_tests;
pub(crate) mod names;
pub(crate) mod outline;
pub(crate) mod placed_emitters;
pub(crate) mod planes;
pub(crate) mod ray_batch;
#[cfg(test)]
mod ray_batch_tests;
pub(crate) mod rectangles;
#[allow(clippy::module_inception)]
pub(crate) mod scene;
pub(crate) mod search_cost;
pub(crate) mod shape_emitters;
pub(crate) mod similarity;
pub(crate) mod spectrum_block;
pub(crate) mod sphere_culler;
pub(crate) mod surface_block;
pub(crate) mod tangent;
pub(crate) mod traced_emitter;
pub(crate) mod volumes;
pub(crate) mod world_mesh;

pub use crate::interaction::{Hit, SurfaceInteraction};
pub use camera_visibility::PrimitiveSet;
pub use emitter_batch::{EscapedRays, LightBatch};
pub use emitter_list::ListedEmitter;
pub use light_groups::LightGroups;
pub use names::{Caster, ObjectName};
pub use outline::Outline;
pub use placed_emitters::LightChoice;
pub use ray_batch::{RayBatch, RayOrigin};
pub use scene::{Scene, SceneStats};
pub use search_cost::SearchCost;
pub use spectrum_block::SpectrumBlock;
pub(crate) use surface_block::{FlatBlock, SurfaceBlock, SurfaceX8};
pub(crate) use volumes::Volumes;
