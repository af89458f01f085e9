//! The colour of a dielectric's specular reflection, after OpenPBR or after glTF.
//!
//! ```text
//!   R │                     OpenPBR: the colour multiplies Fresnel's reflectance F at all angles
//!   1 │            ..:      glTF (KHR_materials_specular): it multiplies F₀ up to 1, F₉₀ stays white:
//!     │          .:
//!  F₀c│──────..:'             R = w (F₀c + (1 − F₀c) s),   F₀c = min(c F₀, 1)
//!     └────────────── θ       s = (F − F₀) / (1 − F₀), 0 at normal incidence, 1 at grazing
//! ```
//!
//! glTF's curve s is Schlick's (1 − µ)⁵; here it is that of F itself, so a white colour of weight 1 is a plain dielectric.
//! Both are affine in F: R = tint · F + lift.

use super::{PrincipledPoint, Rgb, color, fresnel, unit};

/// The index whose curve a dielectric of index 0 has: glTF's default. Index 0 is F₀ = 1 (KHR_materials_ior).
const DEFAULT_IOR: f64 = 1.5;
/// Above this F₀ an index has the curve of the default, too: its own hardly rises towards grazing angles.
const MOST_F0: f64 = 0.5;

/// Reflectance of a dielectric by colour band as a function of Fresnel's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Specular {
    /// Factor of Fresnel's reflectance.
    pub(super) tint: Rgb,
    /// What is added to it; 0 for OpenPBR.
    pub(super) lift: Rgb,
    /// glTF: what glass does not reflect in the strongest band, it transmits in all bands.
    gltf: bool,
}

impl Specular {
    /// For the relative index `index` (inside over outside). Also the index whose curve the reflectance follows.
    pub(super) fn new(p: &PrincipledPoint, index: f64) -> (Specular, f64) {
        if !p.gltf_specular {
            return (Specular { tint: color(p.specular_color), lift: Rgb::ZERO, gltf: false }, index);
        }
        let f0 = if index > 0.0 { fresnel::f0(index) } else { 1.0 };
        let curve = if f0 < MOST_F0 { index } else { DEFAULT_IOR };
        let weight = unit(p.specular_weight);
        let factors = p.specular_color.to_array().map(|c| if c > 0.0 { f64::from(c.min(1e9)) } else { 0.0 });
        let normal = (Rgb::from(factors) * f0).min(Rgb::ONE);
        let least = fresnel::f0(curve);
        let scale = weight / (1.0 - least);
        (
            Specular {
                tint: (Rgb::ONE - normal) * scale,
                lift: (normal - Rgb::splat(least)) * scale,
                gltf: true,
            },
            curve,
        )
    }

    /// Whether it reflects anything at an index other than 1.
    pub(super) fn reflects(&self) -> bool {
        !self.gltf || self.tint != Rgb::ZERO || self.lift != Rgb::ZERO
    }

    /// Whether it is Fresnel's reflectance itself, or OpenPBR's factor of it.
    pub(super) fn is_plain(&self) -> bool {
        !self.gltf || self.lift == Rgb::ZERO && self.tint == Rgb::ONE
    }

    /// Whether anything is added to the factor of Fresnel's reflectance.
    pub(super) fn is_lifted(&self) -> bool {
        self.lift != Rgb::ZERO
    }

    /// Reflectance where Fresnel's is `f`.
    pub(super) fn at(&self, f: Rgb) -> Rgb {
        if self.is_lifted() { (f * self.tint + self.lift).clamp(Rgb::ZERO, Rgb::ONE) } else { f * self.tint }
    }

    /// Reflectance of glass from outside, and the part that it does not transmit, which is its reflectance from inside.
    pub(super) fn of_glass(&self, f: Rgb) -> (Rgb, Rgb) {
        let outside = self.at(f);
        (outside, if self.is_plain() { f } else { Rgb::splat(outside.max_element()) })
    }

