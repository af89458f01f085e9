//! Plastic, paint and varnish.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, params};

params! {
    /// A diffuse base under a clear dielectric: plastic, paint, glazed pottery. With a coat: varnished wood or car
    /// paint.
    pub struct PlasticMaterial as "plastic" {
        /// Diffuse albedo of the base.
        color: ColorSource = ColorSource::Constant(Spectrum::grey(0.8)), in Range::NON_NEGATIVE;
        /// Roughness of the surface: 0 is a perfect mirror, 1 very rough. The GGX α is its square.
        roughness: ColorSource = ColorSource::Constant(Spectrum::grey(0.3)), in Range::UNIT;
        /// Index of refraction of the surface. 0 reflects all light.
        ior: f64 = 1.5, in Range::closed(0.0, 100.0);
        /// Fraction of the surface covered by a second clear layer.
        coat: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Roughness of the second layer.
        coat_roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Normal map in tangent space: red along u, green along v. Use an image with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Strength of the normal map: factor of red and green.
        normal_scale: f64 = 1.0;
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black in scene units; negative inverts.
        bump_scale: f64 = 0.1;
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
    /// The equivalent OpenPBR material.
    pub fn principled(&self) -> PrincipledMaterial {
        PrincipledMaterial {
            base_color: self.color,
            specular_roughness: self.roughness,
            specular_ior: self.ior,
            coat_weight: self.coat,
            coat_roughness: self.coat_roughness,
            normal_map: self.normal_map,
            normal_scale: self.normal_scale,
            bump_map: self.bump_map,
            bump_scale: self.bump_scale,
            ..PrincipledMaterial::default()
        }
    }
}
