//! Diffuse surfaces.

use super::PrincipledMaterial;
use crate::color::Spectrum;
use crate::scene::ColorSource;
use crate::scene::schema::{Range, params};

params! {
    /// A diffuse surface without highlight: paper, plaster, unglazed clay.
    pub struct MatteMaterial as "matte" {
        /// Its colour.
        color: ColorSource = ColorSource::Constant(Spectrum::grey(0.8)), in Range::NON_NEGATIVE;
        /// 0 is Lambert's law; rougher surfaces are flatter, and brighter towards the light (Oren–Nayar, keeping energy).
        roughness: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
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
            ..PrincipledMaterial::default()
        }
    }
}
