//! Materials: how a surface answers light. One file each; [`MaterialDesc`] is the table of their names in a scene.

mod base_color;
mod boundary;
mod classic;
mod conversion;
mod dielectric;
mod dispersion;
mod emission;
mod emissive;
mod evaluate;
mod gloss;
mod matte;
mod metal;
pub mod metals;
pub(crate) mod mix;
mod mixed;
mod physical;
mod plastic;
mod principled;
mod subsurface;

pub use boundary::BoundaryMaterial;
pub use classic::{Classic, ClassicMaterial, Fresnel, ShadowKind};
pub use dielectric::DielectricMaterial;
pub use emissive::EmissiveMaterial;
pub(crate) use gloss::Gloss;
pub use matte::MatteMaterial;
pub use metal::MetalMaterial;
pub use mix::MixMaterial;
pub use mixed::Mix;
pub use physical::Physical;
pub(crate) use physical::PlainBsdf;
pub use plastic::PlasticMaterial;
pub use principled::{AlphaMode, Bump, BumpUnit, PrincipledMaterial};

use crate::color::Spectrum;
use crate::math::DVec3;
use crate::scene::schema::family;
use crate::scene::{ColorSource, Named, Scene, SurfaceInteraction};
use crate::texture::TexturePoint;

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
        Mix(MixMaterial),
        Boundary(BoundaryMaterial),
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
    /// Several of them.
    Mix(Box<Mix>),
}

/// Where a material lets rays pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutout {
    /// Opacity and the least that is there; `None` for a material that is there everywhere.
    pub mask: Option<(ColorSource, f32)>,
    /// Whether rays pass from behind.
    pub one_sided: bool,
}

impl Cutout {
    /// Whether there is anything for a ray that meets the surface on its outer or inner side. Edges are those of the texture looked up at points: a mean would be
    /// cut off elsewhere than its parts.
    pub(crate) fn is_there(&self, scene: &Scene, at: &TexturePoint<'_>, outside: bool) -> bool {
        if self.one_sided && !outside {
            return false;
        }
        self.mask.is_none_or(|(opacity, cutoff)| scene.textures.opacity(opacity, &at.sharp()) >= cutoff)
    }
}

impl MaterialDesc {
    /// Makes it ready, for integrators that follow light (`physical`) or for the others. `descs` are the scene's materials, whose mixes
    /// are checked.
    pub fn prepare(&self, physical: bool, descs: &[Named<MaterialDesc>]) -> Material {
        match (self, self.principled()) {
            (MaterialDesc::Classic(m), _) if !physical => Material::Classic(m.prepare()),
            (MaterialDesc::Mix(m), _) => Material::Mix(Box::new(m.prepare(physical, descs))),
            (MaterialDesc::Boundary(m), _) if physical => Material::Physical(Box::new(Physical::boundary(m))),
            (_, Some(m)) if physical => Material::Physical(Box::new(Physical::new(m))),
            (_, m) => {
                let m = m.unwrap_or_default();
                let shadow = m.shadow();
                Material::Principled(Box::new(m), shadow)
            }
        }
    }

    /// In the terms of the physical material; what a classic one is there is a likeness. `None` for a mix, which is none.
    pub fn principled(&self) -> Option<PrincipledMaterial> {
        Some(match self {
            MaterialDesc::Classic(m) => PrincipledMaterial::from_classic(m),
            MaterialDesc::Principled(m) => m.clone(),
            MaterialDesc::Matte(m) => m.principled(),
            MaterialDesc::Metal(m) => m.principled(),
            MaterialDesc::Dielectric(m) => m.principled(),
            MaterialDesc::Plastic(m) => m.principled(),
            MaterialDesc::Emissive(m) => m.principled(),
            MaterialDesc::Boundary(m) => m.principled(),
            MaterialDesc::Mix(_) => return None,
        })
    }

    /// Where it lets rays pass; `None` for a material that is there everywhere and from all sides.
    ///
    /// A boundary of a medium is there for integrators that follow light (`physical`) and for no others.
    pub fn cutout(&self, physical: bool) -> Option<Cutout> {
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
            MaterialDesc::Boundary(_) if physical => return None,
            MaterialDesc::Boundary(_) => (ColorSource::Constant(Spectrum::BLACK), 0.5, false),
            // Decided by each of its materials.
            MaterialDesc::Mix(_) => return None,
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
            Material::Mix(m) => m.shadow,
        }
    }

    /// The share of light that a tinted shadow lets through at a crossing of the surface, by a shadow ray in `direction`.
    pub fn shadow_tint(&self, scene: &Scene, surface: &SurfaceInteraction, direction: DVec3) -> Spectrum {
        match self {
            Material::Classic(m) => color_at(m.color, scene, surface) * m.k_refract as f32,
            Material::Principled(m, _) => m.shadow_tint(scene, surface),
            Material::Physical(m) => m.shadow_tint(scene, surface, direction),
            Material::Mix(m) => m.shadow_tint(scene, surface, direction),
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
