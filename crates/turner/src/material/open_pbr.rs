//! OpenPBR materials, prepared for physically based integrators, and the conversion of classic materials:
//!
//! | classic | OpenPBR |
//! |---|---|
//! | `color`, `kd` | base colour and weight of a Lambertian base |
//! | `ks`, `shininess` n | dielectric specular of roughness (2/(n + 2))^(1/4) |
//! | `k_reflect` | smooth specular with that F₀; from 0.9 on a grey metal mirror; with `fresnel`, of the material's `ior` |
//! | `k_refract` | glass with the material's `ior`, in proportion to the local colour |
//! | `opacity`, `alpha_cutoff` | the same |
//! | `bump_map`, `bump_scale` | the same |
//! | `ka` | ignored: indirect light is traced |

use super::block_bsdf::TexturedBase;
use super::gloss::Gloss;
use super::{
    AlphaMode, ClassicMaterial, DisneyMaterial, Fresnel, HairMaterial, InterfaceMaterial, PrincipledMaterial,
    ShadowKind,
};
use crate::bsdf::{Bsdf, Measured, MetalIndex};
use crate::color::Spectrum;
use crate::material::MaterialEvalContext;
use crate::schema::ColorSource;
use crate::texture::TexturePoint;

/// A prepared OpenPBR material.
#[derive(Clone, Debug)]
pub struct OpenPbr {
    /// Its description.
    pub desc: PrincipledMaterial,
    /// Shadow of its objects: opaque, or tinted where the surface covers only part of what is behind.
    pub(super) shadow: ShadowKind,
    /// Whether light also passes straight through it, as through a clear pane.
    pub(crate) pane: bool,
    /// Whether it casts caustics: whether a delta lobe or a narrow lobe reflects or refracts light.
    pub(crate) casts_caustics: bool,
    /// Whether all its lobes are delta or narrow: polished metal, glass.
    pub(crate) near_specular: bool,
    /// Whether it is the interface of a medium and scatters nothing.
    pub(crate) boundary: bool,
    /// Whether light is scattered inside by a subsurface random walk.
    pub(crate) walks: bool,
    /// The index of refraction of its metal, if it is given.
    pub(super) metal_index: Option<MetalIndex>,
    /// Indices of refraction by colour band, if they differ.
    pub(crate) dispersion: Option<[f64; 3]>,
    /// The BSDF from outside and from inside, if it is constant and the exterior is empty.
    pub(super) constant: Option<[Bsdf<'static>; 2]>,
    gloss: Gloss,
    /// Whether its BSDF is an opaque base everywhere, unless a texture has an unusual value, and it does not emit.
    pub(crate) is_opaque_base: bool,
    /// Whether that BSDF is constant, the same on both sides, and around the surface's own normal.
    pub(super) is_plain: bool,
    /// The same for the outer side alone.
    pub(super) is_plain_outside: bool,
    /// The rest of that BSDF, if only its base colour is textured.
    pub(super) textured_base: Option<Box<TexturedBase>>,
    /// A material without OpenPBR's layers: its BSDF replaces that of `desc`.
    pub(super) unlayered: Option<Unlayered>,
}

/// Materials whose BSDFs are not made of OpenPBR's layers.
#[derive(Clone, Debug)]
pub(super) enum Unlayered {
    /// Hair.
    Hair(Box<HairMaterial>),
    /// Disney's principled material.
    Disney(Box<DisneyMaterial>),
    /// A measured BRDF, its tables, and whether only its front face reflects light.
    Measured { tables: Box<Measured>, front_only: bool },
}

/// A constant grey.
const fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

impl PrincipledMaterial {
    /// The OpenPBR approximation of a classic material; see the table of the module.
    pub fn from_classic(m: &ClassicMaterial) -> PrincipledMaterial {
        let unit = |v: f64| v.clamp(0.0, 1.0) as f32;
        let (ks, exponent) = m.highlight();
        let left = (1.0 - m.k_reflect - m.k_refract).max(0.0);
        let local = m.k_local.unwrap_or(left) * m.kd;
        let mut p = PrincipledMaterial {
            base_color: m.color,
            base_weight: grey(unit(local)),
            specular_weight: grey(0.0),
            opacity: m.opacity,
            alpha_cutoff: m.alpha_cutoff,
            bump_map: m.bump_map,
            bump_scale: m.bump_scale,
            ..PrincipledMaterial::default()
        };
        if ks > 0.0 {
            p.specular_weight = grey(1.0);
            p.specular_roughness = grey(unit((2.0 / (exponent + 2.0)).sqrt().sqrt()));
        }
        if m.k_reflect > 0.0 || m.k_refract > 0.0 {
            p.specular_weight = grey(1.0);
            p.specular_roughness = grey(0.0);
            p.specular_ior = m.ior;
        }
        if m.k_refract > 0.0 {
            // `local` is the weight left over by the glass.
            let glass = m.k_refract / (m.k_refract + local);
            p.transmission_weight = grey(unit(glass));
            p.base_weight = grey(unit(m.kd));
        } else if m.k_reflect > 0.0 && m.fresnel == Fresnel::Off {
            if m.k_reflect >= 0.9 {
                p.base_metalness = grey(1.0);
                p.base_color = grey(unit(m.k_reflect));
                p.base_weight = grey(1.0);
            } else {
                // The index of refraction with F₀ = k_reflect.
                let r = m.k_reflect.sqrt();
                p.specular_ior = (1.0 + r) / (1.0 - r);
                // The specular layer attenuates the base itself.
                p.base_weight = grey(unit(m.kd * m.k_local.map_or(1.0, |k| k / (1.0 - m.k_reflect))));
            }
        } else if m.k_reflect > 0.0 {
            p.specular_weight = grey(unit(m.k_reflect));
        }
        p
    }
}

impl PrincipledMaterial {
    /// Radiance where the surface is opaque. Texture values that are negative or not finite are clamped.
    #[inline]
    pub fn emitted_color(&self, scene: &impl MaterialEvalContext, at: &TexturePoint<'_>) -> Spectrum {
        let sound = |v: f32| if v > 0.0 { v.min(1e15) } else { 0.0 };
        scene.textures().color(self.emission_color, at).map(sound) * self.emission_luminance as f32
    }
}

impl PrincipledMaterial {
    /// Whether it is a smooth thin wall everywhere, so that light passes straight through.
    fn is_pane(&self) -> bool {
        /// Its square is the largest α of a delta lobe, however anisotropic.
        const SMOOTH: f32 = 0.008;
        let at_most = |source: ColorSource, most: f32| matches!(source, ColorSource::Constant(c) if c.max_component() <= most);
        self.thin_walled
            && self.is_transmissive()
            && at_most(self.specular_roughness, SMOOTH)
            && (at_most(self.coat_weight, 0.0) || at_most(self.coat_roughness, 0.0))
    }
}

impl PrincipledMaterial {
    /// Whether a delta or narrow lobe reflects or refracts light anywhere.
    fn casts_caustics(&self) -> bool {
        /// BSDF sampling finds lights well enough through rougher lobes. STRONG is for metal and glass, FAINT for the
        /// weak reflection of a dielectric over a diffuse base.
        const STRONG: f32 = 0.35;
        const FAINT: f32 = 0.2;
        let at_most = |source: ColorSource, most: f32| match source {
            ColorSource::Constant(c) => c.max_component() <= most,
            ColorSource::Texture(_) => true,
        };
        let any = |source: ColorSource| !matches!(source, ColorSource::Constant(c) if c.is_black());
        let strong = any(self.base_metalness) || self.is_transmissive() && !self.thin_walled;
        let faint = any(self.specular_weight) && self.specular_ior != 1.0;
        !self.unlit
            && (strong && at_most(self.specular_roughness, STRONG)
                || faint && at_most(self.specular_roughness, FAINT)
                || any(self.coat_weight) && at_most(self.coat_roughness, FAINT))
    }

