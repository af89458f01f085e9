//! Diffuse surfaces.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, params};

params! {
    /// A diffuse surface without specular reflection: paper, plaster, unglazed clay.
    pub struct MatteMaterial as "matte" {
        /// Diffuse albedo.
        color: ColorSource = ColorSource::Constant(Spectrum::grey(0.8)), in Range::NON_NEGATIVE;
        /// Roughness: 0 is Lambertian. Rougher surfaces look flatter and are brighter towards the light
        /// (energy-preserving Oren-Nayar).
        roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Normal map in tangent space: red along u, green along v. Use an image with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Strength of the normal map: factor of red and green.
        normal_scale: f64 = 1.0;
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black in scene units; negative inverts.
        bump_scale: f64 = 0.1;
    }
    example r##"[material.clay]
type = "matte"
color = [0.6, 0.25, 0.12]
roughness = 0.7

[[object]]
type = "sphere"
material = "clay"
"##
}

impl MatteMaterial {
    /// The equivalent OpenPBR material.
    pub fn principled(&self) -> PrincipledMaterial {
        PrincipledMaterial {
            base_color: self.color,
            base_diffuse_roughness: self.roughness,
            specular_weight: ColorSource::Constant(Spectrum::BLACK),
            normal_map: self.normal_map,
            normal_scale: self.normal_scale,
            bump_map: self.bump_map,
            bump_scale: self.bump_scale,
            ..PrincipledMaterial::default()
        }
    }
}
