//! Dispersion: glass that refracts colours differently.
//!
//! ```text
//!           \ |                Each colour band (R, G, B) has its own index of refraction.
//!  ----------\+---------
//!             |\ \ B           Reflection: one direction, the path keeps all bands.
//!             | \ \            Refraction: three directions, the path keeps one band.
//!             |  R  G
//! ```
//!
//! At a smooth surface the three BSDFs are sampled with the same random numbers. As long as they return the same
//! direction, the path keeps all bands. Otherwise, and at rough surfaces, the path continues with one band, chosen with
//! a probability proportional to the band's throughput, p_i = beta_i / (beta_R + beta_G + beta_B). The band's
//! throughput becomes beta_i / p_i = beta_R + beta_G + beta_B and the others become 0, so the expectation of each band
//! is that of a path traced for that band alone. This is unbiased; it costs colour noise where bands separate. A path
//! chooses a band only once.

use super::path_batch::{PathBatch, VertexInput};
use super::record::Record;
use super::shade::{FIRST_SET, MAX_VERTICES};
use crate::bsdf::BsdfSample;
use crate::color::Spectrum;
use crate::integrator::{Radiance, RayStats};
use crate::material::OpenPbr;
use crate::material::vertex::{coated, prepare};
use crate::scene::SurfaceInteraction;

/// The set of random numbers for the choice of a band, which a path makes once.
pub(super) const BAND_SET: u32 = FIRST_SET + 2 * MAX_VERTICES + 2;

/// A hit on a dispersive surface.
pub(super) struct DispersiveHit<'a> {
    pub(super) material: &'a OpenPbr,
    /// Index of refraction of each band.
    pub(super) indices: [f64; 3],
    pub(super) surface: &'a SurfaceInteraction,
    /// Index of refraction outside the solid.
    pub(super) exterior_ior: f64,
    pub(super) outside: bool,
}

impl<R: Record> PathBatch<'_, R> {
    /// Direct light at a dispersive surface, and the next ray.
    pub(super) fn disperse(
        &mut self,
        at: &VertexInput<'_>,
        prism: &DispersiveHit<'_>,
        pixel: &mut Radiance,
        stats: &mut RayStats,
    ) {
        let scene = self.scene;
        let &VertexInput { sample, ref ray, .. } = at;
        let DispersiveHit { material, indices, surface, exterior_ior, outside } = *prism;
        let bsdf = |band: u8| {
            let index = indices[usize::from(band.min(2))];
            let bsdf = material.bsdf_of_index(scene, surface, exterior_ior, outside, index);
            coated(scene, ray, material, surface, &bsdf, outside).unwrap_or(bsdf)
        };
        let path = &mut self.paths[sample as usize];
        if path.band.is_none() {
            let bsdfs = [bsdf(0), bsdf(1), bsdf(2)];
            if !bsdfs[0].has_smooth() {
                let vertices = bsdfs.each_ref().map(|b| prepare(scene, ray, material, surface, b, outside));
                let [u0, u1, u2, u3] = path.numbers.second();
                let samples = vertices.each_ref().map(|v| v.bsdf.sample([u2, u0, u1]));
                if let Some(s) = common_sample(&samples) {
                    self.follow(sample, &vertices[0], material, s, u3, stats);
                    return;
                }
                let Some(band) = path.choose_band() else { return };
                self.record.note(|r| r.dispersed(band, path.beta));
                let i = usize::from(band);
                if let Some(s) = samples[i] {
                    self.follow(sample, &vertices[i], material, s, u3, stats);
                }
                return;
            }
            let Some(band) = path.choose_band() else { return };
            self.record.note(|r| r.dispersed(band, path.beta));
        }
        let Some(band) = self.paths[sample as usize].band else { return };
        let bsdf = bsdf(band);
        let vertex = prepare(scene, ray, material, surface, &bsdf, outside);
        self.scatter(at, &vertex, material, bsdf.has_smooth(), pixel, stats);
    }
}

impl super::path_batch::Path {
    /// Keeps one band of the path; `None` if the throughput is 0 or non-finite.
    fn choose_band(&mut self) -> Option<u8> {
        let fractions = self.beta.to_array().map(|v| f64::from(v.max(0.0)));
        let sum: f64 = fractions.iter().sum();
        if !(sum > 0.0 && sum < f64::INFINITY) {
            return None;
        }
        let target = self.sampler.four(BAND_SET)[0] * sum;
        let band: u8 = match target {
            p if p < fractions[0] => 0,
            p if p < fractions[0] + fractions[1] || fractions[2] == 0.0 => 1,
            _ => 2,
        };
        // Rounding must not choose a black band.
        let band = if fractions[usize::from(band)] > 0.0 { band } else { 0 };
        let mut beta = [0.0; 3];
        beta[usize::from(band)] = sum as f32;
        self.beta = Spectrum::from(beta);
        self.band = Some(band);
        Some(band)
    }
}

/// One sample for all bands, if they agree in everything but the weight.
fn common_sample(samples: &[Option<BsdfSample>; 3]) -> Option<BsdfSample> {
    let [Some(r), Some(g), Some(b)] = samples else { return None };
    let same = |s: &BsdfSample| s.wi == r.wi && s.lobe == r.lobe && s.lobe.is_delta;
    let weight = |s: &BsdfSample, f: f32| f * (r.pdf / s.pdf) as f32;
    let f = Spectrum::new(r.f.r, weight(g, g.f.g), weight(b, b.f.b));
    (same(r) && same(g) && same(b)).then_some(BsdfSample { f, ..*r })
}
