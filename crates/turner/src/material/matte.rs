//! Diffuse surfaces.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, params};

params! {
    /// A diffuse surface without highlight: paper, plaster, unglazed clay.
    pub struct MatteMaterial as "matte" {
        /// Its colour.
        color: ColorSource = ColorSource::Constant(Spectrum::grey(0.8)), in Range::NON_NEGATIVE;
        /// 0 is Lambert's law; rougher surfaces are flatter, and brighter towards the light (Oren–Nayar, keeping energy).
        roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// A picture of normals in the tangent frame (red along u, green along v), with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Factor of its red and green parts.
        normal_scale: f64 = 1.0;
        /// A texture of heights that the normal follows as if the surface rose and fell with it: white stands highest.
        bump_map: Option<ColorSource> = None;
        /// How high white stands above black, scene units; below 0, how deep.
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
    /// The same in the terms of the physical material.
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
