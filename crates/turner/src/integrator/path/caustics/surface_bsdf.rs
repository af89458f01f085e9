//! Scattering at a surface, as seen from any side.

use std::f64::consts::FRAC_1_PI;

use crate::bsdf::{BsdfSample, Lobe, MIN_COSINE, sample_cosine};
use crate::color::Spectrum;
use crate::material::vertex::{Vertex, coated, prepare};
use crate::material::{OpenPbr, PlainBsdf};
use crate::math::{DVec3, Frame, Ray};
use crate::scene::{Scene, SurfaceInteraction};

/// A surface, its material, and what is around it.
#[derive(Clone, Copy)]
pub(in crate::integrator::path) struct SurfaceBsdf<'a> {
    pub(in crate::integrator::path) scene: &'a Scene,
    pub(in crate::integrator::path) material: &'a OpenPbr,
    pub(in crate::integrator::path) surface: &'a SurfaceInteraction,
    /// Index of refraction around the solid.
    pub(in crate::integrator::path) around: f64,
    /// The colour band that is left, if bands are bent differently.
    pub(in crate::integrator::path) band: Option<u8>,
}

impl SurfaceBsdf<'_> {
    /// Asks about the scattering of what arrives from the direction `toward`, a unit vector away from the surface.
    pub(super) fn from<T>(&self, toward: DVec3, ask: impl FnOnce(&Vertex<'_>) -> T) -> T {
        let SurfaceBsdf { scene, material, surface, around, band } = *self;
        let outside = toward.dot(surface.ng) > 0.0;
        let ray = Ray::new(surface.p, -toward);
        let index = material.dispersion.zip(band).map(|(indices, band)| indices[usize::from(band.min(2))]);
        let made;
        let bsdf = match (material.constant_bsdf(outside), index) {
            (Some(bsdf), None) if around == 1.0 => bsdf,
            (_, index) => {
                let index = index.unwrap_or(material.desc.specular_ior);
                made = material.bsdf_of_index(scene, surface, around, outside, index);
                &made
            }
        };
        let coated = coated(scene, &ray, material, surface, bsdf, outside);
        let bsdf = coated.as_ref().unwrap_or(bsdf);
        ask(&prepare(scene, &ray, material, surface, bsdf, outside))
    }

    /// The BRDF where it is Lambert's around the geometric normal: light paths are scattered there more often than anywhere else.
    #[inline]
    fn lambert(&self) -> Option<Spectrum> {
        match self.material.plain() {
            Some(PlainBsdf::Lambert(f)) if self.surface.ns == self.surface.ng => Some(*f),
            _ => None,
        }
    }

    /// Lambert's BRDF between two directions times the cosine of the normal to the first, and the density of the way back.
    #[inline]
    fn lambert_between(&self, f: Spectrum, light: DVec3, eye: DVec3) -> (Spectrum, f64) {
        let ng = self.surface.ng;
        let (a, b) = (light.dot(ng), eye.dot(ng));
        if (a > 0.0) != (b > 0.0) || !(a.abs() > MIN_COSINE && b.abs() > MIN_COSINE) {
            return (Spectrum::BLACK, 0.0);
        }
        (f * a.abs() as f32, a.abs() * FRAC_1_PI)
    }

    /// Whether light from `light` is scattered by any lobe that is not a mirror's.
    pub(super) fn is_smooth(&self, light: DVec3) -> bool {
        self.lambert().is_some() || self.from(light, |v| v.is_smooth())
    }

    /// The density with which what arrives from `from` is scattered to `to`.
    pub(super) fn density(&self, from: DVec3, to: DVec3) -> f64 {
        self.from(from, |v| v.eval_towards(to).1)
    }

    /// The BSDF for light from `light` that leaves towards `eye`, with the density of its way back, `eye` to `light`; times what path tracing counts it by: the cosine of the shading normal to the light
    /// and the terminator.
    pub(super) fn light_to_eye(&self, light: DVec3, eye: DVec3) -> (Spectrum, f64) {
        if let Some(f) = self.lambert() {
            return self.lambert_between(f, light, eye);
        }
        self.from(eye, |v| {
            let (f, pdf) = v.eval_towards(light);
            (f * v.cosine(light) as f32, pdf)
        })
    }

    /// Scatters light from `light`, by three numbers.
    pub(super) fn scatter(&self, light: DVec3, u: [f64; 3]) -> Option<Scattered> {
        let ng = self.surface.ng;
        if let Some(f) = self.lambert() {
            let cos = light.dot(ng).abs();
            let local = sample_cosine([u[1], u[2]]);
            if !(cos > MIN_COSINE && local.z > MIN_COSINE) {
                return None;
            }
            let to = Frame::from_z(if light.dot(ng) > 0.0 { ng } else { -ng }).to_world(local);
            let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
            let weight = f * std::f32::consts::PI;
            return Some(Scattered { to, lobe, pdf: local.z * FRAC_1_PI, weight, back: cos * FRAC_1_PI });
        }
        let (s, to, at_light) = self.from(light, |v| {
            let (s, to) = v.sample_in_scene(u)?;
            Some((s, to, v.cosine(light)))
        })?;
        let (weight, back) = self.weight(light, to, &s, at_light);
        Some(Scattered { to, lobe: s.lobe, pdf: s.pdf, weight, back })
    }

    /// What light from `light` weighs after it is scattered to where the sample says, `to`: the share of its power, with the correction for shading normals
    /// (Veach 1997, §5.3); `at_light` is the cosine of the shading normal to the light.
    fn weight(&self, light: DVec3, to: DVec3, s: &BsdfSample, at_light: f64) -> (Spectrum, f64) {
        let (ng, cos_to) = (self.surface.ng, to.dot(self.surface.ng).abs());
        let cos_light = light.dot(ng).abs();
        if s.lobe.is_delta {
            // By the sample, for radiance that goes the other way: without the change by eta², and with the cosines of the shading normal replaced.
            let weight = s.f * (s.wi.z.abs() * s.eta * s.eta / s.pdf) as f32;
            return (weight * (at_light * cos_to / (s.wi.z.abs() * cos_light)) as f32, 1.0);
        }
        let (f, back) = self.light_to_eye(light, to);
        (f * (cos_to / (cos_light * s.pdf)) as f32, back)
    }
}

/// Light that was scattered.
pub(super) struct Scattered {
    /// Where to: a unit vector.
    pub(super) to: DVec3,
    /// By which lobe.
    pub(super) lobe: Lobe,
    /// The density of the direction, per solid angle.
    pub(super) pdf: f64,
    /// The share of its power that is left.
    pub(super) weight: Spectrum,
    /// The density with which what comes back from there is scattered to where the light came from.
    pub(super) back: f64,
}
