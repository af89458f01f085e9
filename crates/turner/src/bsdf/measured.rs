//! Measured BRDFs (Dupuy and Jakob 2018, "An adaptive parameterization for efficient material acquisition and
//! rendering"): tables over the numbers that sample the visible normals of the measured microfacets.
//!
//! With the half vector h, its numbers u and the numbers s by which u is sampled,
//!
//! ```text
//! f cos(wi) = rgb(s) ndf(u) / (4 sigma(wo))        pdf = luminance(s) vndf(u) / (∂h/∂u · 4 wo·h)
//! ```
//!
//! where the numbers of a normal are √(2θ/π) and φ/2π + 1/2, so that ∂h/∂u = 2π² u₀ sin θ.

use std::f64::consts::PI;
use std::sync::Arc;

use super::unlayered::Unlayered;
use super::{Bsdf, BsdfSample, Lobe, MIN_COSINE, Rgb, spectrum};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::elementary::sin_cos;
use crate::schema::MeasuredBrdf;

/// A measured BRDF, prepared.
#[derive(Clone, Debug)]
pub struct Measured {
    data: Arc<MeasuredBrdf>,
    roughness: f64,
    albedo: Rgb,
}

/// The density of half vectors per number becomes one of directions.
fn jacobian(wo: DVec3, wm: DVec3, number: f64) -> f64 {
    let sin = (1.0 - wm.z * wm.z).max(0.0).sqrt();
    (2.0 * PI * PI * number * sin).max(1e-6) * 4.0 * wo.dot(wm)
}

impl Measured {
    /// Prepares a measured BRDF.
    pub(crate) fn new(data: &Arc<MeasuredBrdf>) -> Measured {
        let mut made = Measured { data: Arc::clone(data), roughness: data.alpha().sqrt(), albedo: Rgb::ZERO };
        made.albedo = made.albedo_from(DVec3::Z);
        made
    }

    /// Fraction of the light that is reflected towards `wo`, by a regular grid of samples.
    fn albedo_from(&self, wo: DVec3) -> Rgb {
        const SIDE: u32 = 24;
        let at = |i| (f64::from(i) + 0.5) / f64::from(SIDE);
        let weight = |i: u32| {
            self.sample(wo, [0.5, at(i % SIDE), at(i / SIDE)])
                .map_or(Rgb::ZERO, |s| Rgb::from(s.f.to_array().map(f64::from)) * (s.wi.z / s.pdf))
        };
        let sum: Rgb = (0..SIDE * SIDE).map(weight).sum();
        sum / f64::from(SIDE * SIDE)
    }

    /// Whether it depends on the azimuth.
    pub(crate) fn is_anisotropic(&self) -> bool {
        !self.data.is_isotropic()
    }

    /// Approximate fraction of light from straight above that is reflected.
    pub(super) fn albedo(&self) -> Rgb {
        self.albedo
    }

    /// The same as a colour, each band within 0..=1.
    pub(crate) fn albedo_color(&self) -> Spectrum {
        spectrum(self.albedo.clamp(Rgb::ZERO, Rgb::ONE))
    }

    /// Roughness: 0 is a mirror, 1 is diffuse.
    pub(crate) fn roughness(&self) -> f64 {
        self.roughness
    }

    /// f and pdf; `wo` is above the surface.
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        if wi.z <= MIN_COSINE {
            return (Rgb::ZERO, 0.0);
        }
        let wm = (wo + wi).normalize_or(DVec3::Z);
        let view = self.data.seen_from(wo);
        let normal = self.data.numbers_of_normal(wm, &view);
        let (number, density) = self.data.invert(normal, &view);
        (self.data.value(number, normal, &view) / wi.z, density / jacobian(wo, wm, normal[0]))
    }

    /// Samples a direction; `u` as for [`Bsdf::sample`](super::Bsdf::sample).
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let view = self.data.seen_from(wo);
        let (normal, number, density) = self.data.sample([u[1], u[2]], &view);
        let [theta, phi] = self.data.angles_of_numbers(normal, &view);
        let ((sin, cos), (sin_phi, cos_phi)) = (sin_cos(theta), sin_cos(phi));
        let wm = view.mirrored(DVec3::new(sin * cos_phi, sin * sin_phi, cos));
        let wi = wm * (2.0 * wo.dot(wm)) - wo;
        if wi.z <= MIN_COSINE || wo.dot(wm) <= 0.0 {
            return None;
        }
        let pdf = density / jacobian(wo, wm, normal[0]);
        let f = self.data.value(number, normal, &view) / wi.z;
        let is_diffuse = self.roughness > 0.5;
        let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse };
        (pdf > 0.0).then(|| BsdfSample { wi: wi.normalize(), f: spectrum(f), pdf, lobe, eta: 1.0 })
    }
}

impl<'m> Bsdf<'m> {
    /// A measured BRDF.
    pub fn measured(tables: &'m Measured) -> Bsdf<'m> {
        let mut bsdf: Bsdf<'m> = Bsdf::lambert(Spectrum::BLACK);
        bsdf.unlayered = Some(Unlayered::Measured(tables));
        bsdf
    }
}
