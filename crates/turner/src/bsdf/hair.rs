//! Hair and fur: the scattering of a whole fibre, a rough dielectric cylinder with tilted scales (Chiang, Bitterli, Tappan
//! and Burley 2016, "A practical and controllable hair and fur model for production path tracing"; Pharr, "The
//! implementation of a hair scattering model").
//!
//! ```text
//!        z ↑  wo              R     reflected by the surface
//!      ___/|\_____            TT    through the fibre
//!     (    |   y →  h         TRT   through it, reflected inside once
//!      ‾‾‾‾‾‾‾‾‾‾‾            rest  all further reflections, the same in all azimuths
//!      x along the hair, θ from the plane across it, φ around it
//! ```
//!
//! Each of the four lobes is a product of three functions: M of the angles θ along the hair, N of the difference of the
//! azimuths φ, and the attenuation A of a smooth fibre that is hit at the offset h from its axis, −1..=1 towards +y. M and N
//! are normalized, and the sum of A is 1 without absorption, so that no light is lost. The fibre is a point: light leaves it
//! where it arrived, in all directions of the sphere.
//!
//! The function is a density for each direction: the factor |wi.z| of the path weight, which has no meaning for a fibre,
//! cancels with a divisor in f.

use std::f64::consts::{PI, TAU};

use super::fresnel::dielectric;
use super::mixture::MIN_COSINE;
use super::unlayered::Unlayered;
use super::{Bsdf, BsdfSample, Lobe, Rgb, spectrum};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::elementary::{asin, atan2, exp, ln, pow_int, sin_cos, sin_cos_turns};
use crate::math::radians;

/// The parameters of hair at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairPoint {
    /// Absorption inside the fibre, per radius of the fibre.
    pub sigma_a: [f64; 3],
    /// Offset of the ray from the axis of the fibre towards +y, in radii, −1..=1.
    pub h: f64,
    /// Roughness along the fibre, 0..=1.
    pub beta_m: f64,
    /// Roughness around the fibre, 0..=1.
    pub beta_n: f64,
    /// Tilt of the scales in degrees.
    pub alpha: f64,
    /// Index of refraction of the fibre.
    pub ior: f64,
}

/// Smaller roughnesses are clamped to this one: narrower lobes are lost to rounding.
const MIN_ROUGHNESS: f64 = 0.02;
/// Lobes: R, TT, TRT and the rest.
const LOBES: usize = 4;

/// A fibre as it is hit at one offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hair {
    sigma_a: Rgb,
    h: f64,
    ior: f64,
    /// Variances along the fibre: of TT, R, and TRT and the rest.
    v: [f64; 3],
    /// Scale of the logistic distribution around the fibre.
    s: f64,
    /// Sine and cosine of the tilt of the scales; of twice and of four times the tilt.
    tilt: [(f64, f64); 3],
}

/// What depends on wo alone.
struct Seen {
    /// Sine, cosine and azimuth of wo.
    sin: f64,
    cos: f64,
    phi: f64,
    /// The azimuths of incidence and refraction at the surface of the fibre.
    gamma_o: f64,
    gamma_t: f64,
    /// Attenuation of the lobes, and the probabilities with which they are sampled.
    a: [Rgb; LOBES],
    p: [f64; LOBES],
}

impl Hair {
    pub(super) fn new(p: &HairPoint) -> Hair {
        let unit = |v: f64| if v > MIN_ROUGHNESS { v.min(1.0) } else { MIN_ROUGHNESS };
        let (m, n) = (unit(p.beta_m), unit(p.beta_n));
        // Roughness to variance, and to the scale of the logistic distribution (§4.1 and §4.2 of the paper).
        let deviation = 0.726 * m + 0.812 * m * m + 3.7 * pow_int(m, 20);
        let v = deviation * deviation;
        let s = (PI / 8.0).sqrt() * (0.265 * n + 1.194 * n * n + 5.372 * pow_int(n, 22));
        let alpha = radians(if p.alpha.is_finite() { p.alpha } else { 0.0 });
        let absorption = p.sigma_a.map(|v| if v > 0.0 { v.min(1e6) } else { 0.0 });
        let h = if p.h.is_finite() { p.h.clamp(-1.0, 1.0) } else { 0.0 };
        let ior = if p.ior.is_finite() { p.ior.clamp(1.0001, 100.0) } else { 1.55 };
        let tilt = [alpha, 2.0 * alpha, 4.0 * alpha].map(sin_cos);
        Hair { sigma_a: Rgb::from(absorption), h, ior, v: [0.25 * v, v, 4.0 * v], s, tilt }
    }

