//! Materials: how a surface answers light. One file each; [`MaterialDesc`] is the table of their names in a scene.

mod classic;
mod conversion;
mod dielectric;
mod emissive;
mod evaluate;
mod matte;
mod metal;
pub mod metals;
mod physical;
mod plastic;
mod principled;

pub use classic::{Classic, ClassicMaterial, Fresnel, ShadowKind};
pub use dielectric::DielectricMaterial;
pub use emissive::EmissiveMaterial;
pub use matte::MatteMaterial;
pub use metal::MetalMaterial;
pub use physical::Physical;
pub use plastic::PlasticMaterial;
pub use principled::{AlphaMode, PrincipledMaterial};

use crate::color::Spectrum;
use crate::scene::schema::family;
use crate::scene::{ColorSource, Scene, SurfaceInteraction};

family! {
    /// Materials: in `[material.NAME]`, or in place as `material = { … }`. The `type` is "classic" unless given.
    pub enum MaterialDesc as "material", "materials" {
        Classic(ClassicMaterial),
        Principled(PrincipledMaterial),
        Matte(MatteMaterial),
        Metal(MetalMaterial),
        Dielectric(DielectricMaterial),
        Plastic(PlasticMaterial),
        Emissive(EmissiveMaterial),
    }
}

impl Default for MaterialDesc {
    fn default() -> MaterialDesc {
        MaterialDesc::Classic(ClassicMaterial::default())
    }
}

/// A material ready to shade.
#[derive(Clone, Debug)]
pub enum Material {
    /// The classic documents' material.
    Classic(Classic),
    /// The physical material, with what its objects' shadows are like for the classic integrator.
    Principled(Box<PrincipledMaterial>, ShadowKind),
    /// Any material, for integrators that follow light.
    Physical(Box<Physical>),
}

/// Where a material lets rays pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutout {
    /// Opacity and the least that is there; `None` for a material that is there everywhere.
    pub mask: Option<(ColorSource, f32)>,
    /// Whether rays pass from behind.
    pub one_sided: bool,
}

impl MaterialDesc {
    /// Makes it ready.
    pub fn prepare(&self) -> Material {
        if let MaterialDesc::Classic(m) = self {
            return Material::Classic(m.prepare());
        }
        let m = self.principled();
        let shadow = m.shadow();
        Material::Principled(Box::new(m), shadow)
    }

    /// In the terms of the physical material; what a classic one is there is a likeness.
    pub fn principled(&self) -> PrincipledMaterial {
        match self {
            MaterialDesc::Classic(m) => PrincipledMaterial::from_classic(m),
            MaterialDesc::Principled(m) => m.clone(),
            MaterialDesc::Matte(m) => m.principled(),
            MaterialDesc::Metal(m) => m.principled(),
            MaterialDesc::Dielectric(m) => m.principled(),
            MaterialDesc::Plastic(m) => m.principled(),
            MaterialDesc::Emissive(m) => m.principled(),
        }
    }

    /// Where it lets rays pass; `None` for a material that is there everywhere and from all sides.
    pub fn cutout(&self) -> Option<Cutout> {
        let (opacity, cutoff, one_sided) = match self {
            MaterialDesc::Classic(m) => (m.opacity, m.alpha_cutoff as f32, false),
            MaterialDesc::Principled(m) => {
                let cutoff = match m.alpha_mode {
                    AlphaMode::Mask => m.alpha_cutoff as f32,
                    // Nothing at all is the same as a hole.
                    AlphaMode::Blend => f32::MIN_POSITIVE,
                    AlphaMode::Opaque => f32::NEG_INFINITY,
                };
                (m.opacity, cutoff, !m.double_sided && !m.is_transmissive())
            }
            MaterialDesc::Matte(_)
            | MaterialDesc::Metal(_)
            | MaterialDesc::Dielectric(_)
            | MaterialDesc::Plastic(_)
            | MaterialDesc::Emissive(_) => return None,
        };
        let everywhere = match opacity {
            ColorSource::Constant(c) => (c.r + c.g + c.b) / 3.0 >= cutoff,
            ColorSource::Texture(_) => cutoff == f32::NEG_INFINITY,
        };
        let mask = (!everywhere).then_some((opacity, cutoff));
        (mask.is_some() || one_sided).then_some(Cutout { mask, one_sided })
    }
}

impl Material {
    /// What shadow its objects cast.
    #[inline]
    pub fn shadow(&self) -> ShadowKind {
        match self {
            Material::Classic(m) => m.shadow,
            Material::Principled(_, shadow) => *shadow,
            Material::Physical(m) => m.shadow,
        }
    }

    /// The share of light that a tinted shadow lets through at a crossing of the surface.
    pub fn shadow_tint(&self, scene: &Scene, surface: &SurfaceInteraction) -> Spectrum {
        match self {
            Material::Classic(m) => color_at(m.color, scene, surface) * m.k_refract as f32,
            Material::Principled(m, _) => m.shadow_tint(scene, surface),
            Material::Physical(m) => Spectrum::grey(1.0 - m.desc.coverage(scene, surface)),
        }
    }
}

/// The colour of a source on a surface.
#[inline]
pub fn color_at(source: ColorSource, scene: &Scene, surface: &SurfaceInteraction) -> Spectrum {
    match source {
        ColorSource::Constant(c) => c,
        ColorSource::Texture(_) => scene.textures.color(source, &scene.texture_point(surface)),
    }
}
