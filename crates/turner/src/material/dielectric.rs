//! Glass, water and other clear dielectrics.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, MediumId, Range, params};

params! {
    /// Glass, water, ice: light is reflected and refracted by Fresnel's and Snell's laws.
    pub struct DielectricMaterial as "dielectric" {
        /// Index of refraction: water 1.33, glass 1.5, diamond 2.42. 0 reflects all light.
        ior: f64 = 1.5, in Range::closed(0.0, 100.0);
        /// 0 is clear, more is frosted.
        roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Colour of light that passes: at the surface, or after `depth`.
        color: ColorSource = ColorSource::Constant(Spectrum::WHITE), in Range::NON_NEGATIVE;
        /// The way inside after which light has `color` (Beer–Lambert); 0 tints at the surface.
        depth: f64 = 0.0, in Range::NON_NEGATIVE;
        /// The medium inside: murky water, milk, amber. It absorbs beside what `depth` says.
        interior: Option<MediumId> = None;
        /// A pane or bubble without inside: light passes without being bent.
        thin: bool = false;
        /// A picture of normals in the tangent frame (red along u, green along v), with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Factor of its red and green parts.
        normal_scale: f64 = 1.0;
        /// A texture of heights that the normal follows as if the surface rose and fell with it: white stands highest.
        bump_map: Option<ColorSource> = None;
        /// How high white stands above black, scene units; below 0, how deep.
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
    /// The same in the terms of the physical material.
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