    fn seen(&self, wo: DVec3) -> Seen {
        let sin = wo.x.clamp(-1.0, 1.0);
        let cos = (1.0 - sin * sin).max(0.0).sqrt();
        let a = self.attenuations(sin, cos);
        let mut p = a.map(|a| a.element_sum());
        let sum: f64 = p.iter().sum();
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        p.iter_mut().for_each(|p| *p *= scale);
        let gamma_t = asin((self.h / self.index_across(sin, cos)).clamp(-1.0, 1.0));
        Seen { sin, cos, phi: atan2(wo.z, wo.y), gamma_o: asin(self.h), gamma_t, a, p }
    }

    /// The index of refraction as a ray at the angle θ meets it in the plane across the fibre (Marschner et al. 2003).
    fn index_across(&self, sin: f64, cos: f64) -> f64 {
        (self.ior * self.ior - sin * sin).max(0.0).sqrt() / cos.max(1e-9)
    }

    /// Attenuation of the lobes.
    fn attenuations(&self, sin: f64, cos: f64) -> [Rgb; LOBES] {
        let sin_t = sin / self.ior;
        let cos_t = (1.0 - sin_t * sin_t).max(0.0).sqrt();
        let sin_gamma = self.h / self.index_across(sin, cos);
        let cos_gamma = (1.0 - sin_gamma * sin_gamma).max(0.0).sqrt();
        let length = 2.0 * cos_gamma / cos_t;
        let through = Rgb::from((self.sigma_a * -length).to_array().map(exp));
        let f = dielectric(cos * (1.0 - self.h * self.h).max(0.0).sqrt(), self.ior);
        let once = through * ((1.0 - f) * (1.0 - f));
        let twice = once * through * f;
        // The sum of a geometric series; without absorption and at grazing incidence nothing enters.
        let rest = twice * through * f / (Rgb::ONE - through * f).max(Rgb::splat(1e-12));
        [Rgb::splat(f), once, twice, rest]
    }

    /// Sine and cosine of wo tilted as the scales tilt the lobe.
    fn tilted(&self, lobe: usize, seen: &Seen) -> (f64, f64) {
        let (sin, cos) = (seen.sin, seen.cos);
        let [(s1, c1), (s2, c2), (s4, c4)] = self.tilt;
        let (sin, cos) = match lobe {
            0 => (sin * c2 - cos * s2, cos * c2 + sin * s2),
            1 => (sin * c1 + cos * s1, cos * c1 - sin * s1),
            2 => (sin * c4 + cos * s4, cos * c4 - sin * s4),
            _ => (sin, cos),
        };
        (sin, cos.abs())
    }

    /// Variance of a lobe along the fibre.
    fn variance(&self, lobe: usize) -> f64 {
        match lobe {
            0 => self.v[1],
            1 => self.v[0],
            _ => self.v[2],
        }
    }

    /// Difference of the azimuths of a ray through a smooth fibre.
    fn azimuth(lobe: usize, seen: &Seen) -> f64 {
        let p = lobe as f64;
        2.0 * p * seen.gamma_t - 2.0 * seen.gamma_o + p * PI
    }

