//! Surfaces that are none: where one medium ends and another begins.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, MediumId, params};

params! {
    /// No surface at all, but the boundary of a medium: light goes straight through. For the shape of a cloud, of smoke or of a room full of dust;
    /// the shape must be closed. An object with the key `medium` has this material.
    pub struct InterfaceMaterial as "interface" {
        /// What is inside; nothing if not given, not even the medium around.
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
    /// For integrators that know no media: nothing is there.
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
