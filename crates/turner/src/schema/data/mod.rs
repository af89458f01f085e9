//! What files hold that a scene names: plain data, as it was read.

mod font;
mod grid;
mod light_profile;
mod measured;
mod mesh;
mod polygons;

pub use font::{Contour, Font, FontFile, Glyph, OutlinePiece};
pub use grid::{GridData, GridFile, GridScattering, MAX_VALUES};
pub use light_profile::{LightProfile, ProfileFile};
pub use measured::{
    MAX_MEASURED_VALUES, MeasuredBrdf, MeasuredFields, MeasuredFile, MeasuredTable, MeasuredView,
};
pub use mesh::MeshData;
pub use polygons::{boundary, fan};