    /// The densities of the lobes at `wi`, without attenuation.
    fn lobes(&self, seen: &Seen, wi: DVec3) -> [f64; LOBES] {
        let sin = wi.x.clamp(-1.0, 1.0);
        let cos = (1.0 - sin * sin).max(0.0).sqrt();
        let phi = atan2(wi.z, wi.y) - seen.phi;
        let mut out = [0.0; LOBES];
        for (lobe, out) in out.iter_mut().enumerate() {
            let m = longitudinal(self.tilted(lobe, seen), (sin, cos), self.variance(lobe));
            let n = match lobe {
                3 => 1.0 / TAU,
                _ => trimmed_logistic(wrapped(phi - Hair::azimuth(lobe, seen)), self.s),
            };
            *out = m * n;
        }
        out
    }

    /// Scattered light per solid angle, and the density of [`Hair::sample`].
    fn eval_seen(&self, seen: &Seen, wi: DVec3) -> (Rgb, f64) {
        let (mut f, mut pdf) = (Rgb::ZERO, 0.0);
        for ((lobe, a), p) in self.lobes(seen, wi).into_iter().zip(seen.a).zip(seen.p) {
            f += a * lobe;
            pdf += p * lobe;
        }
        (f, pdf)
    }

    /// f and pdf; f has the divisor |wi.z|.
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let (f, pdf) = self.eval_seen(&self.seen(wo), wi);
        (f / wi.z.abs(), pdf)
    }

    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let seen = self.seen(wo);
        let mut left = u[0];
        let mut lobe = LOBES - 1;
        for (i, p) in seen.p.iter().enumerate() {
            if left < *p || i == LOBES - 1 {
                lobe = i;
                left = if *p > 0.0 { (left / p).clamp(0.0, 1.0 - f64::EPSILON) } else { 0.0 };
                break;
            }
            left -= p;
        }
        // d'Eon et al. 2013, "An energy-conserving hair reflectance model", §4.2.
        let v = self.variance(lobe);
        let cos = (1.0 + v * ln((u[1] + (1.0 - u[1]) * exp(-2.0 / v)).max(f64::MIN_POSITIVE))).max(-1.0);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (tilted_sin, tilted_cos) = self.tilted(lobe, &seen);
        let x = (sin * sin_cos_turns(u[2]).1 * tilted_cos - cos * tilted_sin).clamp(-1.0, 1.0);
        let across = (1.0 - x * x).max(0.0).sqrt();
        let turned = match lobe {
            3 => TAU * left,
            _ => Hair::azimuth(lobe, &seen) + sample_trimmed_logistic(left, self.s),
        };
        let (s, c) = sin_cos(seen.phi + turned);
        let wi = DVec3::new(x, across * c, across * s);
        let (f, pdf) = self.eval_seen(&seen, wi);
        let lobe = Lobe { is_delta: false, is_transmission: wi.z < 0.0, is_diffuse: true };
        let usable = wi.z.abs() > MIN_COSINE && pdf > 0.0 && pdf.is_finite();
        usable.then(|| BsdfSample { wi, f: spectrum(f / wi.z.abs()), pdf, lobe, eta: 1.0 })
    }

    /// Mean of the attenuations over the offset, for light from straight across.
    pub(super) fn albedo(&self) -> Rgb {
        const STEPS: u32 = 4;
        let sum: Rgb = (0..STEPS)
            .map(|i| {
                let h = (f64::from(i) + 0.5) / f64::from(STEPS);
                Hair { h, ..*self }.attenuations(0.0, 1.0).into_iter().sum::<Rgb>()
            })
            .sum();
        sum / f64::from(STEPS)
    }

    /// Roughness of the lobe R.
    pub(super) fn roughness(&self) -> f64 {
        self.v[1].sqrt().clamp(0.0, 1.0)
    }
}

impl Bsdf<'static> {
    /// The scattering of a hair. Directions: x along the hair, z perpendicular to it on the side of wo.
    pub fn hair(p: &HairPoint) -> Bsdf<'static> {
        let mut bsdf = Bsdf::lambert(Spectrum::BLACK);
        bsdf.unlayered = Some(Unlayered::Hair(Hair::new(p)));
        bsdf
    }
}

