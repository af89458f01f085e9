//! Clear layers as pbrt counts them: a rough boundary that follows light to one microfacet alone, over a base, with what absorbs between the two.
//! pbrt finds by random walks what comes out; here it is known beforehand how much that is, and the likeness here is made as bright.

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
/// Walks through a layer over metal.
const WALKS: usize = 4096;
/// Steps of widths, indices and thicknesses that are told apart, per unit.
const STEPS: f64 = 1000.0;
/// Most layers over diffuse bases and over metals that are computed: each takes milliseconds.
const MAX_DIFFUSE: usize = 256;
const MAX_METAL: usize = 128;
/// A walk that carries less than that ends.
const LITTLE: f64 = 1e-4;

/// A clear layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layer {
    /// Width of its boundary's microfacets.
    pub(super) alpha: f64,
    /// Index of refraction over that outside, at least 1.
    pub(super) ior: f64,
    /// How much of it light goes through head-on: exp(−thickness) is left.
    pub(super) thickness: f64,
    /// How many boundaries light is followed to inside.
    pub(super) depth: u32,
}

/// What was computed, by layers that are nearly the same.
#[derive(Default)]
pub(super) struct Layers {
    diffuse: BTreeMap<[u32; 3], (f64, f64)>,
    metal: BTreeMap<([u32; 8], u32), Spectrum>,
}

fn step(v: f64) -> u32 {
    (v * STEPS).round().clamp(0.0, 1e9) as u32
}

impl Layers {
    /// Of a base of diffuse reflectance ρ, ρ · gain / (1 − ρ · inner) has the brightness here that ρ has in pbrt.
    pub(super) fn over_diffuse(&mut self, layer: Layer) -> Option<(f64, f64)> {
        let key = [layer.alpha, layer.ior, layer.thickness].map(step);
        if !self.diffuse.contains_key(&key) && self.diffuse.len() < MAX_DIFFUSE {
            self.diffuse.insert(key, layer.over_diffuse());
        }
        self.diffuse.get(&key).copied()
    }

    /// The colour that a coat here has over a metal of width `alpha`, so that as much light comes back as in pbrt.
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
    /// What gets on from one side of the layer to the other in a direction.
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
        // Over the square of the cosine in even steps, each at its middle.
        let over = |f: &dyn Fn(f64) -> f64| {
            let n = DIRECTIONS as f64;
            (0..DIRECTIONS).map(|i| f(((i as f64 + 0.5) / n).sqrt())).sum::<f64>() / n
        };
        let (transmitted, kept) = (over(&inward), 1.0 - over(&outside));
        // By reciprocity as much gets out, times η². Here `kept` gets to the base and back from it.
        (transmitted * transmitted / (self.ior * self.ior * kept.max(1e-6)), over(&inside).min(0.999))
    }

    /// What comes back of light from directions, by number of the walk: at the boundary, and from the metal.
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

/// Where a walk's light comes from: over all walks, from all around, as a surface meets it.
fn from_all_around(walk: usize) -> DVec3 {
    incoming(((walk as f64 + 0.5) / WALKS as f64).sqrt())
}

/// Share of light from all around that comes back.
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

/// What the metal reflects (F82-tint, as here).
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

    /// Seen along the normal and at 60° by pbrt-v4 under light from all around, the mean of the colours.
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
                // So many walks leave noise of half a percent.
                if (found / expected - 1.0f64).abs() > 0.015 {
                    bad += &format!("{interface} over {conductor}: {found:.4} for {expected}\n");
                }
            }
        }
        assert!(bad.is_empty(), "\n{bad}");
    }
}
