//! Materials: how a surface scatters and emits light. One file per type; [`MaterialDesc`] is the table of their names
//! in a scene.
//!
//! Contract of every [`Material`]:
//!
//! - A description is plain settings. [`MaterialDesc::prepare`] prepares it once, for physically based integrators
//!   (`physical`) or for the others. Physically based integrators always get OpenPBR's layers: every type but mixes
//!   converts to a [`PrincipledMaterial`] ([`MaterialDesc::principled`] is `None` for mixes).
//! - It is evaluated at a [`SurfaceInteraction`] in world space with the scene's textures ([`MaterialEvalContext`]).
//!   The side of the surface that a ray hits (`entering`, `outside`) is the sign of N·D with the geometric normal,
//!   decided before any map changes the normal.
//! - [`OpenPbr::bsdf`] is a [`Bsdf`](crate::bsdf::Bsdf) in the frame of [`OpenPbr::frame`]: local directions with +z
//!   along the shading normal, pointing away from the surface, f without the cosine, pdfs per solid angle.
//! - Emission is radiance, the same in all directions, on the outer side and, unless the material says otherwise, on
//!   the inner side.
//! - Colours are linear; weights and roughnesses are within 0..=1, and texture values are clamped to that. Lengths
//!   (`subsurface_radius`, `transmission_depth`) are scene units.
//! - [`Cutout`] is the alpha test: the scene evaluates it during intersection. `None` is an opaque, two-sided surface.
//! - [`Material::shadow_tint`] is the fraction of light, by band, that a shadow ray keeps at one crossing of the
//!   surface; 1 is all.
//! - A material has no state and uses no random numbers; the caller supplies those that sample the BSDF.

mod base_color;
pub(crate) mod bent_normal;
mod block_bsdf;
mod classic;
mod conversion;
mod dielectric;
mod disney;
mod dispersion;
mod emission;
mod emissive;
mod evaluate;
mod gloss;
mod hair;
mod interface;
mod matte;
mod measured;
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

pub(crate) use block_bsdf::BlockBsdf;
pub use classic::{Classic, ClassicMaterial, Fresnel, ShadowKind};
pub use dielectric::DielectricMaterial;
pub use disney::DisneyMaterial;
pub use emissive::EmissiveMaterial;
pub(crate) use gloss::Gloss;
pub use gloss::GlossyLobe;
pub use hair::HairMaterial;
pub use interface::InterfaceMaterial;
pub use matte::MatteMaterial;
pub use measured::MeasuredMaterial;
pub use metal::MetalMaterial;
pub use mix::MixMaterial;
pub use mixed::Mix;
pub use normals::{apply_bump_map, apply_normal_map, bumped_normal, mapped_normal};
pub use open_pbr::OpenPbr;
pub use plastic::PlasticMaterial;
pub use principled::{AlphaMode, Bump, BumpUnit, PrincipledMaterial, SpecularModel};

use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::math::DVec3;
use crate::schema::{ColorSource, Named, family};
use crate::texture::{Footprint, TexturePoint, Textures};

family! {
    /// Materials: in `[material.NAME]`, or inline as `material = { … }`. The default `type` is "classic".
    pub enum MaterialDesc as "material", "materials" {
        Classic(ClassicMaterial),
        Principled(PrincipledMaterial),
        Matte(MatteMaterial),
        Metal(MetalMaterial),
        Dielectric(DielectricMaterial),
        Plastic(PlasticMaterial),
        Emissive(EmissiveMaterial),
        Mix(MixMaterial),
        Interface(InterfaceMaterial),
        Hair(HairMaterial),
        Disney(DisneyMaterial),
        Measured(MeasuredMaterial),
    }
}

/// A prepared material.
#[derive(Clone, Debug)]
pub enum Material {
    /// The classic shading model.
    Classic(Classic),
    /// An OpenPBR material for non-physical integrators, with the shadow it casts in the classic integrator.
    Principled(Box<PrincipledMaterial>, ShadowKind),
    /// Any material, for physically based integrators.
    OpenPbr(Box<OpenPbr>),
    /// A weighted mix of materials.
    Mix(Box<Mix>),
}

/// Where rays pass through a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutout {
    /// Opacity and its least opaque value; `None` for a material that is opaque everywhere.
    pub mask: Option<(ColorSource, f32)>,
    /// Whether rays pass that hit the back face.
    pub one_sided: bool,
}