    /// Whether it may have a thin film, whose colours take long to evaluate.
    pub(crate) fn has_thin_film(&self) -> bool {
        self.thin_film_weight != ColorSource::Constant(Spectrum::BLACK)
    }

    /// Whether all its lobes are delta or narrow, everywhere.
    fn is_near_specular(&self) -> bool {
        /// Up to this roughness the reflected environment is recognisable and the sun is a spot of a few degrees.
        const POLISHED: f32 = 0.15;
        let at_most = |source: ColorSource, most: f32| matches!(source, ColorSource::Constant(c) if c.max_component() <= most);
        let all = |source: ColorSource| matches!(source, ColorSource::Constant(c) if c == Spectrum::WHITE);
        let clear = all(self.transmission_weight) && !self.thin_walled;
        !self.unlit
            && (all(self.base_metalness) || clear && at_most(self.base_metalness, 0.0))
            && at_most(self.specular_roughness, POLISHED)
            && at_most(self.coat_weight, 0.0)
            && at_most(self.fuzz_weight, 0.0)
    }
}

impl OpenPbr {
    /// Prepares the material.
    pub fn new(mut desc: PrincipledMaterial) -> OpenPbr {
        (desc.emission_luminance, desc.emission_color) = desc.sound_emission();
        let see_through = desc.alpha_mode == AlphaMode::Blend && desc.opacity != grey(1.0);
        let pane = desc.is_pane();
        let shadow = if see_through || pane { ShadowKind::Tinted } else { ShadowKind::Opaque };
        let constant = desc.constant_point().map(|p| [Bsdf::new(&p), Bsdf::new(&desc.on_side(p, false))]);
        let dispersion = desc.dispersion();
        let casts_caustics = !pane && desc.casts_caustics();
        let gloss = Gloss::of(&desc);
        let near_specular = casts_caustics && desc.is_near_specular();
        let walks = desc.has_subsurface();
        let metal_index = desc.metal_index();
        let mut made = OpenPbr {
            metal_index,
            desc,
            shadow,
            pane,
            boundary: false,
            walks,
            casts_caustics,
            dispersion,
            constant,
            gloss,
            near_specular,
            is_opaque_base: false,
            is_plain: false,
            is_plain_outside: false,
            textured_base: None,
            unlayered: None,
        };
        made.prepare_blocks();
        made
    }

