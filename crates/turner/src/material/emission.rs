//! What materials emit, mixes included.

use super::Material;
use crate::color::Spectrum;
use crate::material::{MaterialEvalContext, PrincipledMaterial};
use crate::schema::ColorSource;
use crate::texture::TexturePoint;

impl Material {
    /// Whether it shines and lights other things.
    pub fn is_emissive(&self, scene: &impl MaterialEvalContext) -> bool {
        match self {
            Material::OpenPbr(m) => m.is_emissive(),
            Material::Mix(m) => m.emitting(scene).next().is_some(),
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }

    /// Whether it may shine; a mix may by any of its materials.
    pub(crate) fn may_shine(&self) -> bool {
        match self {
            Material::OpenPbr(m) => m.is_emissive(),
            Material::Mix(_) => true,
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }

    /// Radiance, both sides counted, where it is the same everywhere; of a texture, that of white.
    pub fn emission_estimate(&self, scene: &impl MaterialEvalContext) -> f64 {
        match self {
            Material::OpenPbr(m) => m.emission_estimate(),
            Material::Mix(m) => {
                m.emitting(scene).map(|(weight, m)| weight * m.emission_estimate(scene)).sum()
            }
            Material::Classic(_) | Material::Principled(..) => 0.0,
        }
    }

    /// Whether it may shine on both sides.
    pub fn may_shine_backwards(&self) -> bool {
        match self {
            Material::OpenPbr(m) => m.shines_backwards(),
            Material::Mix(_) | Material::Classic(_) | Material::Principled(..) => true,
        }
    }

    /// Whether its light differs from place to place.
    pub fn has_emission_texture(&self) -> bool {
        match self {
            Material::OpenPbr(m) => m.has_emission_texture(),
            // Its weights, its holes, its parts: hardly ever are all of them the same everywhere.
            Material::Mix(_) => true,
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }

    /// Radiance at a place towards the outer or the inner side, as far as the surface is there.
    #[inline]
    pub fn emitted<'a>(
        &self,
        scene: &impl MaterialEvalContext,
        at: impl FnOnce() -> TexturePoint<'a>,
        outside: bool,
    ) -> Spectrum {
        match self {
            Material::OpenPbr(m) if outside || m.shines_backwards() => {
                m.constant_emission().unwrap_or_else(|| m.emitted(scene, &at()))
            }
            Material::Mix(m) => {
                let (mut sum, at) = (Spectrum::BLACK, at());
                m.each(scene, &at, outside, &mut |part| {
                    if let Material::OpenPbr(m) = part.material
                        && part.present
                        && m.is_emissive()
                        && (outside || m.shines_backwards())
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
    /// The parts that shine, with about the share of each.
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
    /// Emission as far as it can be added up: not negative, finite, and the product of luminance and colour within single precision, with room
    /// for what paths multiply and pixels add.
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
