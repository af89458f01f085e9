//! Emissive surfaces.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, params};

params! {
    /// A surface that emits light and reflects none: an area light, a screen.
    pub struct EmissiveMaterial as "emissive" {
        /// Colour of the emission.
        color: ColorSource = ColorSource::Constant(Spectrum::WHITE), in Range::NON_NEGATIVE;
        /// Emitted radiance, a factor of `color`.
        strength: f64 = 1.0, in Range::NON_NEGATIVE;
    }
    example r##"[material.panel]
type = "emissive"
color = [1, 0.85, 0.6]
strength = 5

[[object]]
type = "sphere"
material = "panel"
"##
}

impl EmissiveMaterial {
    /// The equivalent OpenPBR material.
    pub fn principled(&self) -> PrincipledMaterial {
        let nothing = ColorSource::Constant(Spectrum::BLACK);
        PrincipledMaterial {
            base_weight: nothing,
            specular_weight: nothing,
            emission_color: self.color,
            emission_luminance: self.strength,
            ..PrincipledMaterial::default()
        }
    }
}
