//! Glass, water and other clear dielectrics.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, MediumId, Range, params};

params! {
    /// Glass, water, ice: light is reflected and refracted by the Fresnel equations and Snell's law.
    pub struct DielectricMaterial as "dielectric" {
        /// Index of refraction: water 1.33, glass 1.5, diamond 2.42. 0 reflects all light.
        ior: f64 = 1.5, in Range::closed(0.0, 100.0);
        /// Roughness: 0 is clear, above 0 frosted. The GGX α is its square.
        roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Colour of transmitted light: at each crossing of the surface, or after `depth`.
        color: ColorSource = ColorSource::Constant(Spectrum::WHITE), in Range::NON_NEGATIVE;
        /// Distance inside after which light has `color` (Beer-Lambert absorption), in scene units. 0 tints at the
        /// surface.
        depth: f64 = 0.0, in Range::NON_NEGATIVE;
        /// The medium inside: murky water, milk, amber. It absorbs in addition to `depth`. Only for the integrators
        /// "path" and "direct".
        interior: Option<MediumId> = None;
        /// A thin wall without an interior, like a pane or a bubble: transmitted light is not refracted.
        thin: bool = false;
        /// Normal map in tangent space: red along u, green along v. Use an image with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Strength of the normal map: factor of red and green.
        normal_scale: f64 = 1.0;
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black in scene units; negative inverts.
        bump_scale: f64 = 0.1;
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
    /// The equivalent OpenPBR material.
    pub fn principled(&self) -> PrincipledMaterial {
        PrincipledMaterial {
            specular_ior: self.ior,
            specular_roughness: self.roughness,
            transmission_weight: ColorSource::Constant(Spectrum::WHITE),
            transmission_color: self.color,
            transmission_depth: self.depth,
            interior: self.interior,
            thin_walled: self.thin,
            normal_map: self.normal_map,
            normal_scale: self.normal_scale,
            bump_map: self.bump_map,
            bump_scale: self.bump_scale,
            ..PrincipledMaterial::default()
        }
    }
}
