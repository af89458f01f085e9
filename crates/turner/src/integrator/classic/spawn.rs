//! How a ray's weight is split at a surface, and the values of rays that are not traced.

use super::points::{PointBlock, get};
use super::radiance::{Task, Tree, Weights};
use super::record::{CutReason, RayKind, Record, Seen};
use super::{AtDepth, ClassicDesc, Combine, Miss};
use crate::color::Spectrum;
use crate::integrator::Radiance;
use crate::light::{BackgroundDesc, Light};
use crate::material::{Classic, Fresnel};
use crate::math::elementary::Exponent;
use crate::math::{DVec3, Ray, refract};
use crate::scene::Scene;

/// A candidate for a reflected or refracted ray.
pub(super) struct SecondaryRay {
    pub(super) kind: RayKind,
    /// Its weight at the surface.
    pub(super) weight: f64,
}

/// The state from which it is spawned.
pub(super) struct Spawn<'a, R> {
    pub(super) from: &'a Task,
    pub(super) tree: &'a mut Tree,
    pub(super) pixel: &'a mut Radiance,
    pub(super) record: &'a mut R,
}

impl ClassicDesc {
    /// Stores the coefficients of a material; terms that are switched off get 0.
    #[inline]
    pub(super) fn coefficients(&self, material: &Classic, b: &mut PointBlock, lane: usize) {
        b.ka.0[lane] = material.ka as f32;
        b.kd.0[lane] = if self.diffuse { material.kd } else { 0.0 };
        let ks = if self.highlights { material.ks } else { 0.0 };
        b.ks.0[lane] = ks;
        if ks > 0.0 {
            b.glossy |= 1 << lane;
            b.dark.0[lane] = material.dark;
            match material.exponent {
                Exponent::Whole(n) => {
                    b.exponent.0[lane] = f64::from_bits(u64::from(n));
                    b.exponent_bits |= n;
                }
                Exponent::Real(y) => {
                    b.exponent.0[lane] = y;
                    b.real_exponent |= 1 << lane;
                }
            }
        }
    }

    /// The weights of local, reflected and refracted colour, and the refracted direction if there is one.
    #[inline]
    pub(super) fn weights(
        &self,
        m: &Classic,
        depth: u32,
        b: &PointBlock,
        lane: usize,
    ) -> (Weights, Option<DVec3>) {
        let k_reflect = if self.reflection { m.k_reflect } else { 0.0 };
        let k_refract = if self.refraction { m.k_refract } else { 0.0 };
        if k_reflect == 0.0 && k_refract == 0.0 {
            return (Weights { local: m.k_local.unwrap_or(1.0), reflect: 0.0, refract: 0.0 }, None);
        }
        if self.at_depth == AtDepth::Local && depth >= self.max_depth {
            return (Weights { local: 1.0, reflect: 0.0, refract: 0.0 }, None);
        }
        let blend = |reflect: f64, refract: f64| {
            let local = m.k_local.unwrap_or(match self.combine {
                Combine::Add => 1.0,
                Combine::Blend => (1.0 - reflect - refract).max(0.0),
            });
            Weights { local, reflect, refract }
        };
        if k_refract == 0.0 && m.fresnel == Fresnel::Off {
            return (blend(k_reflect, 0.0), None);
        }
        let d = get(&b.d, lane);
        let n = b.facing(&b.ns, lane);
        let eta = if b.entering >> lane & 1 == 1 { 1.0 / m.ior } else { m.ior };
        let direction = if k_refract > 0.0 { refract(d, n, eta) } else { None };
        let (reflect, refracted) = match (m.fresnel, k_refract > 0.0 && direction.is_none()) {
            // Total internal reflection: the refracted fraction follows the mirror direction.
            (Fresnel::Off, true) => (k_reflect + k_refract, 0.0),
            (_, true) => (k_reflect.max(k_refract), 0.0),
            (Fresnel::Off, false) => (k_reflect, k_refract),
            (fresnel, false) => {
                let f = fresnel.reflectance((-d.dot(n)).clamp(0.0, 1.0), eta);
                (k_reflect * f, k_refract * (1.0 - f))
            }
        };
        (blend(reflect, refracted), direction)
    }

