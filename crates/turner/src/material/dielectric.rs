//! Glass, water and other clear dielectrics.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::scene::ColorSource;
use crate::scene::schema::{Range, params};

params! {
    /// Glass, water, ice: light is reflected and refracted by Fresnel's and Snell's laws.
    pub struct DielectricMaterial as "dielectric" {
        /// Index of refraction: water 1.33, glass 1.5, diamond 2.42.
        ior: f64 = 1.5, in Range::closed(0.0, 100.0);
        /// 0 is clear, more is frosted.
        roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Colour of light that passes: at the surface, or after `depth`.
        color: ColorSource = ColorSource::Constant(Spectrum::WHITE), in Range::NON_NEGATIVE;
        /// The way inside after which light has `color` (Beer–Lambert); 0 tints at the surface.
        depth: f64 = 0.0, in Range::NON_NEGATIVE;
        /// A pane or bubble without inside: light passes without being bent.
        thin: bool = false;
    }
    example r##"[material.bottle]
type = "dielectric"
color = [0.3, 0.8, 0.4]
depth = 2

[[object]]
type = "sphere"
material = "bottle"
"##
}

impl DielectricMaterial {
    /// The same in the terms of the physical material.
    pub fn principled(&self) -> PrincipledMaterial {
        PrincipledMaterial {
            specular_ior: self.ior,
            specular_roughness: self.roughness,
            transmission_weight: ColorSource::Constant(Spectrum::WHITE),
            transmission_color: self.color,
            transmission_depth: self.depth,
            thin_walled: self.thin,
            ..PrincipledMaterial::default()
        }
    }
}
