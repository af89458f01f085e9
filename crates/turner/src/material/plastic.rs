//! Plastic, paint and varnish.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::scene::ColorSource;
use crate::scene::schema::{Range, params};

params! {
    /// A diffuse body under a clear surface: plastic, paint, glazed pottery; with a coat, varnished wood or a car.
    pub struct PlasticMaterial as "plastic" {
        /// Colour of the body.
        color: ColorSource = ColorSource::Constant(Spectrum::grey(0.8)), in Range::NON_NEGATIVE;
        /// Roughness of the surface: 0 is a mirror.
        roughness: ColorSource = ColorSource::Constant(Spectrum::grey(0.3)), in Range::UNIT;
        /// Index of refraction of the surface.
        ior: f64 = 1.5, in Range::closed(0.0, 100.0);
        /// Share covered by a second clear layer.
        coat: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Roughness of that layer.
        coat_roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
    }
    example r##"[material.toy]
type = "plastic"
color = "crimson"
roughness = 0.25

[[object]]
type = "sphere"
material = "toy"
"##
}

impl PlasticMaterial {
    /// The same in the terms of the physical material.
    pub fn principled(&self) -> PrincipledMaterial {
        PrincipledMaterial {
            base_color: self.color,
            specular_roughness: self.roughness,
            specular_ior: self.ior,
            coat_weight: self.coat,
            coat_roughness: self.coat_roughness,
            ..PrincipledMaterial::default()
        }
    }
}
