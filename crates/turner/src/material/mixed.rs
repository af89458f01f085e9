//! A mix evaluated at a point: the weights of its materials.
//!
//! Physically based integrators choose one material per hit, with its weight as the probability. The mean is exactly
//! the weighted sum of the BSDFs, emissions and opacities, and keeps their energy and reciprocity. (Mixing the
//! parameters instead would avoid the noise of that choice, but the result differs: half mirror and half diffuse is not
//! a surface of medium roughness.)

use super::emission::estimate;
use super::mix::MAX_PARTS;
use super::{
    Classic, ClassicMaterial, Cutout, Fresnel, Material, MixMaterial, OpenPbr, ShadowKind, color_at,
};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::{MaterialEvalContext, apply_bump_map};
use crate::math::DVec3;
use crate::schema::{ColorSource, MaterialId};
use crate::texture::TexturePoint;

/// A prepared mix.
#[derive(Clone, Debug)]
pub struct Mix {
    parts: Vec<Part>,
    /// Whether the first part gets what the weights of the others leave of 1.
    first_is_remainder: bool,
    pub(super) shadow: ShadowKind,
}

#[derive(Clone, Debug)]
struct Part {
    material: MaterialId,
    weight: ColorSource,
    /// Its alpha test.
    cutout: Option<Cutout>,
}

/// A material of a mix at a point.
pub(super) struct ResolvedPart<'a> {
    pub(super) material: &'a Material,
    /// Weight of the material.
    pub(super) weight: f64,
    /// Whether it passes the alpha test.
    pub(super) present: bool,
}

impl Mix {
    /// `shadows` returns the alpha test and the shadow of a material.
    pub(super) fn new(
        desc: &MixMaterial,
        shadows: impl Fn(MaterialId) -> (Option<Cutout>, ShadowKind),
    ) -> Mix {
        let even = ColorSource::Constant(Spectrum::WHITE);
        let first_is_remainder = desc.weights.len() + 1 == desc.materials.len();
        let skipped = usize::from(first_is_remainder);
        let mut shadow = ShadowKind::Opaque;
        let parts = desc.materials.iter().enumerate().map(|(i, &material)| {
            let (cutout, own) = shadows(material);
            if cutout.is_some() || own != ShadowKind::Opaque {
                shadow = ShadowKind::Tinted;
            }
            let weight = i.checked_sub(skipped).and_then(|i| desc.weights.get(i));
            Part { material, weight: weight.copied().unwrap_or(even), cutout }
        });
        let parts = parts.collect();
        Mix { parts, first_is_remainder, shadow }
    }

