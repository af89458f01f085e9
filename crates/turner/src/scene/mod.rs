//! Scenes: description, preparation, and the errors on the way.

pub mod background;
mod batch;
mod batch_meshes;
pub mod desc;
mod doubts;
mod emitter_batch;
pub mod emitters;
pub mod error;
mod faces;
mod merged;
pub mod model;
mod motion;
mod names;
mod outline;
mod param;
mod planes;
mod prepare;
pub mod read;
mod rectangles;
#[allow(clippy::module_inception)]
mod scene;
pub mod schema;
mod search_cost;
mod shape_emitters;
mod sieve;
mod spectrum_block;
pub mod stage;
mod tangent;
pub mod transform;
pub mod value;

pub use batch::RayBatch;
pub use desc::*;
pub use emitter_batch::{AroundBatch, LightBatch};
pub use error::{ErrorCode, SceneError};
pub use model::ModelDesc;
pub use names::ObjectName;
pub use outline::Outline;
pub use param::ColorSource;
pub use prepare::PrepareOptions;
pub use read::{SceneAssets, read_scene};
pub use scene::{Hit, Scene, SceneStats, SurfaceInteraction};
pub use search_cost::SearchCost;
pub use spectrum_block::SpectrumBlock;
pub use stage::StageDesc;
pub use turner_bvh::Quality;
