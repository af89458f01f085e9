//! Colours of a thin film by interference (Belcour and Barla 2017, "A practical extension to microfacet theory for the modeling of
//! varying iridescence"): Airy's sum over the reflections inside the film, integrated over the eye's sensitivity in closed form.

use super::Rgb;
use super::fresnel::{amplitudes, refracted_cosine};
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

/// What the film lies on.
#[derive(Clone, Copy, Debug)]
pub(super) enum Under<'a> {
    /// A dielectric of this index.
    Dielectric(f64),
    /// A metal.
    Metal(&'a super::fresnel::Metal),
}

impl Film {
    /// Reflectance at a cosine outside.
    pub(super) fn reflectance(&self, mu: f64, under: Under<'_>) -> Rgb {
        let Some(inside) = refracted_cosine(mu, self.ior) else { return Rgb::ONE };
        let path = 2.0 * self.ior * self.thickness * inside;
        let (top_s, top_p) = amplitudes(mu, self.ior);
        let (bottom_s, bottom_p): (Rgb, Rgb);
        match under {
            Under::Dielectric(ior) => {
                let (s, p) = amplitudes(inside, ior / self.ior);
                (bottom_s, bottom_p) = (Rgb::splat(s), Rgb::splat(p));
            }
            // A metal reflects with its phase turned by half a wave, here at all angles.
            Under::Metal(metal) => {
                let r = metal.at(inside);
                let r = Rgb::new(r.x.sqrt(), r.y.sqrt(), r.z.sqrt());
                (bottom_s, bottom_p) = (-r, r);
            }
        }
        let sum = airy(top_s, bottom_s, path) + airy(top_p, bottom_p, path);
        (0.5 * sum).clamp(Rgb::ZERO, Rgb::ONE)
    }
}

/// Reflectance of one polarisation; signs of amplitudes are phases of half a wave. Equations 8 to 10 with real amplitudes.
fn airy(top: f64, bottom: Rgb, path: f64) -> Rgb {
    let (r12, r23) = (top * top, bottom * bottom);
    let t121 = 1.0 - r12;
    let amplitude = bottom * -top; // light inside meets the top with the opposite sign
    let rs = t121 * t121 * r23 / (Rgb::ONE - r12 * r23).max(Rgb::splat(1e-9));
    let mut sum = rs + r12;
    let mut order = rs - t121;
    for m in 1..=3 {
        order *= amplitude;
        sum += 2.0 * order * sensitivity(f64::from(m) * path);
    }
    sum
}

/// Fourier transform of the colour matching functions at an optical path difference in metres, in linear Rec. 709, 1 at 0. A sum
/// of Gaussians in XYZ, the paper's fit of CIE 1931.
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
    // Equal energy at all wavelengths is (1.2, 0.95, 0.91) in Rec. 709; the white of reflectances is (1, 1, 1).
    rgb / Rgb::new(1.205_368_753_180_286, 0.948_319_497_623_221, 0.910_009_650_014_116)
}