    /// The parts and their approximate weights: a texture counts as 1, so a part gets weight 0 only if it is 0
    /// everywhere.
    pub(crate) fn shares(&self) -> impl Iterator<Item = (MaterialId, f64)> + '_ {
        let weights = || self.parts.iter().map(|p| estimate(p.weight));
        let sum: f64 = weights().skip(usize::from(self.first_is_remainder)).sum();
        let varies = self.parts.iter().any(|p| matches!(p.weight, ColorSource::Texture(_)));
        let first = match self.first_is_remainder {
            true if varies => 1.0,
            true => (1.0 - sum).max(0.0),
            false => estimate(self.parts[0].weight) + f64::from(sum <= 0.0),
        };
        let total = sum.max(if self.first_is_remainder { 1.0 } else { f64::MIN_POSITIVE });
        let total = if sum > 0.0 { total } else { 1.0 };
        self.parts
            .iter()
            .enumerate()
            .map(move |(i, p)| (p.material, if i == 0 { first } else { estimate(p.weight) } / total))
    }

    /// Visits the materials at a point, nested mixes resolved, seen from outside or inside; the weights sum to 1. The
    /// scene's check bounds the nesting.
    pub(super) fn each<'a>(
        &self,
        scene: &'a impl MaterialEvalContext,
        at: &TexturePoint<'_>,
        outside: bool,
        visit: &mut impl FnMut(ResolvedPart<'a>),
    ) {
        self.each_of(scene, at, outside, 1.0, visit);
    }

    fn each_of<'a>(
        &self,
        scene: &'a impl MaterialEvalContext,
        at: &TexturePoint<'_>,
        outside: bool,
        outer: f64,
        visit: &mut impl FnMut(ResolvedPart<'a>),
    ) {
        let skipped = usize::from(self.first_is_remainder);
        let mut weights = [0.0; MAX_PARTS as usize];
        for (weight, part) in weights.iter_mut().zip(&self.parts).skip(skipped) {
            let c = scene.textures().color(part.weight, at);
            let w = (f64::from(c.r) + f64::from(c.g) + f64::from(c.b)) / 3.0;
            *weight = if w > 0.0 { w } else { 0.0 };
        }
        let sum: f64 = weights.iter().take(self.parts.len()).sum();
        // Weights that sum to more than 1 leave nothing for the first part; if all are 0, the first part gets
        // everything.
        let (total, remainder) = match self.first_is_remainder {
            true => (sum.max(1.0), (1.0 - sum).max(0.0)),
            false => (if sum > 0.0 { sum } else { 1.0 }, f64::from(sum <= 0.0)),
        };
        for (i, (part, weight)) in self.parts.iter().zip(&weights).enumerate() {
            let own = weight / total + if i == 0 { remainder } else { 0.0 };
            if own <= 0.0 {
                continue;
            }
            let weight = outer * own;
            match &scene.materials()[part.material.index()] {
                Material::Mix(inner) => inner.each_of(scene, at, outside, weight, visit),
                material => {
                    let present = part.cutout.is_none_or(|c| c.is_there(scene, at, outside));
                    visit(ResolvedPart { material, weight, present });
                }
            }
        }
    }

    /// Whether any of its materials has subsurface scattering. The scene's check bounds the nesting.
    pub(super) fn walks(&self, scene: &impl MaterialEvalContext) -> bool {
        self.parts
            .iter()
            .any(|p| scene.materials().get(p.material.index()).is_some_and(|m| m.has_subsurface(scene)))
    }

    /// The material that a ray hits on the outer or inner side, chosen by `u` within 0..1; `None` if the ray passes.
    pub fn choose<'a>(
        &self,
        scene: &'a impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        outside: bool,
        u: f64,
    ) -> Option<&'a OpenPbr> {
        let at = scene.texture_point(surface);
        let (mut below, mut chosen, mut last) = (0.0, None, None);
        self.each(scene, &at, outside, &mut |part| {
            let Material::OpenPbr(m) = part.material else { return };
            let weight =
                if part.present { part.weight * f64::from(m.desc.coverage_at(scene, &at)) } else { 0.0 };
            if weight > 0.0 {
                last = Some(&**m);
                if chosen.is_none() && u < below + weight {
                    chosen = last;
                }
                below += weight;
            }
        });
        // Rounding must not open holes.
        if self.shadow == ShadowKind::Opaque { chosen.or(last) } else { chosen }
    }

    /// Fraction of light that passes a crossing in `direction`.
    pub(super) fn shadow_tint(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        direction: DVec3,
    ) -> Spectrum {
        let at = scene.texture_point(surface);
        let outside = direction.dot(surface.ng) < 0.0;
        let mut sum = Spectrum::BLACK;
        self.each(scene, &at, outside, &mut |part| {
            let through = match (part.present, part.material.shadow()) {
                (true, ShadowKind::Opaque) => Spectrum::BLACK,
                (true, ShadowKind::Tinted) => part.material.shadow_tint(scene, surface, direction),
                (true, ShadowKind::None) | (false, _) => Spectrum::WHITE,
            };
            sum += through * part.weight as f32;
        });
        sum
    }

    /// The equivalent classic material. It has one colour, one highlight and one refraction: the weighted mean of the
    /// parts, with the highlight and refraction of the part that has most of them. Sets the shading normal of `surface`
    /// to that of the part with the greatest weight.
    pub fn as_classic(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &mut SurfaceInteraction,
        direction: DVec3,
    ) -> (Classic, Spectrum) {
        let at = scene.texture_point(surface);
        let outside = direction.dot(surface.ng) < 0.0;
        let mut out = ClassicMaterial { ka: 0.0, kd: 0.0, ks: 0.0, ior: 1.0, ..Default::default() }.prepare();
        out.shadow = self.shadow;
        out.k_local = Some(1.0);
        let (mut color, mut local, mut emitted) = (Spectrum::BLACK, 0.0, Spectrum::BLACK);
        let (mut heaviest, mut shiniest, mut clearest) = (0.0, 0.0, 0.0);
        let mut normal = surface.ns;
        let original = *surface;
        self.each(scene, &at, outside, &mut |part| {
            if !part.present {
                out.k_refract += part.weight;
                return;
            }
            let mut surface = original;
            let own = match part.material {
                Material::Classic(m) => {
                    if let Some(bump) = m.bump {
                        apply_bump_map(scene, &mut surface, bump);
                    }
                    // Already applied: the mix itself has no bump map.
                    Classic { bump: None, ..*m }
                }
                Material::Principled(m, _) => {
                    let (classic, light) = m.as_classic(scene, &mut surface, direction);
                    emitted += light * part.weight as f32;
                    classic
                }
                Material::OpenPbr(_) | Material::Mix(_) => return,
            };
            let left = (1.0 - own.k_reflect - own.k_refract).max(0.0);
            let weight = part.weight * own.k_local.unwrap_or(left);
            color += color_at(own.color, scene, &surface) * (weight * own.kd.max(own.ka)) as f32;
            local += weight * own.kd.max(own.ka);
            out.kd += weight * own.kd;
            out.ka += weight * own.ka;
            out.ks += weight * own.ks;
            if weight * own.ks > shiniest {
                shiniest = weight * own.ks;
                (out.exponent, out.dark) = (own.exponent, 0.0);
            }
            out.k_reflect += part.weight * own.k_reflect;
            out.k_refract += part.weight * own.k_refract;
            if part.weight * own.k_refract > clearest {
                clearest = part.weight * own.k_refract;
                (out.ior, out.fresnel) = (own.ior, own.fresnel);
            }
            if part.weight > heaviest {
                heaviest = part.weight;
                normal = surface.ns;
            }
        });
        if clearest == 0.0 {
            out.fresnel = Fresnel::Off;
        }
        let mean = if local > 0.0 { color * (1.0 / local) as f32 } else { Spectrum::BLACK };
        out.color = ColorSource::Constant(mean);
        surface.ns = normal;
        (out, emitted)
    }
}
