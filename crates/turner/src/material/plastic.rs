//! Plastic, paint and varnish.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, params};

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
        /// A picture of normals in the tangent frame (red along u, green along v), with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Factor of its red and green parts.
        normal_scale: f64 = 1.0;
        /// A texture of heights that the normal follows as if the surface rose and fell with it: white stands highest.
        bump_map: Option<ColorSource> = None;
        /// How high white stands above black, scene units; below 0, how deep.
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
    /// The same in the terms of the physical material.
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
