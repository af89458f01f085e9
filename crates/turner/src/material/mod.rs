//! Materials: how a surface answers light. One file each; [`MaterialDesc`] is the table of their names in a scene.
//!
//! The contract, which every [`Material`] keeps:
//!
//! - A description is plain settings; [`MaterialDesc::prepare`] makes it ready once, for integrators that follow light (`physical`) or for the others. Whatever the
//!   description, the former are given OpenPBR's layers: all kinds but mixes become a [`PrincipledMaterial`] ([`MaterialDesc::principled`] is `None` for mixes).
//! - It is given a [`SurfaceInteraction`] in world space and the scene's textures ([`MaterialEvalContext`]). Which side of the surface a ray meets
//!   (`entering`, `outside`) is the sign of N·D with the geometric normal, decided before any map bends the normal.
//! - [`OpenPbr::bsdf`] is a [`Bsdf`](crate::bsdf::Bsdf) in the frame of [`OpenPbr::frame`]: local directions with +z along the shading normal, pointing away from the surface,
//!   values without the cosine, densities per solid angle, as written there.
//! - Emission is radiance, the same in all directions, on the outer side and, unless the material says otherwise, on the inner one.
//! - Colours are linear, shares and roughnesses within 0..=1; what textures give beyond that is cut. Lengths (`subsurface_radius`, `transmission_depth`) are scene units.
//! - [`Cutout`] says where a ray passes as if there were nothing: the scene asks it during intersection. `None` is a surface that is there everywhere, from both sides.
//! - [`Material::shadow_tint`] is the share of light, by band, that one crossing of the surface lets through to a shadow ray; 1 is all.
//! - A material has no state and takes no random numbers: the BSDF is sampled by its caller's.

mod base_color;
pub(crate) mod bent_normal;
mod classic;
mod conversion;
mod dielectric;
mod dispersion;
mod emission;
mod emissive;
mod evaluate;
mod gloss;
mod interface;
mod matte;
mod metal;
pub mod metals;
pub(crate) mod mix;
#[cfg(test)]
mod mix_tests;
mod mixed;
mod normals;
mod open_pbr;
mod pane;
mod plastic;
mod principled;
mod subsurface;
pub(crate) mod vertex;

pub use classic::{Classic, ClassicMaterial, Fresnel, ShadowKind};
pub use dielectric::DielectricMaterial;
pub use emissive::EmissiveMaterial;
pub(crate) use gloss::Gloss;
pub use gloss::GlossyLobe;
pub use interface::InterfaceMaterial;
pub use matte::MatteMaterial;
pub use metal::MetalMaterial;
pub use mix::MixMaterial;
pub use mixed::Mix;
pub use normals::{apply_bump_map, apply_normal_map, bumped_normal, mapped_normal};
pub use open_pbr::OpenPbr;
pub(crate) use open_pbr::PlainBsdf;
pub use plastic::PlasticMaterial;
pub use principled::{AlphaMode, Bump, BumpUnit, PrincipledMaterial};

use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::math::DVec3;
use crate::schema::{ColorSource, Named, family};
use crate::texture::{Footprint, TexturePoint, Textures};

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
        Boundary(InterfaceMaterial),
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
    OpenPbr(Box<OpenPbr>),
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
    pub(crate) fn is_there(
        &self,
        scene: &impl MaterialEvalContext,
        at: &TexturePoint<'_>,
        outside: bool,
    ) -> bool {
        if self.one_sided && !outside {
            return false;
        }
        self.mask.is_none_or(|(opacity, cutoff)| scene.textures().opacity(opacity, &at.sharp()) >= cutoff)
    }
}

impl MaterialDesc {
    /// Makes it ready, for integrators that follow light (`physical`) or for the others. `descs` are the scene's materials, whose mixes
    /// are checked.
    pub fn prepare(&self, physical: bool, descs: &[Named<MaterialDesc>]) -> Material {
        match (self, self.principled()) {
            (MaterialDesc::Classic(m), _) if !physical => Material::Classic(m.prepare()),
            (MaterialDesc::Mix(m), _) => Material::Mix(Box::new(m.prepare(physical, descs))),
            (MaterialDesc::Boundary(m), _) if physical => Material::OpenPbr(Box::new(OpenPbr::boundary(m))),
            (_, Some(m)) if physical => Material::OpenPbr(Box::new(OpenPbr::new(m))),
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
            Material::OpenPbr(m) => m.shadow,
            Material::Mix(m) => m.shadow,
        }
    }

    /// The share of light that a tinted shadow lets through at a crossing of the surface, by a shadow ray in `direction`.
    pub fn shadow_tint(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        direction: DVec3,
    ) -> Spectrum {
        match self {
            Material::Classic(m) => color_at(m.color, scene, surface) * m.k_refract as f32,
            Material::Principled(m, _) => m.shadow_tint(scene, surface),
            Material::OpenPbr(m) => m.shadow_tint(scene, surface, direction),
            Material::Mix(m) => m.shadow_tint(scene, surface, direction),
        }
    }
}

/// What materials ask of the scene around them. One type implements it, [`crate::scene::Scene`], so that shading is compiled for it and no call is indirect.
pub trait MaterialEvalContext {
    /// All textures.
    fn textures(&self) -> &Textures;
    /// All materials, by id: what mixes are made of.
    fn materials(&self) -> &[Material];
    /// Where textures are looked up on a surface, and over what footprint.
    fn texture_point(&self, surface: &SurfaceInteraction) -> TexturePoint<'_>;
    /// Unit tangent (along u) and bitangent (along v) of a surface, at right angles to its shading normal; `None` where (u, v) say nothing about directions.
    /// `uv_set` is what directions are taken from where a mesh has no tangents.
    fn tangent_frame(&self, surface: &SurfaceInteraction, uv_set: u32) -> Option<(DVec3, DVec3)>;
    /// Two axes in the world, tangent to the surface, as a footprint of textures.
    fn footprint(&self, surface: &SurfaceInteraction, axes: [DVec3; 2]) -> Footprint;
}

/// The colour of a source on a surface.
#[inline]
pub fn color_at(
    source: ColorSource,
    scene: &impl MaterialEvalContext,
    surface: &SurfaceInteraction,
) -> Spectrum {
    match source {
        ColorSource::Constant(c) => c,
        ColorSource::Texture(_) => scene.textures().color(source, &scene.texture_point(surface)),
    }
}