impl Cutout {
    /// Whether a ray that hits the outer or inner side is stopped. The texture is evaluated at a point: the alpha test
    /// of a filtered mean would move the edges.
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
    /// Prepares the material, for physically based integrators (`physical`) or for the others. `descs` are the scene's
    /// materials, with their mixes already checked.
    pub fn prepare(&self, physical: bool, descs: &[Named<MaterialDesc>]) -> Material {
        match (self, self.principled()) {
            (MaterialDesc::Classic(m), _) if !physical => Material::Classic(m.prepare()),
            (MaterialDesc::Mix(m), _) => Material::Mix(Box::new(m.prepare(physical, descs))),
            (MaterialDesc::Interface(m), _) if physical => Material::OpenPbr(Box::new(OpenPbr::boundary(m))),
            (MaterialDesc::Hair(m), _) if physical => Material::OpenPbr(Box::new(OpenPbr::hair(m))),
            (MaterialDesc::Disney(m), _) if physical => Material::OpenPbr(Box::new(OpenPbr::disney(m))),
            (MaterialDesc::Measured(m), _) if physical => Material::OpenPbr(Box::new(OpenPbr::measured(m))),
            (_, Some(m)) if physical => Material::OpenPbr(Box::new(OpenPbr::new(m))),
            (_, m) => {
                let m = m.unwrap_or_default();
                let shadow = m.shadow();
                Material::Principled(Box::new(m), shadow)
            }
        }
    }

    /// The equivalent OpenPBR material; for a classic material an approximation. `None` for a mix.
    pub fn principled(&self) -> Option<PrincipledMaterial> {
        Some(match self {
            MaterialDesc::Classic(m) => PrincipledMaterial::from_classic(m),
            MaterialDesc::Principled(m) => m.clone(),
            MaterialDesc::Matte(m) => m.principled(),
            MaterialDesc::Metal(m) => m.principled(),
            MaterialDesc::Dielectric(m) => m.principled(),
            MaterialDesc::Plastic(m) => m.principled(),
            MaterialDesc::Emissive(m) => m.principled(),
            MaterialDesc::Interface(m) => m.principled(),
            MaterialDesc::Hair(m) => m.principled(),
            MaterialDesc::Disney(m) => m.principled(),
            MaterialDesc::Measured(m) => m.principled(),
            MaterialDesc::Mix(_) => return None,
        })
    }

    /// The alpha test of the material; `None` if it is opaque and two-sided.
    ///
    /// The interface of a medium stops rays of physically based integrators (`physical`) only.
    pub fn cutout(&self, physical: bool) -> Option<Cutout> {
        let (opacity, cutoff, one_sided) = match self {
            MaterialDesc::Classic(m) => (m.opacity, m.alpha_cutoff as f32, false),
            MaterialDesc::Disney(m) => return MaterialDesc::Principled(m.principled()).cutout(physical),
            MaterialDesc::Measured(m) => return MaterialDesc::Principled(m.principled()).cutout(physical),
            MaterialDesc::Principled(m) => {
                let cutoff = match m.alpha_mode {
                    AlphaMode::Mask => m.alpha_cutoff as f32,
                    // Opacity 0 is the same as a hole.
                    AlphaMode::Blend => f32::MIN_POSITIVE,
                    AlphaMode::Opaque => f32::NEG_INFINITY,
                };
                (m.opacity, cutoff, !m.double_sided && !m.is_transmissive())
            }
            MaterialDesc::Matte(_)
            | MaterialDesc::Metal(_)
            | MaterialDesc::Dielectric(_)
            | MaterialDesc::Plastic(_)
            | MaterialDesc::Emissive(_)
            | MaterialDesc::Hair(_) => return None,
            MaterialDesc::Interface(_) if physical => return None,
            MaterialDesc::Interface(_) => (ColorSource::Constant(Spectrum::BLACK), 0.5, false),
            // Each part has its own.
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
    /// The kind of shadow that its objects cast.
    #[inline]
    pub fn shadow(&self) -> ShadowKind {
        match self {
            Material::Classic(m) => m.shadow,
            Material::Principled(_, shadow) => *shadow,
            Material::OpenPbr(m) => m.shadow,
            Material::Mix(m) => m.shadow,
        }
    }

    /// Whether it is only the boundary of a medium.
    #[inline]
    pub fn is_boundary(&self) -> bool {
        matches!(self, Material::OpenPbr(m) if m.boundary)
    }

    /// Fraction of light that a tinted shadow keeps at a crossing of the surface, for a shadow ray in `direction`.
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

/// What materials need from the scene. Only [`crate::scene::Scene`] implements it, so shading is monomorphised and no
/// call is indirect.
pub trait MaterialEvalContext {
    /// All textures.
    fn textures(&self) -> &Textures;
    /// All materials, by id: the parts of mixes.
    fn materials(&self) -> &[Material];
    /// Texture coordinates and footprint at a surface point.
    fn texture_point(&self, surface: &SurfaceInteraction) -> TexturePoint<'_>;
    /// Unit tangent (along u) and bitangent (along v), perpendicular to the shading normal; `None` where (u, v) gives
    /// no directions. `uv_set` supplies them where a mesh has no tangents.
    fn tangent_frame(&self, surface: &SurfaceInteraction, uv_set: u32) -> Option<(DVec3, DVec3)>;
    /// The footprint of two world-space axes tangent to the surface.
    fn footprint(&self, surface: &SurfaceInteraction, axes: [DVec3; 2]) -> Footprint;
}

/// The colour of a source at a surface point.
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
