//! Emission of materials, including mixes.

use super::Material;
use crate::color::Spectrum;
use crate::material::{MaterialEvalContext, PrincipledMaterial};
use crate::schema::ColorSource;
use crate::texture::TexturePoint;

impl Material {
    /// Whether it is an emitter.
    pub fn is_emissive(&self, scene: &impl MaterialEvalContext) -> bool {
        match self {
            Material::OpenPbr(m) => m.is_emissive(),
            Material::Mix(m) => m.emitting(scene).next().is_some(),
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }

    /// Whether it may emit; a mix may through any of its parts.
    pub(crate) fn may_emit(&self) -> bool {
        match self {
            Material::OpenPbr(m) => m.is_emissive(),
            Material::Mix(_) => true,
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }

    /// Radiance of both sides if constant; of a texture, that of white.
    pub fn emission_estimate(&self, scene: &impl MaterialEvalContext) -> f64 {
        match self {
            Material::OpenPbr(m) => m.emission_estimate(),
            Material::Mix(m) => {
                m.emitting(scene).map(|(weight, m)| weight * m.emission_estimate(scene)).sum()
            }
            Material::Classic(_) | Material::Principled(..) => 0.0,
        }
    }

    /// Whether it may emit on both sides.
    pub fn may_emit_backwards(&self) -> bool {
        match self {
            Material::OpenPbr(m) => m.emits_backwards(),
            Material::Mix(_) | Material::Classic(_) | Material::Principled(..) => true,
        }
    }

    /// Whether its emission varies over the surface.
    pub fn has_emission_texture(&self) -> bool {
        match self {
            Material::OpenPbr(m) => m.has_emission_texture(),
            // Weights, opacity and parts are hardly ever all constant.
            Material::Mix(_) => true,
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }

    /// Radiance at a point on the outer or inner side, times the opacity.
    #[inline]
    pub fn emitted<'a>(
        &self,
        scene: &impl MaterialEvalContext,
        at: impl FnOnce() -> TexturePoint<'a>,
        outside: bool,
    ) -> Spectrum {
        match self {
            Material::OpenPbr(m) if outside || m.emits_backwards() => {
                m.constant_emission().unwrap_or_else(|| m.emitted(scene, &at()))
            }
            Material::Mix(m) => {
                let (mut sum, at) = (Spectrum::BLACK, at());
                m.each(scene, &at, outside, &mut |part| {
                    if let Material::OpenPbr(m) = part.material
                        && part.present
                        && m.is_emissive()
                        && (outside || m.emits_backwards())
                    {
                        sum += m.emitted(scene, &at) * part.weight as f32;
                    }
                });
                sum
            }
            Material::OpenPbr(_) | Material::Classic(_) | Material::Principled(..) => Spectrum::BLACK,
        }
    }
}

impl super::Mix {
    /// The emissive parts and their approximate weights.
    fn emitting<'a>(
        &'a self,
        scene: &'a impl MaterialEvalContext,
    ) -> impl Iterator<Item = (f64, &'a Material)> {
        self.shares().filter_map(|(id, weight)| {
            let material = scene.materials().get(id.index())?;
            (weight > 0.0 && material.is_emissive(scene)).then_some((weight, material))
        })
    }
}

/// A source as one number; textures count as 1.
pub(super) fn estimate(source: ColorSource) -> f64 {
    match source {
        ColorSource::Constant(c) => f64::from((c.r + c.g + c.b) / 3.0).max(0.0),
        ColorSource::Texture(_) => 1.0,
    }
}

impl PrincipledMaterial {
    /// Emission within the range that can be summed: not negative, finite, and the product of luminance and colour
    /// within single precision, with room for what paths multiply and pixels add.
    pub(crate) fn sound_emission(&self) -> (f64, ColorSource) {
        /// Largest factor.
        const MOST: f32 = 1e15;
        let factor = |v: f64| if v > 0.0 { v.min(f64::from(MOST)) } else { 0.0 };
        let color = match self.emission_color {
            ColorSource::Constant(c) => {
                ColorSource::Constant(Spectrum::from(c.to_array().map(|v| factor(f64::from(v)) as f32)))
            }
            texture => texture,
        };
        (factor(self.emission_luminance), color)
    }
}