    /// The interface of a medium.
    pub fn boundary(desc: &InterfaceMaterial) -> OpenPbr {
        let made = OpenPbr::new(desc.principled());
        OpenPbr {
            boundary: true,
            casts_caustics: false,
            near_specular: false,
            is_opaque_base: false,
            is_plain: false,
            is_plain_outside: false,
            shadow: ShadowKind::None,
            ..made
        }
    }

    /// The BSDF if it is constant; for surfaces whose exterior is empty.
    #[inline]
    pub fn constant_bsdf(&self, entering: bool) -> Option<&Bsdf<'static>> {
        self.constant.as_ref().map(|[outer, inner]| if entering { outer } else { inner })
    }

    /// Whether it is hair, whose frame is that of the fibre.
    #[inline]
    pub(super) fn is_hair(&self) -> bool {
        matches!(self.unlayered, Some(Unlayered::Hair(_)))
    }

    /// Whether light is transmitted into what it encloses.
    #[inline]
    pub fn has_inside(&self) -> bool {
        !self.desc.thin_walled && self.desc.is_transmissive()
    }

    /// Whether light passes into a medium inside it without refraction: through a thin wall, or where the surface is
    /// transparent by alpha blending.
    #[inline]
    pub fn admits_medium(&self) -> bool {
        let d = &self.desc;
        d.interior.is_some()
            && !self.boundary
            && !self.has_inside()
            && (d.thin_walled || d.alpha_mode == AlphaMode::Blend)
    }

    /// Whether it only reflects: light that arrives on the other side does not contribute.
    #[inline]
    pub fn is_one_sided(&self) -> bool {
        !self.desc.thin_walled && !self.desc.is_transmissive()
    }

    /// The glossy lobe for light selection, if only light on the visible side contributes.
    #[inline]
    pub(crate) fn side(&self) -> Option<Gloss> {
        self.is_one_sided().then_some(self.gloss)
    }

    /// Whether it is an emitter.
    #[inline]
    pub fn is_emissive(&self) -> bool {
        !self.desc.unlit
            && self.desc.emission_luminance > 0.0
            && self.desc.emission_color != ColorSource::Constant(Spectrum::BLACK)
    }

    /// Whether it emits on the inner side, too.
    #[inline]
    pub fn emits_backwards(&self) -> bool {
        self.desc.double_sided && !self.desc.emission_front_only
    }

    /// Number of emitting sides.
    pub fn sides(&self) -> f64 {
        if self.emits_backwards() { 2.0 } else { 1.0 }
    }

    /// Whether its emission varies over the surface.
    pub fn has_emission_texture(&self) -> bool {
        matches!(self.desc.emission_color, ColorSource::Texture(_)) || self.is_perforated()
    }

    fn is_perforated(&self) -> bool {
        self.desc.alpha_mode != AlphaMode::Opaque && matches!(self.desc.opacity, ColorSource::Texture(_))
    }

    /// Radiance of both sides if constant; of a texture, that of white.
    pub fn emission_estimate(&self) -> f64 {
        if !self.is_emissive() {
            return 0.0;
        }
        let color = match self.desc.emission_color {
            ColorSource::Constant(c) => f64::from(c.luminance()),
            ColorSource::Texture(_) => 1.0,
        };
        color * self.desc.emission_luminance * self.sides()
    }

    /// Radiance if constant.
    #[inline]
    pub fn constant_emission(&self) -> Option<Spectrum> {
        let ColorSource::Constant(color) = self.desc.emission_color else { return None };
        let all = color * self.desc.emission_luminance as f32;
        match (self.desc.alpha_mode, self.desc.opacity) {
            (AlphaMode::Opaque, _) => Some(all),
            (AlphaMode::Mask, ColorSource::Constant(o)) => {
                let is_seen = (o.r + o.g + o.b) / 3.0 >= self.desc.alpha_cutoff as f32;
                Some(if is_seen { all } else { Spectrum::BLACK })
            }
            (AlphaMode::Mask | AlphaMode::Blend, _) => None,
        }
    }

    /// Radiance at a point, times the opacity.
    pub fn emitted(&self, scene: &impl MaterialEvalContext, at: &TexturePoint<'_>) -> Spectrum {
        let d = &self.desc;
        let covered = match d.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask => f32::from(scene.textures().opacity(d.opacity, at) >= d.alpha_cutoff as f32),
            AlphaMode::Blend => scene.textures().opacity(d.opacity, at).clamp(0.0, 1.0),
        };
        d.emitted_color(scene, at) * covered
    }
}
