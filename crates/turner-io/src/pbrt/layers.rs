//! Layered materials: pbrt's `coateddiffuse` and `coatedconductor` as OpenPBR.
//!
//! ```text
//!      wi ↘   ↗ first reflection   ↗
//!   ════════════════════════════════════  rough dielectric interface: α, IOR
//!           ↘   ↗  ↘   ↗  ↘   ↗           absorbing medium: exp(−thickness / μ) per crossing
//!   ────────────────────────────────────  base: diffuse or conductor
//! ```
//!
//! pbrt finds what leaves the layer by random walks at render time (pbrt-v4, §14.3). OpenPBR has closed lobes
//! instead. So the import computes pbrt's reflectance once and chooses a colour with which OpenPBR reflects the
//! same amount; the shapes of the lobes may differ. As in pbrt, each reflection is single scattering at GGX
//! microfacets.
//!
//! * Diffuse base: reflections between base and interface are a geometric series. With T the transmittance into
//!   the layer and r the reflectance of its inner side, both averaged over the hemisphere, an albedo ρ shows as
//!   ρ · gain / (1 − ρ · r), gain ∝ T².
//! * Conductor: 4096 quasi-random walks give the reflected colour. The colour of OpenPBR's coat is then scaled
//!   twice by (pbrt's albedo / OpenPBR's albedo), which converges quickly.
//!
//! A result takes milliseconds and is reused for layers with nearly the same parameters.

use crate::scene_import::{Microfacets, incoming};
use std::collections::BTreeMap;
use turner::bsdf::{Bsdf, PrincipledPoint};
use turner::color::Spectrum;
use turner::material::metals::MetalColors;
use turner::math::DVec3;
use turner::math::elementary::{exp, pow_int};
use turner::sampler::{OwenSobol, SampleId, Stream};

/// Directions over the hemisphere.
const DIRECTIONS: usize = 16;
/// Random walks through a layer over a conductor.
const WALKS: usize = 4096;
/// Resolution of the parameters for reuse: steps per unit of α, IOR and thickness.
const STEPS: f64 = 1000.0;
/// Most layers that are computed, over diffuse bases and over conductors: each takes milliseconds.
const MAX_DIFFUSE: usize = 256;
const MAX_METAL: usize = 128;
/// A walk ends when its throughput is lower.
const LITTLE: f64 = 1e-4;

/// A dielectric layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layer {
    /// GGX α of its interface.
    pub(super) alpha: f64,
    /// Relative index of refraction, at least 1.
    pub(super) ior: f64,
    /// Optical thickness: exp(−thickness) passes at normal incidence.
    pub(super) thickness: f64,
    /// Most interfaces that light meets inside (pbrt's `maxdepth`).
    pub(super) depth: u32,
}

/// Computed results by rounded parameters.
#[derive(Default)]
pub(super) struct Layers {
    diffuse: BTreeMap<[u32; 3], (f64, f64)>,
    metal: BTreeMap<([u32; 8], u32), Spectrum>,
}

fn step(v: f64) -> u32 {
    (v * STEPS).round().clamp(0.0, 1e9) as u32
}

impl Layers {
    /// (gain, inner): a base colour of ρ · gain / (1 − ρ · inner) is as bright in Turner as a base of
    /// reflectance ρ in pbrt.
    pub(super) fn over_diffuse(&mut self, layer: Layer) -> Option<(f64, f64)> {
        let key = [layer.alpha, layer.ior, layer.thickness].map(step);
        if !self.diffuse.contains_key(&key) && self.diffuse.len() < MAX_DIFFUSE {
            self.diffuse.insert(key, layer.over_diffuse());
        }
        self.diffuse.get(&key).copied()
    }

    /// The coat colour over a conductor of roughness `alpha` that reflects as much light as pbrt's layer.
    pub(super) fn over_metal(&mut self, layer: Layer, metal: MetalColors, alpha: f64) -> Option<Spectrum> {
        let [a, b, c] = metal.f0.to_array().map(|v| step(f64::from(v)));
        let sizes = [layer.alpha, layer.ior, layer.thickness, alpha].map(step);
        let [d, e, f, g] = sizes;
        let key = ([a, b, c, step(f64::from(metal.tint.g)), d, e, f, g], layer.depth);
        if !self.metal.contains_key(&key) && self.metal.len() < MAX_METAL {
            self.metal.insert(key, layer.over_metal(metal, alpha));
        }
        self.metal.get(&key).copied()
    }
}

