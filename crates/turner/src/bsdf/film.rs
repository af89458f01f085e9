//! Thin-film interference (Belcour and Barla 2017, "A practical extension to microfacet theory for the modeling of
//! varying iridescence"): Airy's sum over the reflections inside the film, integrated over the CIE colour matching
//! functions in closed form.
//!
//! ```text
//!      \   /   /   /       optical path difference of neighbouring orders: 2 n d cos θ, θ inside
//!   ----\-/-\-/-\-/----    top, amplitude r12
//!   film \   /   /    d
//!   ======\=/=\=/======    base, amplitude r23
//! ```

use super::Rgb;
use super::fresnel::{Metal, amplitudes, dielectric, refracted_cosine};
use crate::math::elementary::{cos, exp};
use std::f64::consts::PI;

/// A film in air on a base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Film {
    /// Index of refraction.
    pub(super) ior: f64,
    /// Thickness in metres.
    pub(super) thickness: f64,
}

/// Tabulated cosines: µ = k / 11.
const ANGLES: usize = 12;

/// What a film adds to the reflectance of a base, tabulated over the cosine and interpolated linearly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tint([[f32; 3]; ANGLES]);

impl Tint {
    /// A base without film.
    pub(super) const NONE: Tint = Tint([[0.0; 3]; ANGLES]);

    /// The addition at a cosine outside the film.
    pub(super) fn at(&self, mu: f64) -> Rgb {
        let x = mu.clamp(0.0, 1.0) * (ANGLES - 1) as f64;
        let k = (x as usize).min(ANGLES - 2);
        let node = |k: usize| Rgb::from(self.0[k].map(f64::from));
        node(k).lerp(node(k + 1), x - k as f64)
    }
}

impl Film {
    /// The additions to a dielectric of relative index `index` and to a metal.
    pub(super) fn tints(&self, index: f64, metal: &Metal, weight: f64) -> (Tint, Tint) {
        let (mut on_dielectric, mut on_metal) = (Tint::NONE, Tint::NONE);
        for k in 0..ANGLES {
            let mu = k as f64 / (ANGLES - 1) as f64;
            let Some(inside) = refracted_cosine(mu, self.ior) else { continue };
            let path = 2.0 * self.ior * self.thickness * inside;
            let sensitivities = [sensitivity(path), sensitivity(2.0 * path)];
            let top = amplitudes(mu, self.ior);
            let difference = |bottom: (Rgb, Rgb), plain: Rgb| {
                let sum = airy(top.0, bottom.0, &sensitivities) + airy(top.1, bottom.1, &sensitivities);
                let added = ((0.5 * sum).clamp(Rgb::ZERO, Rgb::ONE) - plain) * weight;
                added.to_array().map(|v| v as f32)
            };
            // A perfect mirror stays one under a film.
            if index.is_finite() {
                let (s, p) = amplitudes(inside, index / self.ior);
                let plain = Rgb::splat(dielectric(mu, index));
                on_dielectric.0[k] = difference((Rgb::splat(s), Rgb::splat(p)), plain);
            }
            // A metal reflects with a phase shift of half a wavelength, here at all angles.
            let r = metal.colour(inside);
            let r = Rgb::new(r.x.sqrt(), r.y.sqrt(), r.z.sqrt());
            on_metal.0[k] = difference((-r, r), metal.colour(mu));
        }
        (on_dielectric, on_metal)
    }
}

/// Reflectance of one polarisation. Signs of the amplitudes are phases of half a wavelength. Equations 8 to 10 with
/// real amplitudes; `sensitivities` are those of the first two orders' path differences.
fn airy(top: f64, bottom: Rgb, sensitivities: &[Rgb; 2]) -> Rgb {
    let (r12, r23) = (top * top, bottom * bottom);
    let t121 = 1.0 - r12;
    let amplitude = bottom * -top; // from inside, the top's amplitude has the opposite sign
    let rs = t121 * t121 * r23 / (Rgb::ONE - r12 * r23).max(Rgb::splat(1e-9));
    let mut sum = rs + r12;
    let mut order = rs - t121;
    for sensitivity in sensitivities {
        order *= amplitude;
        sum += 2.0 * order * *sensitivity;
    }
    sum
}

/// Fourier transform of the colour matching functions at an optical path difference in metres, in linear Rec. 709, 1 at
/// 0. A sum of Gaussians in XYZ, the paper's fit of CIE 1931.
fn sensitivity(path: f64) -> Rgb {
    let phase = 2.0 * PI * path;
    let gauss = |weight: f64, position: f64, variance: f64| {
        weight * (2.0 * PI * variance).sqrt() * cos(position * phase) * exp(-variance * phase * phase)
    };
    let x = gauss(5.4856e-13, 1.6810e6, 4.3278e9) + gauss(9.7470e-14, 2.2399e6, 4.5282e9);
    let y = gauss(4.4201e-13, 1.7953e6, 9.3046e9);
    let z = gauss(5.2481e-13, 2.2084e6, 6.6121e9);
    let (x, y, z) = (x / 1.0685e-7, y / 1.0685e-7, z / 1.0685e-7);
    let rgb = Rgb::new(
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    );
    // The equal-energy spectrum is (1.2, 0.95, 0.91) in Rec. 709; white reflectance is (1, 1, 1).
    rgb / Rgb::new(1.205_368_753_180_286, 0.948_319_497_623_221, 0.910_009_650_014_116)
}
