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
//! pbrt computes with spectra, so both are computed by wavelengths.
//!
//! * Diffuse base: reflections between base and interface are a geometric series. With T the transmittance into
//!   the layer and r the reflectance of its inner side, both averaged over the hemisphere, an albedo ρ shows as
//!   ρ · gain / (1 − ρ · r), gain ∝ T².
//! * Conductor: 4096 quasi-random walks each give the colours that are reflected of light from all around and of light
//!   along the normal. OpenPBR's coat and the metal's reflectance along the normal are then scaled in turn by (pbrt's
//!   albedo / OpenPBR's albedo), which converges quickly.
//!
//! A result takes milliseconds and is reused for layers with nearly the same parameters.

use super::layer_colors::LayerColors;
use crate::scene_import::{Microfacets, incoming};
use crate::spectral::seen_values;
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
/// Corrections of each of the colours of a coated metal.
const ROUNDS: usize = 4;

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
    metal: BTreeMap<([u32; 8], u32), CoatedMetal>,
    pub(super) colors: LayerColors,
}

/// The colours of OpenPBR's coat and of the metal under it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CoatedMetal {
    pub(super) coat: Spectrum,
    pub(super) f0: Spectrum,
}

/// The reflectance of a conductor: OpenPBR's F82-tint, for each wavelength or for each of three colours.
#[derive(Clone, Debug)]
pub(super) struct Conductor {
    /// Reflectance along the normal, and the factor of its dip towards 82°.
    bands: Vec<[f64; 2]>,
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

    /// The colours with which a coated conductor of roughness `alpha` reflects as much light as pbrt's. `conductor` has
    /// the colours `metal`.
    pub(super) fn over_metal(
        &mut self,
        layer: Layer,
        metal: MetalColors,
        conductor: &Conductor,
        alpha: f64,
    ) -> Option<CoatedMetal> {
        let [a, b, c] = metal.f0.to_array().map(|v| step(f64::from(v)));
        let sizes = [layer.alpha, layer.ior, layer.thickness, alpha].map(step);
        let [d, e, f, g] = sizes;
        let key = ([a, b, c, step(f64::from(metal.tint.g)), d, e, f, g], layer.depth);
        if !self.metal.contains_key(&key) && self.metal.len() < MAX_METAL {
            self.metal.insert(key, layer.over_metal(metal, conductor, alpha));
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
    fn walked(&self, conductor: &Conductor, alpha: f64, from: fn(usize) -> DVec3) -> (f64, Spectrum) {
        let (boundary, base) = (Microfacets::new(self.alpha, true), Microfacets::new(alpha, true));
        let (mut first, mut rest) = (0.0, vec![0.0; conductor.bands.len()]);
        let mut color = Vec::new();
        for walk in 0..WALKS {
            let mut numbers = numbers(walk);
            let mut next = || numbers.unit();
            let mut wi = from(walk);
            let m = boundary.normal(wi, [next(), next()]);
            first += boundary.back(wi, m, self.ior).0;
            let (mut weight, mut mu) = boundary.through(wi, m, self.ior);
            color.clear();
            color.resize(rest.len(), 1.0);
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
                    conductor.reflect(wi.dot(m), &mut color);
                } else {
                    let m = boundary.normal(wi, u);
                    let out = weight * boundary.through(wi, m, 1.0 / self.ior).0;
                    for (sum, c) in rest.iter_mut().zip(&color) {
                        *sum += out * c;
                    }
                    let (share, down) = boundary.back(wi, m, 1.0 / self.ior);
                    (weight, mu) = (weight * share, down);
                }
            }
        }
        rest.iter_mut().for_each(|v| *v /= WALKS as f64);
        (first / WALKS as f64, conductor.seen(&rest))
    }

