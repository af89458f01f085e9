//! OpenPBR materials for the classic integrator, which has a local colour, one reflected and one refracted ray.
//!
//! | OpenPBR | classic |
//! |---|---|
//! | base colour × base weight | `color`; kd = ka = what metal and glass leave |
//! | specular of a dielectric, roughness r | highlight: strength F₀, exponent 2/r⁴ − 2 (at most 10⁴); reflected ray for r < 0.3, by Schlick, attenuated with r |
//! | metal | highlight and reflected ray weighted by its reflectance, the rest as local colour |
//! | transmission | refracted ray (straight through thin walls), exact Fresnel; tinted shadow |
//! | opacity in mode "blend" | a straight ray of weight 1 − opacity |
//! | emission, unlit | added unchanged |
//! | bump map, normal map | shading normal |
//! | coat | highlight of the coat |
//! | fuzz, film, anisotropy, subsurface, dispersion, absorption | ignored |

use super::{Classic, ClassicMaterial, Fresnel, PrincipledMaterial, ShadowKind, SpecularModel, color_at};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::{MaterialEvalContext, apply_bump_map, apply_normal_map};
use crate::math::DVec3;
use crate::schema::ColorSource;
use crate::texture::TexturePoint;

/// Rougher surfaces have no reflected ray.
const MIRROR_ROUGHNESS: f32 = 0.3;

impl PrincipledMaterial {
    /// Whether light is transmitted anywhere.
    pub fn is_transmissive(&self) -> bool {
        self.transmission_weight != ColorSource::Constant(Spectrum::BLACK)
    }

    /// The shadow that its objects cast.
    pub(super) fn shadow(&self) -> ShadowKind {
        let translucent = self.is_transmissive()
            || (self.alpha_mode == super::AlphaMode::Blend
                && self.opacity != ColorSource::Constant(Spectrum::WHITE));
        if translucent { ShadowKind::Tinted } else { ShadowKind::Opaque }
    }

    /// Fraction of light that passes at one crossing of the surface.
    pub(super) fn shadow_tint(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
    ) -> Spectrum {
        let at = |source| color_at(source, scene, surface);
        let through =
            at(self.transmission_color) * at(self.transmission_tint) * unit(at(self.transmission_weight));
        let opacity = self.coverage(scene, surface);
        through * opacity + Spectrum::grey(1.0 - opacity)
    }

    /// Opacity in the mode "blend"; 1 in the others. Textures are not filtered, because intersection has already let rays
    /// pass where the unfiltered opacity is 0: a filtered one would count those holes twice.
    pub fn coverage(&self, scene: &impl MaterialEvalContext, surface: &SurfaceInteraction) -> f32 {
        match self.alpha_mode {
            super::AlphaMode::Blend => self.coverage_at(scene, &scene.texture_point(&surface.sharp())),
            _ => 1.0,
        }
    }

    /// Opacity at a texture point.
    pub(super) fn coverage_at(&self, scene: &impl MaterialEvalContext, at: &TexturePoint<'_>) -> f32 {
        match self.alpha_mode {
            super::AlphaMode::Blend => {
                let opacity = scene.textures().opacity(self.opacity, at);
                if opacity > 0.0 { opacity.min(1.0) } else { 0.0 }
            }
            _ => 1.0,
        }
    }

    /// The equivalent classic material at a hit, and the emission. Applies the bump and normal maps to the shading
    /// normal of `surface`.
    pub fn as_classic(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &mut SurfaceInteraction,
        direction: DVec3,
    ) -> (Classic, Spectrum) {
        if let Some(bump) = self.bump() {
            apply_bump_map(scene, surface, bump);
        }
        apply_normal_map(scene, surface, self.normal_map, self.normal_scale);
        let at = |source| color_at(source, scene, surface);
        let base = at(self.base_color) * at(self.base_weight);
        let opacity = self.coverage(scene, surface);
        if self.unlit {
            let through = ClassicMaterial {
                ka: 0.0,
                kd: 0.0,
                k_local: Some(0.0),
                k_refract: f64::from(1.0 - opacity),
                ior: 1.0,
                shadow: self.shadow(),
                ..ClassicMaterial::default()
            };
            return (through.prepare(), base * opacity);
        }
        let emitted = at(self.emission_color) * (self.emission_luminance as f32) * opacity;
        let (metal, glass) = (unit(at(self.base_metalness)), unit(at(self.transmission_weight)));
        let glass = glass * (1.0 - metal);
        let roughness = unit(at(self.specular_roughness));
        let f0 = (self.specular_ior - 1.0) / (self.specular_ior + 1.0);
        let f0 = (f0 * f0) as f32;
        let f0 = match self.specular_model {
            SpecularModel::OpenPbr => f0 * mean(at(self.specular_weight)) * mean(at(self.specular_color)),
            SpecularModel::Gltf => {
                let f0 = if self.specular_ior > 0.0 { f0 } else { 1.0 };
                (f0 * mean(at(self.specular_color))).min(1.0) * unit(at(self.specular_weight))
            }
        };
        let cosine = direction.dot(surface.ns).abs().min(1.0) as f32;
        let grazing = 1.0 - cosine;
        let grazing = grazing * grazing * grazing * grazing * grazing;
        let smooth = (1.0 - roughness / MIRROR_ROUGHNESS).max(0.0);
        let reflectance = |f0: f32| f0 + (1.0 - f0) * grazing;
        let mirror_metal = metal * mean(base) * smooth;
        let mirror_dielectric = (1.0 - metal) * (1.0 - glass) * reflectance(f0) * smooth;
        let alpha = (f64::from(roughness) * f64::from(roughness)).max(0.01);
        let exponent = (2.0 / (alpha * alpha) - 2.0).clamp(1.0, 1e4);
        let strength = f0 + (mean(base) - f0) * metal;
        let coat = unit(at(self.coat_weight)) * 0.05;
        // A highlight of the correct size is brighter than 1; the display shows at most 1.
        let ks = f64::from((strength * (1.0 - roughness) * 4.0).min(1.0) + coat);
        let through = f64::from(1.0 - opacity);
        let transmitted = at(self.transmission_color) * at(self.transmission_tint);
        let bends = glass > 0.0 && through == 0.0;
        let mirror = f64::from((mirror_metal + mirror_dielectric).min(1.0) * opacity);
        let local = f64::from((1.0 - glass) * opacity) * (1.0 - f64::from(mirror_metal));
        let occlusion = self
            .occlusion_map
            .map_or(1.0, |map| 1.0 + (self.occlusion_strength as f32) * (unit(at(map)) - 1.0));
        let classic = ClassicMaterial {
            color: ColorSource::Constant(base),
            ka: f64::from(occlusion),
            kd: 1.0,
            ks,
            shininess: exponent,
            k_local: Some(local),
            k_reflect: if bends { f64::from(glass) } else { mirror },
            k_refract: if bends { f64::from(glass * mean(transmitted)) } else { through },
            ior: if bends && !self.thin_walled { self.specular_ior.max(1e-3) } else { 1.0 },
            fresnel: if bends { Fresnel::Exact } else { Fresnel::Off },
            shadow: self.shadow(),
            ..ClassicMaterial::default()
        };
        (classic.prepare(), emitted)
    }
}

fn mean(c: Spectrum) -> f32 {
    (c.r + c.g + c.b) / 3.0
}

/// The mean, within 0..=1.
fn unit(c: Spectrum) -> f32 {
    let v = mean(c);
    if v > 0.0 { v.min(1.0) } else { 0.0 }
}
