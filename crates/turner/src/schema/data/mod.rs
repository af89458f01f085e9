//! What files hold that a scene names: plain data, as it was read.

mod font;
mod grid;
mod light_profile;
mod mesh;
mod polygons;

pub use font::{Contour, Font, FontFile, Glyph, OutlinePiece};
pub use grid::{GridData, GridFile, GridScattering, MAX_VALUES};
pub use light_profile::{LightProfile, ProfileFile};
pub use mesh::MeshData;
pub use polygons::{boundary, fan};
