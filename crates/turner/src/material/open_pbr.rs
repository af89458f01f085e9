//! Materials as the integrators that follow light take them: the physical material, with what is known of it beforehand.
//!
//! A classic material becomes a physical one:
//!
//! | classic | physical |
//! |---|---|
//! | `color`, `kd` | base colour and weight of a Lambertian base |
//! | `ks`, `shininess` n | dielectric specular of roughness (2/(n + 2))^(1/4) |
//! | `k_reflect` | smooth specular with that reflectance seen head-on; from 0.9 on, a metal mirror of that grey; with `fresnel`, of the material's `ior` |
//! | `k_refract` | glass with the material's `ior`, in proportion to the local colour |
//! | `opacity`, `alpha_cutoff` | the same |
//! | `bump_map`, `bump_scale` | the same |
//! | `ka` | nothing: light from all around is traced |

use super::gloss::Gloss;
use super::{AlphaMode, ClassicMaterial, Fresnel, InterfaceMaterial, PrincipledMaterial, ShadowKind};
use crate::bsdf::{Bsdf, RoughMirror};
use crate::color::Spectrum;
use crate::material::MaterialEvalContext;
use crate::schema::ColorSource;
use crate::texture::TexturePoint;

/// A physical material, prepared.
#[derive(Clone, Debug)]
pub struct OpenPbr {
    /// What it is made of.
    pub desc: PrincipledMaterial,
    /// Its objects' shadows: opaque, or tinted where it covers only a share of what is behind.
    pub(super) shadow: ShadowKind,
    /// Whether light passes straight through it as through a clear pane, as well as by its other lobes.
    pub(crate) pane: bool,
    /// Whether it gathers light into caustics: whether a mirror's lobe or a narrow one reflects or refracts it.
    pub(crate) casts_caustics: bool,
    /// Whether it scatters by mirrors' lobes and narrow ones alone: polished metal, glass.
    pub(crate) near_specular: bool,
    /// Whether it is no surface, but the boundary of a medium.
    pub(crate) boundary: bool,
    /// Whether light walks about in the body that it encloses.
    pub(crate) walks: bool,
    /// Indices of refraction by colour band, where they differ.
    pub(crate) dispersion: Option<[f64; 3]>,
    /// From outside and from inside, if it is the same everywhere and surrounded by nothing.
    constant: Option<[Bsdf; 2]>,
    gloss: Gloss,
    plain: Option<PlainBsdf>,
}

/// A BSDF of a kind that is computed for eight points at a time.
#[derive(Clone, Debug)]
pub(crate) enum PlainBsdf {
    /// Lambert's: its BRDF.
    Lambert(Spectrum),
    RoughMirror(RoughMirror),
}

/// A source that is the same grey everywhere.
const fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

impl PrincipledMaterial {
    /// A physical material that looks like a classic one; the table above says how.
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
            // The local share is what is left beside the glass.
            let glass = m.k_refract / (m.k_refract + local);
            p.transmission_weight = grey(unit(glass));
            p.base_weight = grey(unit(m.kd));
        } else if m.k_reflect > 0.0 && m.fresnel == Fresnel::Off {
            if m.k_reflect >= 0.9 {
                p.base_metalness = grey(1.0);
                p.base_color = grey(unit(m.k_reflect));
                p.base_weight = grey(1.0);
            } else {
                // The index of refraction that reflects so much.
                let r = m.k_reflect.sqrt();
                p.specular_ior = (1.0 + r) / (1.0 - r);
                // The specular layer takes its share of the base by itself.
                p.base_weight = grey(unit(m.kd * m.k_local.map_or(1.0, |k| k / (1.0 - m.k_reflect))));
            }
        } else if m.k_reflect > 0.0 {
            p.specular_weight = grey(unit(m.k_reflect));
        }
        p
    }
}

impl PrincipledMaterial {
    /// Radiance at a place where the surface is there; pictures may hold what no light is.
    #[inline]
    pub fn emitted_color(&self, scene: &impl MaterialEvalContext, at: &TexturePoint<'_>) -> Spectrum {
        let sound = |v: f32| if v > 0.0 { v.min(1e15) } else { 0.0 };
        scene.textures().color(self.emission_color, at).map(sound) * self.emission_luminance as f32
    }
}

impl PrincipledMaterial {
    /// Whether it is a thin wall so smooth everywhere that light goes straight through.
    fn is_pane(&self) -> bool {
        /// Squared, the width of a lobe that counts as a mirror's, however stretched.
        const SMOOTH: f32 = 0.008;
        let at_most = |source: ColorSource, most: f32| matches!(source, ColorSource::Constant(c) if c.max_component() <= most);
        self.thin_walled
            && self.is_transmissive()
            && at_most(self.specular_roughness, SMOOTH)
            && (at_most(self.coat_weight, 0.0) || at_most(self.coat_roughness, 0.0))
    }
}

