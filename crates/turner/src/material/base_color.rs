//! The colour that a material has by itself, whatever lights it.

use super::{Material, color_at};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::MaterialEvalContext;

impl Material {
    /// The base colour at a place, seen from outside or from inside; of a mix, those of its materials by their shares.
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
                    // None of these is a mix.
                    sum += part.material.base_color(scene, surface, outside) * part.weight as f32;
                });
                sum
            }
        }
    }
}
