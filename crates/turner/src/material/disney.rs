//! Disney's principled material.

use super::open_pbr::Unlayered;
use super::{AlphaMode, BumpUnit, MaterialEvalContext, OpenPbr, PrincipledMaterial, ShadowKind};
use crate::bsdf::{Bsdf, DisneyPoint};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::schema::{ColorSource, MediumId, Range, params};

/// A constant grey.
const fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

params! {
    /// Disney's principled material (Burley 2012 and 2015), as in Mitsuba's `principled` and `principledthin`: lobes that
    /// are added, not layered, so that bright surfaces may reflect more light than arrives. For materials made for it;
    /// "principled" keeps energy. Weights and roughnesses can be textures. The integrator "classic" shows a similar
    /// principled material.
    pub struct DisneyMaterial as "disney" {
        /// Colour of diffuse reflection and of metal; its root is the colour of refraction.
        base_color: ColorSource = grey(0.5), in Range::NON_NEGATIVE;
        /// Roughness of all lobes but the clear coat: 0 is smooth, 1 very rough. α is its square.
        roughness: ColorSource = grey(0.5), in Range::UNIT;
        /// 0 is a dielectric, 1 a metal. Not in thin walls.
        metallic: ColorSource = grey(0.0), in Range::UNIT;
        /// Elongation of highlights along the tangent.
        anisotropic: ColorSource = grey(0.0), in Range::UNIT;
        /// Index of refraction of the dielectric.
        ior: f64 = 1.5, in Range::closed(0.001, 100.0);
        /// Fraction of the dielectric that refracts light.
        spec_trans: ColorSource = grey(0.0), in Range::UNIT;
        /// How much `base_color` tints reflection by the dielectric.
        spec_tint: ColorSource = grey(0.0), in Range::UNIT;
        /// Weight of the sheen: reflection of cloth towards grazing angles.
        sheen: ColorSource = grey(0.0), in Range::UNIT;
        /// How much `base_color` tints the sheen.
        sheen_tint: ColorSource = grey(0.0), in Range::UNIT;
        /// Weight of the clear coat, a second highlight. Not on thin walls.
        clearcoat: ColorSource = grey(0.0), in Range::UNIT;
        /// 0 is a satin clear coat, 1 a glossy one.
        clearcoat_gloss: ColorSource = grey(0.0), in Range::UNIT;
        /// Fraction of diffuse reflection that looks flatter, as if light were scattered inside.
        flatness: ColorSource = grey(0.0), in Range::UNIT;
        /// Fraction of the diffuse light that a thin wall transmits. Burley and Mitsuba count from 0 to 2.
        diff_trans: ColorSource = grey(0.0), in Range::UNIT;
        /// A thin wall: transmitted light is not refracted.
        thin_walled: bool = false;
        /// The medium inside, if light is refracted. Only for the integrators "path" and "direct".
        interior: Option<MediumId> = None;
        /// Whether only the front face of an opaque surface reflects light.
        front_only: bool = false;
        /// Emitted radiance, a factor of `emission_color`.
        emission_luminance: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Colour of the emission.
        emission_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Whether only the front face emits.
        emission_front_only: bool = false;
        /// Opacity from 0 (transparent) to 1 (opaque); `alpha_mode` determines its use.
        opacity: ColorSource = grey(1.0), in Range::UNIT;
        /// How `opacity` is used.
        alpha_mode: AlphaMode = AlphaMode::Blend;
        /// Normal map in tangent space: red along u, green along v. Use an image with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Strength of the normal map: factor of red and green.
        normal_scale: f64 = 1.0;
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black, in `bump_unit`; negative inverts.
        bump_scale: f64 = 0.1;
        /// The unit of `bump_scale`.
        bump_unit: BumpUnit = BumpUnit::Scene;
    }
    example r##"[material.satin]
type = "disney"
base_color = [0.5, 0.05, 0.08]
roughness = 0.4
sheen = 1
sheen_tint = 0.7

[[object]]
type = "sphere"
material = "satin"
"##
}

/// Weight of OpenPBR's fuzz per unit of sheen: with it as much light returns near the silhouette of a sphere (white
/// furnace: 0.019 there, against 0.214 of a full fuzz).
const SHEEN: f32 = 0.09;

/// A constant times a factor; textures stay.
fn times(source: ColorSource, factor: f32) -> ColorSource {
    match source {
        ColorSource::Constant(c) => ColorSource::Constant(c * factor),
        texture @ ColorSource::Texture(_) => texture,
    }
}