impl PrincipledMaterial {
    /// Whether light is reflected or refracted by a mirror's lobe or a narrow one, if only somewhere.
    fn casts_caustics(&self) -> bool {
        /// Wider lobes are found by chance often enough. Of metal and glass, whose light is strong; of what shines faintly under a diffuse body.
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

    /// Whether light is scattered by mirrors' lobes and narrow ones alone, everywhere.
    fn is_near_specular(&self) -> bool {
        /// Roughness up to which a lobe shows a picture of what is around, and the sun as a spot of a few degrees.
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
    /// Makes it ready.
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
        let walks = desc.has_walk();
        let mut made = OpenPbr {
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
            plain: None,
        };
        made.plain = made.find_plain();
        made
    }

    /// Its scattering, if there is nothing else to it: one of a few kinds, the same everywhere and on both sides, around the surface's own
    /// normal, without light of its own.
    #[inline]
    pub(crate) fn plain(&self) -> Option<&PlainBsdf> {
        self.plain.as_ref()
    }

    fn find_plain(&self) -> Option<PlainBsdf> {
        let d = &self.desc;
        let plain = d.alpha_mode != AlphaMode::Blend
            && !d.unlit
            && !self.is_emissive()
            && !self.pane
            && !self.has_inside()
            && self.dispersion.is_none()
            && d.bump().is_none()
            && d.normal_map.is_none()
            && d.coat_normal_map.is_none()
            && d.specular_roughness_anisotropy == ColorSource::Constant(Spectrum::BLACK);
        let [outer, inner] = self.constant.as_ref().filter(|_| plain)?;
        if let (Some(f), Some(inside)) = (outer.as_lambert(), inner.as_lambert()) {
            return (f == inside && !f.is_black()).then_some(PlainBsdf::Lambert(f));
        }
        let [outer, inner] = [outer.as_rough_mirror()?, inner.as_rough_mirror()?];
        (outer == inner).then_some(PlainBsdf::RoughMirror(outer))
    }

    /// The boundary of a medium.
    pub fn boundary(desc: &InterfaceMaterial) -> OpenPbr {
        let made = OpenPbr::new(desc.principled());
        OpenPbr {
            boundary: true,
            casts_caustics: false,
            near_specular: false,
            plain: None,
            shadow: ShadowKind::None,
            ..made
        }
    }

    /// Its scattering, if it is the same everywhere; for surfaces between it and nothing.
    #[inline]
    pub fn constant_bsdf(&self, entering: bool) -> Option<&Bsdf> {
        self.constant.as_ref().map(|[outer, inner]| if entering { outer } else { inner })
    }

    /// Whether light goes through it into what it encloses.
    #[inline]
    pub fn has_inside(&self) -> bool {
        !self.desc.thin_walled && self.desc.is_transmissive()
    }

    /// Whether it only reflects: light that arrives on the other side does not count.
    #[inline]
    pub fn is_one_sided(&self) -> bool {
        !self.desc.thin_walled && !self.desc.is_transmissive()
    }

    /// Where light counts only on the side that is seen: how its reflection stands out there, to choose lights by.
    #[inline]
    pub(crate) fn side(&self) -> Option<Gloss> {
        self.is_one_sided().then_some(self.gloss)
    }

    /// Whether it shines and lights other things.
    #[inline]
    pub fn is_emissive(&self) -> bool {
        !self.desc.unlit
            && self.desc.emission_luminance > 0.0
            && self.desc.emission_color != ColorSource::Constant(Spectrum::BLACK)
    }

    /// Whether it shines on its inner side, too: where it has one.
    #[inline]
    pub fn shines_backwards(&self) -> bool {
        self.desc.double_sided && !self.desc.emission_front_only
    }

    /// On how many sides it shines.
    pub fn sides(&self) -> f64 {
        if self.shines_backwards() { 2.0 } else { 1.0 }
    }

    /// Whether its light differs from place to place.
    pub fn has_emission_texture(&self) -> bool {
        matches!(self.desc.emission_color, ColorSource::Texture(_)) || self.is_perforated()
    }

    fn is_perforated(&self) -> bool {
        self.desc.alpha_mode != AlphaMode::Opaque && matches!(self.desc.opacity, ColorSource::Texture(_))
    }

    /// Radiance, both sides counted, where it is the same everywhere; of a texture, that of white.
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

    /// Radiance where it is the same everywhere.
    #[inline]
    pub fn constant_emission(&self) -> Option<Spectrum> {
        match (self.desc.emission_color, self.desc.alpha_mode, self.desc.opacity) {
            (ColorSource::Constant(c), AlphaMode::Opaque | AlphaMode::Mask, ColorSource::Constant(_)) => {
                Some(c * self.desc.emission_luminance as f32)
            }
            _ => None,
        }
    }

    /// Radiance at a place, as far as the surface is there.
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
