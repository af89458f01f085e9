//! The interface material: the boundary of a medium, which scatters nothing.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, MediumId, params};

params! {
    /// The boundary of a medium, without a surface of its own: light passes straight through. For the shape of a cloud,
    /// of smoke or of a dusty room; the shape must be closed. An object with the key `medium` has this material.
    /// Integrators other than "path" and "direct" do not see the object.
    pub struct InterfaceMaterial as "interface" {
        /// The medium inside. If not given, the inside is empty, even within another medium.
        interior: Option<MediumId> = None;
    }
    example r##"[medium.smoke]
extinction = 3
albedo = 0.7

[material.cloud]
type = "interface"
interior = "smoke"

[[object]]
type = "sphere"
material = "cloud"
"##
}

impl InterfaceMaterial {
    /// Transparent, for integrators without media.
    pub fn principled(&self) -> PrincipledMaterial {
        let none = ColorSource::Constant(Spectrum::BLACK);
        PrincipledMaterial {
            opacity: none,
            specular_weight: none,
            specular_ior: 1.0,
            interior: self.interior,
            ..PrincipledMaterial::default()
        }
    }
}