impl Layer {
    /// Transmittance from one side of the layer to the other at the cosine `mu`.
    fn passes(&self, mu: f64) -> f64 {
        exp(-self.thickness / mu.max(1e-6))
    }

    fn over_diffuse(&self) -> (f64, f64) {
        let microfacets = Microfacets::new(self.alpha, true);
        let inward = |mu: f64| {
            microfacets.mean(mu, |wi, m| {
                let (share, below) = microfacets.through(wi, m, self.ior);
                share * self.passes(below)
            })
        };
        let outside = |mu: f64| microfacets.mean(mu, |wi, m| microfacets.back(wi, m, self.ior).0);
        let inside = |mu: f64| {
            let again = microfacets.mean(mu, |wi, m| {
                let (share, down) = microfacets.back(wi, m, 1.0 / self.ior);
                share * self.passes(down)
            });
            self.passes(mu) * again
        };
        // The cosine-weighted mean: equal steps of μ², each at its centre.
        let over = |f: &dyn Fn(f64) -> f64| {
            let n = DIRECTIONS as f64;
            (0..DIRECTIONS).map(|i| f(((i as f64 + 0.5) / n).sqrt())).sum::<f64>() / n
        };
        let (transmitted, kept) = (over(&inward), 1.0 - over(&outside));
        // By reciprocity `transmitted` / η² of the light inside leaves. In Turner `kept` gets to the base and back.
        (transmitted * transmitted / (self.ior * self.ior * kept.max(1e-6)), over(&inside).min(0.999))
    }

    /// The reflectance for light from the directions `from(walk)`: by the interface alone, and by way of the
    /// conductor.
    fn walked(&self, metal: MetalColors, alpha: f64, from: fn(usize) -> DVec3) -> (f64, [f64; 3]) {
        let (boundary, base) = (Microfacets::new(self.alpha, true), Microfacets::new(alpha, true));
        let (mut first, mut rest) = (0.0, [0.0; 3]);
        for walk in 0..WALKS {
            let mut numbers = numbers(walk);
            let mut next = || numbers.unit();
            let mut wi = from(walk);
            let m = boundary.normal(wi, [next(), next()]);
            first += boundary.back(wi, m, self.ior).0;
            let (mut weight, mut mu) = boundary.through(wi, m, self.ior);
            let mut color = [1.0; 3];
            for turn in 0..self.depth {
                if weight < LITTLE {
                    break;
                }
                weight *= self.passes(mu);
                wi = incoming(mu);
                let u = [next(), next()];
                if turn % 2 == 0 {
                    let m = base.normal(wi, u);
                    let (share, up) = base.mirrored(wi, m);
                    (weight, mu) = (weight * share, up);
                    for (c, f) in color.iter_mut().zip(reflectance(metal, wi.dot(m))) {
                        *c *= f;
                    }
                } else {
                    let m = boundary.normal(wi, u);
                    let out = weight * boundary.through(wi, m, 1.0 / self.ior).0;
                    for (sum, c) in rest.iter_mut().zip(color) {
                        *sum += out * c;
                    }
                    let (share, down) = boundary.back(wi, m, 1.0 / self.ior);
                    (weight, mu) = (weight * share, down);
                }
            }
        }
        (first / WALKS as f64, rest.map(|v| v / WALKS as f64))
    }

