//! The base colour of a material, without lighting.

use super::{Material, color_at};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::MaterialEvalContext;

impl Material {
    /// The base colour at a point, seen from outside or inside; of a mix, the weighted mean of its parts.
    pub fn base_color(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        outside: bool,
    ) -> Spectrum {
        let at = |source| color_at(source, scene, surface);
        match self {
            Material::Classic(m) => at(m.color),
            Material::Principled(m, _) => at(m.base_color) * at(m.base_weight),
            Material::OpenPbr(m) => at(m.desc.base_color) * at(m.desc.base_weight),
            Material::Mix(m) => {
                let mut sum = Spectrum::BLACK;
                m.each(scene, &scene.texture_point(surface), outside, &mut |part| {
                    // No part is a mix.
                    sum += part.material.base_color(scene, surface, outside) * part.weight as f32;
                });
                sum
            }
        }
    }
}
