//! Phase functions: the distribution of scattered directions.
//!
//! ```text
//!                     wi
//!    forward     θ  /           p(cos θ) = (1 − g²) / (4π (1 + g² − 2 g cos θ)^(3/2))
//!   ---------->*---------->
//! ```
//!
//! Its distribution function inverts in closed form: cos θ = (1 + g² − s²) / 2g, s = (1 − g²) / (1 + g − 2 g u).
//! Sampling is exact: value / density is 1.

use std::f64::consts::{PI, TAU};

use crate::math::elementary::sin_cos;
use crate::math::{DVec3, Frame};

/// The phase function of Henyey and Greenstein (1941, "Diffuse radiation in the galaxy"), per solid angle, normalised
/// over the sphere.
///
/// Directions are those in which light or the path travels, before and after; `g` is the mean cosine between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    /// Mean cosine, between −1 and 1: above 0 is forward scattering, 0 isotropic, below 0 backward.
    pub g: f64,
}

/// Smaller |g| count as isotropic, because sampling divides by g.
const ISOTROPIC: f64 = 1e-4;

impl HenyeyGreenstein {
    /// Value per solid angle at the cosine of the scattering angle; also the density of [`HenyeyGreenstein::sample`].
    #[inline]
    pub fn value(&self, cosine: f64) -> f64 {
        let g = self.g;
        if g.abs() < ISOTROPIC {
            return 0.25 / PI;
        }
        let d = 1.0 + g * g - 2.0 * g * cosine;
        // At least (1 − |g|)², up to rounding.
        let d = d.max((1.0 - g.abs()) * (1.0 - g.abs()));
        0.25 / PI * (1.0 - g * g) / (d * d.sqrt())
    }

    /// Samples the direction after scattering, with its density, for light travelling in the unit direction `forward`;
    /// `u` in 0..1.
    #[inline]
    pub fn sample(&self, forward: DVec3, u: [f64; 2]) -> (DVec3, f64) {
        let g = self.g;
        let cosine = if g.abs() < ISOTROPIC {
            1.0 - 2.0 * u[0]
        } else {
            let s = (1.0 - g * g) / (1.0 + g - 2.0 * g * u[0]);
            ((1.0 + g * g - s * s) / (2.0 * g)).clamp(-1.0, 1.0)
        };
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (s, c) = sin_cos(TAU * u[1]);
        let wi = Frame::from_z(forward).to_world(DVec3::new(sine * c, sine * s, cosine));
        (wi, self.value(cosine))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{ChiSquareOptions, Random, chi_square_of_directions, sidak_level};

    const GS: [f64; 7] = [-0.9, -0.4, -1e-5, 0.0, 0.3, 0.8, 0.95];

    #[test]
    fn samples_follow_the_function() {
        let mut random = Random::new(31);
        let forward = DVec3::new(0.3, -0.5, 0.7).normalize();
        for g in GS {
            let phase = HenyeyGreenstein { g };
            let options = ChiSquareOptions::default();
            let value = |w: DVec3| phase.value(forward.dot(w));
            let test = chi_square_of_directions(&options, value, || {
                Some(phase.sample(forward, random.units::<2>()).0)
            });
            assert!(test.p_value > sidak_level(0.01, GS.len()), "g = {g}: {test:?}");
        }
    }

    /// By Simpson's rule over the cosine, with steps that resolve the peak.
    #[test]
    fn it_is_normalised_and_g_is_its_mean_cosine() {
        for g in GS {
            let phase = HenyeyGreenstein { g };
            let (mut total, mut mean) = (0.0, 0.0);
            let n = 200_000;
            for i in 0..=n {
                let c = -1.0 + 2.0 * f64::from(i) / f64::from(n);
                let weight = if i == 0 || i == n {
                    1.0
                } else if i % 2 == 1 {
                    4.0
                } else {
                    2.0
                };
                let part = TAU * phase.value(c) * weight * 2.0 / (3.0 * f64::from(n));
                (total, mean) = (total + part, mean + part * c);
            }
            assert!((total - 1.0).abs() < 1e-6, "g = {g}: {total}");
            assert!((mean - if g.abs() < ISOTROPIC { 0.0 } else { g }).abs() < 1e-6, "g = {g}: {mean}");
        }
    }

    #[test]
    fn a_sample_comes_with_its_density() {
        let mut random = Random::new(5);
        for g in GS {
            let phase = HenyeyGreenstein { g };
            for _ in 0..200 {
                let forward = crate::sampler::uniform_sphere(random.units::<2>().into());
                let (wi, pdf) = phase.sample(forward, random.units::<2>());
                assert!((wi.length() - 1.0).abs() < 1e-12);
                assert!((pdf / phase.value(forward.dot(wi)) - 1.0).abs() < 1e-6, "g = {g}");
            }
        }
    }
}