    fn over_metal(&self, metal: MetalColors, alpha: f64) -> Spectrum {
        let (first, wanted) = self.walked(metal, alpha, from_all_around);
        let mut color = Spectrum::WHITE;
        for _ in 0..2 {
            let bsdf = Bsdf::new(&PrincipledPoint {
                base_color: metal.f0,
                base_metalness: 1.0,
                specular_color: metal.tint,
                specular_roughness: alpha.sqrt(),
                specular_multiple_scattering: false,
                coat_weight: 1.0,
                coat_color: color,
                coat_roughness: self.alpha.sqrt(),
                coat_ior: self.ior,
                ..PrincipledPoint::default()
            });
            let here = albedo(&bsdf);
            let mut next = color.to_array();
            for ((c, wanted), here) in next.iter_mut().zip(wanted).zip(here) {
                *c = (f64::from(*c) * wanted / (here - first).max(1e-6)).clamp(0.0, 1.0) as f32;
            }
            color = next.into();
        }
        color
    }
}

/// The random numbers of a walk.
fn numbers(walk: usize) -> Stream {
    OwenSobol::new(&SampleId { x: 0, y: 0, index: walk as u32, seed: 0 }).stream(0)
}

/// The direction of a walk's light: all walks together cover the hemisphere, cosine-weighted.
fn from_all_around(walk: usize) -> DVec3 {
    incoming(((walk as f64 + 0.5) / WALKS as f64).sqrt())
}

/// Fraction of uniform illumination that a BSDF reflects.
fn albedo(bsdf: &Bsdf) -> [f64; 3] {
    let mut sum = DVec3::ZERO;
    for walk in 0..WALKS {
        let mut numbers = numbers(walk);
        let mut next = || numbers.unit();
        if let Some(s) = bsdf.sample(from_all_around(walk), [next(), next(), next()]) {
            let f = DVec3::from(s.f.to_array().map(f64::from));
            sum += f * (s.wi.z.abs() / s.pdf);
        }
    }
    (sum / WALKS as f64).to_array()
}

/// Reflectance of the conductor (OpenPBR's F82-tint).
fn reflectance(metal: MetalColors, mu: f64) -> [f64; 3] {
    let schlick = |f0: f64, mu: f64| f0 + (1.0 - f0) * pow_int(1.0 - mu, 5);
    let grazing = 1.0 / 7.0;
    let at = |f0: f32, tint: f32| {
        let (f0, tint) = (f64::from(f0), f64::from(tint));
        let dip = schlick(f0, grazing) * (1.0 - tint) / (grazing * pow_int(1.0 - grazing, 6));
        (schlick(f0, mu) - dip * mu * pow_int(1.0 - mu, 6)).clamp(0.0, 1.0)
    };
    let (f0, tint) = (metal.f0, metal.tint);
    [at(f0.r, tint.r), at(f0.g, tint.g), at(f0.b, tint.b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::{metal, metal_of_index};

    fn layer(roughness: f64) -> Layer {
        Layer { alpha: roughness.sqrt(), ior: 1.5, thickness: 0.01, depth: 10 }
    }

    /// Reflectance of pbrt-v4 under uniform illumination, along the normal and at 60°, averaged over the colours.
    #[test]
    fn coated_metals_are_as_bright_as_pbrts() {
        let [eta, k] = metal("Ag").unwrap();
        let silver = metal_of_index(&eta, &k, 1.5);
        let mut bad = String::new();
        for (interface, conductor, ahead, aslant) in [
            (0.0, 0.0, 0.9150, 0.9115),
            (0.2, 0.0, 0.6769, 0.4523),
            (0.5, 0.0, 0.4894, 0.3452),
            (0.0, 0.2, 0.5008, 0.4852),
            (0.2, 0.2, 0.3701, 0.3304),
        ] {
            let mean = |from: fn(usize) -> DVec3| {
                let alpha = f64::sqrt(conductor);
                let (first, rest) = layer(interface).walked(silver, alpha, from);
                first + rest.iter().sum::<f64>() / 3.0
            };
            let found = [mean(|_| incoming(0.999_999)), mean(|_| incoming(0.5))];
            for (found, expected) in found.into_iter().zip([ahead, aslant]) {
                // This many walks leave noise of half a percent.
                if (found / expected - 1.0f64).abs() > 0.015 {
                    bad += &format!("{interface} over {conductor}: {found:.4} for {expected}\n");
                }
            }
        }
        assert!(bad.is_empty(), "\n{bad}");
    }
}