    /// Directional albedo in the strongest band: `f` is that with Fresnel's reflectance, `white` that with reflectance 1.
    pub(super) fn most(&self, f: Rgb, white: impl FnOnce() -> f64) -> f64 {
        let tinted = self.tint * f;
        let all = if self.is_lifted() { tinted + self.lift * white() } else { tinted };
        all.max_element().clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Bsdf;
    use crate::color::Spectrum;
    use crate::testing::{albedo, direction};

    fn point(color: f32, weight: f64) -> PrincipledPoint {
        PrincipledPoint {
            gltf_specular: true,
            base_color: Spectrum::BLACK,
            specular_color: Spectrum::new(color, 0.5 * color, 0.0),
            specular_weight: weight,
            specular_roughness: 0.0,
            ..PrincipledPoint::default()
        }
    }

    /// F₀ and F₉₀ of KHR_materials_specular: min(0.04 c, 1) w and w.
    #[test]
    fn gltf_reflects_its_colour_at_normal_incidence_and_white_at_grazing() {
        for color in [0.0, 1.0, 5.0, 10.0, 25.0, 100.0] {
            for weight in [1.0, 0.5, 0.0] {
                let bsdf = Bsdf::new(&point(color, weight));
                let normal = albedo(&bsdf, direction(1.0, 0.0), 64);
                let expected = [color, 0.5 * color, 0.0].map(|c| (0.04 * f64::from(c)).min(1.0) * weight);
                for (band, expected) in normal.into_iter().zip(expected) {
                    assert!((band - expected).abs() < 1e-6, "{color} {weight}: {normal:?}");
                }
                let grazing = albedo(&bsdf, direction(1e-5, 0.0), 64);
                assert!(grazing.iter().all(|v| (v - weight).abs() < 1e-3), "{color} {weight}: {grazing:?}");
            }
        }
    }

    /// Of white light on a white base nothing is lost: what the strongest band reflects, the base does not receive.
    #[test]
    fn gltf_gives_the_base_what_the_strongest_band_leaves() {
        for roughness in [0.0, 0.3, 1.0] {
            for color in [0.0, 1.0, 8.0, 25.0] {
                let grey = PrincipledPoint {
                    base_color: Spectrum::WHITE,
                    specular_color: Spectrum::grey(color),
                    specular_roughness: roughness,
                    ..point(1.0, 0.9)
                };
                for mu in [1.0, 0.5, 0.1] {
                    let all = albedo(&Bsdf::new(&grey), direction(mu, 0.3), 30_000);
                    assert!((all[1] - 1.0).abs() < 2e-3, "{roughness} {color} {mu}: {all:?}");
                }
            }
        }
    }

    /// A metal has no dielectric reflection to change.
    #[test]
    fn gltf_leaves_metal_unchanged() {
        let metal = PrincipledPoint { base_metalness: 1.0, ..PrincipledPoint::default() };
        let other = PrincipledPoint { base_metalness: 1.0, base_color: metal.base_color, ..point(7.0, 0.2) };
        let other = PrincipledPoint { specular_roughness: metal.specular_roughness, ..other };
        let (wo, wi) = (direction(0.4, 0.0), direction(0.6, 2.8));
        assert_eq!(Bsdf::new(&metal).eval_pdf(wo, wi), Bsdf::new(&other).eval_pdf(wo, wi));
    }

    /// Index 0 is F₀ = 1: the colour is the reflectance at normal incidence (KHR_materials_ior).
    #[test]
    fn gltf_index_0_reflects_the_colour() {
        let p = PrincipledPoint { specular_ior: 0.0, ..point(0.6, 1.0) };
        let all = albedo(&Bsdf::new(&p), direction(1.0, 0.0), 64);
        for (band, expected) in all.into_iter().zip([0.6, 0.3, 0.0]) {
            assert!((band - expected).abs() < 1e-6, "{all:?}");
        }
    }
}
