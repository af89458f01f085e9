//! Integrators: how much light comes along a camera ray. One file each; [`IntegratorDesc`] is the table of their
//! names in a scene.

mod classic;
mod normals;

pub use classic::{AtDepth, ClassicDesc, Combine, Highlight, Miss};
pub use normals::{NormalKind, NormalsDesc};

use crate::scene::schema::family;

family! {
    /// Integrators: `[integrator]`. The `type` is "classic" unless given.
    pub enum IntegratorDesc as "integrator", "integrators" {
        Classic(ClassicDesc),
        Normals(NormalsDesc),
    }
}