impl DisneyMaterial {
    /// A similar principled material, for integrators and formats without this one.
    pub fn principled(&self) -> PrincipledMaterial {
        // The clear coat has a quarter of its weight; its α is 0.1 to 0.001.
        let gloss = match self.clearcoat_gloss {
            ColorSource::Constant(c) => c.g.clamp(0.0, 1.0),
            ColorSource::Texture(_) => 0.5,
        };
        PrincipledMaterial {
            base_color: self.base_color,
            base_metalness: if self.thin_walled { grey(0.0) } else { self.metallic },
            specular_roughness: self.roughness,
            specular_roughness_anisotropy: self.anisotropic,
            specular_ior: self.ior,
            transmission_weight: self.spec_trans,
            transmission_color: self.base_color,
            subsurface_weight: if self.thin_walled { self.diff_trans } else { grey(0.0) },
            subsurface_color: self.base_color,
            thin_walled: self.thin_walled,
            coat_weight: if self.thin_walled { grey(0.0) } else { times(self.clearcoat, 0.25) },
            coat_roughness: grey((0.1 + (0.001 - 0.1) * gloss).sqrt()),
            coat_ior: 1.5,
            coat_darkening: 0.0,
            fuzz_weight: times(self.sheen, SHEEN),
            interior: self.interior,
            front_only: self.front_only,
            emission_luminance: self.emission_luminance,
            emission_color: self.emission_color,
            emission_front_only: self.emission_front_only,
            opacity: self.opacity,
            alpha_mode: self.alpha_mode,
            normal_map: self.normal_map,
            normal_scale: self.normal_scale,
            bump_map: self.bump_map,
            bump_scale: self.bump_scale,
            bump_unit: self.bump_unit,
            soften_terminator: false,
            ..PrincipledMaterial::default()
        }
    }

    /// The parameters seen from outside (`entering`) or inside, with `at` evaluating their sources.
    fn point(
        &self,
        entering: bool,
        transmits: bool,
        mut at: impl FnMut(ColorSource) -> Spectrum,
    ) -> DisneyPoint {
        let mut number = |source| {
            let c = at(source);
            f64::from((c.r + c.g + c.b) / 3.0)
        };
        DisneyPoint {
            metallic: number(self.metallic),
            roughness: number(self.roughness),
            anisotropic: number(self.anisotropic),
            spec_trans: number(self.spec_trans),
            spec_tint: number(self.spec_tint),
            sheen: number(self.sheen),
            sheen_tint: number(self.sheen_tint),
            clearcoat: number(self.clearcoat),
            clearcoat_gloss: number(self.clearcoat_gloss),
            flatness: number(self.flatness),
            diff_trans: number(self.diff_trans),
            ior: self.ior,
            thin_walled: self.thin_walled,
            inside: !entering && (transmits || self.front_only),
            base_color: at(self.base_color),
        }
    }

    /// The BSDF at a surface point.
    pub(super) fn bsdf(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        entering: bool,
        transmits: bool,
    ) -> Bsdf<'static> {
        let texture_point = scene.texture_point(surface);
        let at = |source| scene.textures().color(source, &texture_point);
        Bsdf::disney(&self.point(entering, transmits, at))
    }

    /// The BSDF from outside and from inside, if no parameter is textured.
    fn constant(&self, transmits: bool) -> Option<[Bsdf<'static>; 2]> {
        let mut all = true;
        let mut at = |source| match source {
            ColorSource::Constant(c) => c,
            ColorSource::Texture(_) => {
                all = false;
                Spectrum::BLACK
            }
        };
        let both = [true, false].map(|entering| Bsdf::disney(&self.point(entering, transmits, &mut at)));
        all.then_some(both)
    }
}

impl OpenPbr {
    /// Disney's principled material.
    pub(crate) fn disney(desc: &DisneyMaterial) -> OpenPbr {
        let mut made = OpenPbr::new(desc.principled());
        // Its lobes are never delta lobes, so no light passes straight through.
        let see_through = made.desc.alpha_mode == AlphaMode::Blend && made.desc.opacity != grey(1.0);
        made.shadow = if see_through { ShadowKind::Tinted } else { ShadowKind::Opaque };
        (made.pane, made.casts_caustics, made.near_specular) = (false, false, false);
        made.constant = desc.constant(made.desc.is_transmissive());
        made.textured_base = None;
        (made.is_opaque_base, made.is_plain, made.is_plain_outside) = (false, false, false);
        made.unlayered = Some(Unlayered::Disney(Box::new(desc.clone())));
        made
    }
}