/// The longitudinal function M of the tilted direction of wo and of wi, each as sine and cosine, with the variance `v`
/// (d'Eon et al. 2011). Its integral over wi with the cosine is 1.
fn longitudinal((sin_o, cos_o): (f64, f64), (sin_i, cos_i): (f64, f64), v: f64) -> f64 {
    let a = cos_i * cos_o / v;
    // e^(−1/v) of 1 / sinh(1/v) and e^a of I₀ together are at most 1.
    let exponent = a - (sin_i * sin_o + 1.0) / v;
    exp(exponent) * scaled_bessel(a) / (v * (1.0 - exp(-2.0 / v)))
}

/// I₀(x) e^(−x) for x >= 0, within 2e-7 (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2).
fn scaled_bessel(x: f64) -> f64 {
    /// Where the approximations meet.
    const MIDDLE: f64 = 3.75;
    const SMALL: [f64; 7] =
        [1.0, 3.515_622_9, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];
    const LARGE: [f64; 9] = [
        0.398_942_28,
        0.013_285_92,
        0.002_253_19,
        -0.001_575_65,
        0.009_162_81,
        -0.020_577_06,
        0.026_355_37,
        -0.016_476_33,
        0.003_923_77,
    ];
    let polynomial = |c: &[f64], t: f64| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if x < MIDDLE {
        let t = x / MIDDLE;
        polynomial(&SMALL, t * t) * exp(-x)
    } else {
        polynomial(&LARGE, MIDDLE / x) / x.sqrt()
    }
}

/// An angle in −π..=π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// The cumulative logistic distribution.
fn logistic_below(x: f64, s: f64) -> f64 {
    1.0 / (1.0 + exp(-x / s))
}

/// The logistic distribution within −π..=π, normalized.
fn trimmed_logistic(x: f64, s: f64) -> f64 {
    let e = exp(-x.abs() / s);
    let whole = 2.0 * logistic_below(PI, s) - 1.0;
    e / (s * (1.0 + e) * (1.0 + e) * whole)
}

fn sample_trimmed_logistic(u: f64, s: f64) -> f64 {
    let below = logistic_below(-PI, s);
    let at = below + u * (1.0 - 2.0 * below);
    let x = -s * ln((1.0 / at.max(f64::MIN_POSITIVE) - 1.0).max(f64::MIN_POSITIVE));
    x.clamp(-PI, PI)
}

/// The absorption with which a mass of hair has the colour `color` (the fit of §4.2 of the paper for multiple scattering).
pub fn sigma_a_of_color(color: Spectrum, beta_n: f64) -> [f64; 3] {
    let b = beta_n.clamp(0.0, 1.0);
    let fit = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    let of = |c: f32| {
        let root = ln(f64::from(c).clamp(1e-4, 1.0)) / fit;
        root * root
    };
    [of(color.r), of(color.g), of(color.b)]
}

/// The inverse of [`sigma_a_of_color`].
pub fn color_of_sigma_a(sigma_a: [f64; 3], beta_n: f64) -> Spectrum {
    let b = beta_n.clamp(0.0, 1.0);
    let fit = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    let [r, g, b] = sigma_a.map(|s| exp(-s.max(0.0).sqrt() * fit) as f32);
    Spectrum::new(r, g, b)
}

/// The absorption of hair with concentrations of eumelanin, which makes it brown to black, and of pheomelanin, which makes
/// it red (d'Eon et al. 2011).
pub fn sigma_a_of_melanin(eumelanin: f64, pheomelanin: f64) -> [f64; 3] {
    const EUMELANIN: [f64; 3] = [0.419, 0.697, 1.37];
    const PHEOMELANIN: [f64; 3] = [0.187, 0.4, 1.05];
    [0, 1, 2].map(|i| eumelanin * EUMELANIN[i] + pheomelanin * PHEOMELANIN[i])
}