    fn over_metal(&self, metal: MetalColors, conductor: &Conductor, alpha: f64) -> CoatedMetal {
        let all_around = self.walked(conductor, alpha, from_all_around);
        let ahead = self.walked(conductor, alpha, from_ahead);
        let mut made = CoatedMetal { coat: Spectrum::WHITE, f0: metal.f0 };
        for round in 0..2 * ROUNDS {
            let bsdf = Bsdf::new(&PrincipledPoint {
                base_color: made.f0,
                base_metalness: 1.0,
                specular_color: metal.tint,
                specular_roughness: alpha.sqrt(),
                specular_multiple_scattering: false,
                coat_weight: 1.0,
                coat_color: made.coat,
                coat_roughness: self.alpha.sqrt(),
                coat_ior: self.ior,
                ..PrincipledPoint::default()
            });
            // In turn: the coat for light from all around, the metal for light along the normal.
            let (from, (first, wanted), color) = match round % 2 {
                0 => (from_all_around as fn(usize) -> DVec3, all_around, &mut made.coat),
                _ => (from_ahead as fn(usize) -> DVec3, ahead, &mut made.f0),
            };
            let here = albedo(&bsdf, from);
            let mut next = color.to_array();
            for ((c, wanted), here) in next.iter_mut().zip(wanted.to_array()).zip(here) {
                *c = (f64::from(*c) * f64::from(wanted) / (here - first).max(1e-6)).clamp(0.0, 1.0) as f32;
            }
            *color = next.into();
        }
        made
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

/// The direction of a walk whose light comes along the normal.
fn from_ahead(_: usize) -> DVec3 {
    incoming(0.999_999)
}

/// Fraction of the light from the directions `from(walk)` that a BSDF reflects.
fn albedo(bsdf: &Bsdf<'_>, from: fn(usize) -> DVec3) -> [f64; 3] {
    let mut sum = DVec3::ZERO;
    for walk in 0..WALKS {
        let mut numbers = numbers(walk);
        let mut next = || numbers.unit();
        if let Some(s) = bsdf.sample(from(walk), [next(), next(), next()]) {
            let f = DVec3::from(s.f.to_array().map(f64::from));
            sum += f * (s.wi.z.abs() / s.pdf);
        }
    }
    (sum / WALKS as f64).to_array()
}

impl Conductor {
    /// From reflectances along the normal and tints at 82°.
    pub(super) fn new(bands: impl IntoIterator<Item = (f64, f64)>) -> Conductor {
        let of = |(f0, tint): (f64, f64)| {
            let dip = schlick(f0, GRAZING) * (1.0 - tint) / (GRAZING * pow_int(1.0 - GRAZING, 6));
            [f0, dip]
        };
        Conductor { bands: bands.into_iter().map(of).collect() }
    }

    /// By the three colours.
    pub(super) fn of_colors(metal: MetalColors) -> Conductor {
        let colors = metal.f0.to_array().into_iter().zip(metal.tint.to_array());
        Conductor::new(colors.map(|(f0, tint)| (f64::from(f0), f64::from(tint))))
    }

    /// Multiplies the bands by the reflectance at a cosine.
    fn reflect(&self, mu: f64, bands: &mut [f64]) {
        let rise = pow_int(1.0 - mu, 5);
        let fall = mu * rise * (1.0 - mu);
        for (band, [f0, dip]) in bands.iter_mut().zip(&self.bands) {
            *band *= (f0 + (1.0 - f0) * rise - dip * fall).clamp(0.0, 1.0);
        }
    }

    /// The colour of its bands.
    fn seen(&self, bands: &[f64]) -> Spectrum {
        match *bands {
            [r, g, b] => Spectrum::new(r as f32, g as f32, b as f32),
            _ => seen_values(bands),
        }
    }
}

/// cos 82°.
const GRAZING: f64 = 1.0 / 7.0;

fn schlick(f0: f64, mu: f64) -> f64 {
    f0 + (1.0 - f0) * pow_int(1.0 - mu, 5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::{at_each_wavelength, metal, metal_at, metal_of_index, seen_in_daylight};

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
                let (first, rest) = layer(interface).walked(&Conductor::of_colors(silver), alpha, from);
                first + rest.to_array().map(f64::from).iter().sum::<f64>() / 3.0
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

    /// A mirror of gold under a smooth layer, along the normal. Per wavelength the reflections are a geometric series:
    /// r + (1 − r)² a² F / (1 − a² F r), where r = 0.04 and a² = exp(−2 · 0.01).
    #[test]
    fn smooth_coated_metals_are_mirrors_of_pbrts_colour() {
        let [eta, k] = metal("Au").unwrap();
        let at = |nm: f64| metal_at(eta.at(nm, false) / 1.5, k.at(nm, false) / 1.5);
        let (r, a2) = (0.04, exp(-0.02));
        let expected = seen_in_daylight(|nm| {
            let f = at(nm).0;
            r + (1.0 - r) * (1.0 - r) * a2 * f / (1.0 - a2 * f * r)
        });
        let colors = metal_of_index(&eta, &k, 1.5);
        let made = layer(0.0).over_metal(colors, &Conductor::new(at_each_wavelength(at)), 0.0);
        let bsdf = Bsdf::new(&PrincipledPoint {
            base_color: made.f0,
            base_metalness: 1.0,
            specular_color: colors.tint,
            specular_roughness: 0.0,
            coat_weight: 1.0,
            coat_color: made.coat,
            coat_ior: 1.5,
            ..PrincipledPoint::default()
        });
        let found = albedo(&bsdf, from_ahead);
        for (found, expected) in found.into_iter().zip(expected.to_array()) {
            // In red, where gold reflects nearly all light, no colour of the metal is bright enough for both directions.
            assert!((found / f64::from(expected) - 1.0).abs() < 0.008, "{found} {expected}");
        }
    }
}