    /// Returns the task of a reflected or refracted ray. Beyond the depth limit it adds the replacement value and
    /// returns `None`.
    #[inline]
    pub(super) fn spawn<R: Record>(
        &self,
        scene: &Scene,
        secondary: SecondaryRay,
        direction: impl Fn() -> DVec3,
        at: Spawn<'_, R>,
    ) -> Option<Task> {
        let Spawn { from, tree, pixel, record } = at;
        let (kind, weight) = (secondary.kind, from.weight * secondary.weight);
        let depth = from.depth + 1;
        if depth > self.max_depth {
            let (seen, color) = match self.at_depth {
                AtDepth::Background => (Seen::Background, scene.background_radiance(direction())),
                AtDepth::Ambient => (Seen::Ambient, scene.ambient),
                AtDepth::Black | AtDepth::Local => {
                    record.note(|n| {
                        n.cut(kind, direction(), weight, CutReason::Depth, Seen::Nothing, None);
                    });
                    return None;
                }
            };
            let added = color * weight as f32;
            pixel.color += added;
            record.note(|n| n.cut(kind, direction(), weight, CutReason::Depth, seen, Some(added)));
            return None;
        }
        tree.spawned = tree.spawned.saturating_add(1);
        if tree.spawned > self.max_rays {
            record.note(|n| n.cut(kind, direction(), weight, CutReason::Count, Seen::Nothing, None));
            return None;
        }
        record.note(|n| n.spawned(kind));
        Some(Task { sample: from.sample, depth, weight, cone: from.cone, curvature: 0.0 })
    }

    /// A secondary ray. `length` is that of the camera's direction vector as the documents define it; reflection
    /// and refraction preserve it, and `epsilon` is a t in its units.
    #[inline]
    pub(super) fn leaving_ray(&self, origin: DVec3, direction: DVec3, length: f64) -> Ray {
        let mut ray = Ray::new(origin, direction);
        if self.epsilon > 0.0 {
            ray.t_min = self.epsilon * length;
        }
        ray
    }

    /// What every ray sees that hits nothing, if it is one colour.
    pub(super) fn plain_miss(&self, scene: &Scene) -> Option<Spectrum> {
        let BackgroundDesc { color, zenith, environment, transparent, .. } = &scene.background;
        let around = *environment && scene.lights.iter().any(|light| matches!(light, Light::Environment(_)));
        let plain = self.miss == Miss::Background && !self.light_seen && !transparent;
        (plain && zenith.is_none() && !around).then_some(*color)
    }

    pub(super) fn miss<R: Record>(
        &self,
        scene: &Scene,
        task: &Task,
        direction: impl Fn() -> DVec3,
        pixel: &mut Radiance,
        record: &mut R,
    ) {
        if self.light_seen {
            let mut seen = Spectrum::BLACK;
            let mut any = false;
            for light in &scene.lights[..] {
                if let Light::Directional(light) = light
                    && light.is_seen(direction())
                {
                    seen += light.intensity;
                    any = true;
                }
            }
            if any {
                let seen = seen * task.weight as f32;
                pixel.color += seen;
                record.note(|n| n.missed(Seen::Lights, Some(seen)));
                return;
            }
        }
        if task.depth == 0 && scene.background.transparent {
            pixel.alpha = 0.0;
            record.note(|n| n.missed(Seen::Transparent, None));
            return;
        }
        if self.miss == Miss::Background {
            let seen = scene.background_radiance(direction()) * task.weight as f32;
            pixel.color += seen;
            record.note(|n| n.missed(Seen::Background, Some(seen)));
        }
    }
}
