//! Scattering at a surface, as seen from any side.

use crate::bsdf::BsdfSample;
use crate::color::Spectrum;
use crate::integrator::path::vertex::{Vertex, coated, prepare};
use crate::material::Physical;
use crate::math::{DVec3, Ray};
use crate::scene::{Scene, SurfaceInteraction};

/// A surface, its material, and what is around it.
#[derive(Clone, Copy)]
pub(in crate::integrator::path) struct Seen<'a> {
    pub(in crate::integrator::path) scene: &'a Scene,
    pub(in crate::integrator::path) material: &'a Physical,
    pub(in crate::integrator::path) surface: &'a SurfaceInteraction,
    /// Index of refraction around the solid.
    pub(in crate::integrator::path) around: f64,
    /// The colour band that is left, if bands are bent differently.
    pub(in crate::integrator::path) band: Option<u8>,
}

impl Seen<'_> {
    /// Asks about the scattering of what arrives from the direction `toward`, a unit vector away from the surface.
    pub(super) fn from<T>(&self, toward: DVec3, ask: impl FnOnce(&Vertex<'_>) -> T) -> T {
        let Seen { scene, material, surface, around, band } = *self;
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

    /// The density with which what arrives from `from` is scattered to `to`.
    pub(super) fn density(&self, from: DVec3, to: DVec3) -> f64 {
        self.from(from, |v| v.eval_towards(to).1)
    }

    /// The BSDF for light from `light` that leaves towards `eye`, with the density of its way back, `eye` to `light`; times what path tracing counts it by: the cosine of the shading normal to the light
    /// and the terminator.
    pub(super) fn light_to_eye(&self, light: DVec3, eye: DVec3) -> (Spectrum, f64) {
        self.from(eye, |v| {
            let (f, pdf) = v.eval_towards(light);
            (f * v.cosine(light) as f32, pdf)
        })
    }

    /// What light from `light` weighs after it is scattered to where the sample says, `to`: the share of its power, with the correction for shading normals
    /// (Veach 1997, §5.3).
    pub(super) fn weight(&self, light: DVec3, to: DVec3, s: &BsdfSample) -> (Spectrum, f64) {
        let (ng, cos_to) = (self.surface.ng, to.dot(self.surface.ng).abs());
        let cos_light = light.dot(ng).abs();
        if s.lobe.is_delta {
            // By the sample, for radiance that goes the other way: without the change by eta², and with the cosines of the shading normal replaced.
            let weight = s.f * (s.wi.z.abs() * s.eta * s.eta / s.pdf) as f32;
            let (at_light, at_to) = self.from(light, |v| (v.cosine(light), s.wi.z.abs()));
            return (weight * (at_light * cos_to / (at_to * cos_light)) as f32, 1.0);
        }
        let (f, back) = self.light_to_eye(light, to);
        (f * (cos_to / (cos_light * s.pdf)) as f32, back)
    }
}
