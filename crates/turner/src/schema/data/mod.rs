//! What files hold that a scene names: plain data, as it was read.

mod grid;
mod light_profile;
mod mesh;
mod polygons;

pub use grid::{GridData, GridFile, MAX_VALUES};
pub use light_profile::{LightProfile, ProfileFile};
pub use mesh::MeshData;
pub use polygons::{boundary, fan};
