//! Phase functions: the distribution of scattered directions.
//!
//! ```text
//!                     wi
//!    forward     θ  /           p(cos θ) = (1 − g²) / (4π (1 + g² − 2 g cos θ)^(3/2))
//!   ---------->*---------->
//! ```
//!
//! Its distribution function inverts in closed form: cos θ = (1 + g² − s²) / 2g, s = (1 − g²) / (1 + g − 2 g u).
//! Rayleigh's, 3 (1 + cos² θ) / 16π, does too: cos θ = a − 1/a, a³ = z + √(z² + 1), z = 4u − 2 (Frisvad 2011,
//! "Importance sampling the Rayleigh phase function"). A medium has a mixture of two Henyey-Greenstein lobes and Rayleigh's phase function.
//! Sampling is exact: value / density is 1.

use std::f64::consts::{PI, TAU};

use crate::math::elementary::{cbrt, sin_cos};
use crate::math::{DVec3, Frame};

/// The phase function of Henyey and Greenstein (1941, "Diffuse radiation in the galaxy"), per solid angle, normalised
/// over the sphere.
///
/// Directions are those in which light or the path travels, before and after; `g` is the mean cosine between them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HenyeyGreenstein {
    /// Mean cosine, between −1 and 1: above 0 is forward scattering, 0 isotropic, below 0 backward.
    g: f64,
}

/// Smaller |g| count as isotropic, because sampling divides by g.
const ISOTROPIC: f64 = 1e-4;

impl HenyeyGreenstein {
    /// Value per solid angle at the cosine of the scattering angle; also the density of its samples.
    #[inline]
    fn value(&self, cosine: f64) -> f64 {
        let g = self.g;
        if g.abs() < ISOTROPIC {
            return 0.25 / PI;
        }
        let d = 1.0 + g * g - 2.0 * g * cosine;
        // At least (1 − |g|)², up to rounding.
        let d = d.max((1.0 - g.abs()) * (1.0 - g.abs()));
        0.25 / PI * (1.0 - g * g) / (d * d.sqrt())
    }

    /// Samples the cosine of the scattering angle; `u` in 0..1.
    #[inline]
    fn sample_cosine(&self, u: f64) -> f64 {
        let g = self.g;
        if g.abs() < ISOTROPIC {
            return 1.0 - 2.0 * u;
        }
        let s = (1.0 - g * g) / (1.0 + g - 2.0 * g * u);
        ((1.0 + g * g - s * s) / (2.0 * g)).clamp(-1.0, 1.0)
    }
}

/// Rayleigh's phase function: of particles much smaller than the wavelength.
#[inline]
fn rayleigh(cosine: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
}

#[inline]
fn sample_rayleigh(u: f64) -> f64 {
    let z = 4.0 * u - 2.0;
    let a = cbrt(z + (z * z + 1.0).sqrt());
    (a - 1.0 / a).clamp(-1.0, 1.0)
}

/// The phase function of a medium: two lobes of Henyey and Greenstein, and Rayleigh's. Per solid angle, normalised over
/// the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseFunction {
    lobes: [HenyeyGreenstein; 2],
    /// Weights of the second lobe and of Rayleigh's phase function; the first lobe has the rest.
    second: f64,
    rayleigh: f64,
}

impl PhaseFunction {
    /// The same in all directions.
    pub const ISOTROPIC: PhaseFunction =
        PhaseFunction { lobes: [HenyeyGreenstein { g: 0.0 }; 2], second: 0.0, rayleigh: 0.0 };

    /// From the mean cosines of two lobes, and the fractions of Rayleigh's function and, of the rest, of the second lobe.
    pub fn new(cosines: [f64; 2], second: f64, rayleigh: f64) -> PhaseFunction {
        let lobes = cosines.map(|g| HenyeyGreenstein { g });
        PhaseFunction { lobes, second: second * (1.0 - rayleigh), rayleigh }
    }

    /// Value per solid angle at the cosine of the scattering angle; also the density of [`PhaseFunction::sample`].
    #[inline]
    pub fn value(&self, cosine: f64) -> f64 {
        let first = self.lobes[0].value(cosine);
        if self.second + self.rayleigh == 0.0 {
            return first;
        }
        let second = self.lobes[1].value(cosine);
        self.first() * first + self.second * second + self.rayleigh * rayleigh(cosine)
    }

    /// Samples the direction after scattering, with its density, for light travelling in the unit direction `forward`;
    /// `u` in 0..1.
    #[inline]
    pub fn sample(&self, forward: DVec3, u: [f64; 2]) -> (DVec3, f64) {
        let first = self.first();
        // u[0] chooses the lobe, and is rescaled to 0..1 to sample it.
        let cosine = if u[0] < first {
            self.lobes[0].sample_cosine(u[0] / first)
        } else if u[0] < first + self.second || self.rayleigh == 0.0 {
            self.lobes[1].sample_cosine((u[0] - first) / self.second)
        } else {
            sample_rayleigh(((u[0] - first - self.second) / self.rayleigh).clamp(0.0, 1.0))
        };
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (s, c) = sin_cos(TAU * u[1]);
        let wi = Frame::from_z(forward).to_world(DVec3::new(sine * c, sine * s, cosine));
        (wi, self.value(cosine))
    }

    /// Fraction of light that the first lobe scatters.
    #[inline]
    fn first(&self) -> f64 {
        1.0 - self.second - self.rayleigh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{ChiSquareOptions, Random, chi_square_of_directions, sidak_level};

    const GS: [f64; 7] = [-0.9, -0.4, -1e-5, 0.0, 0.3, 0.8, 0.95];

    /// With their mean cosines.
    fn functions() -> Vec<(PhaseFunction, f64)> {
        let single =
            GS.map(|g| (PhaseFunction::new([g, 0.5], 0.0, 0.0), if g.abs() < ISOTROPIC { 0.0 } else { g }));
        let mixed = [
            (PhaseFunction::new([0.3, 0.2], 0.0, 1.0), 0.0),
            (PhaseFunction::new([0.8, -0.4], 0.3, 0.0), 0.7 * 0.8 - 0.3 * 0.4),
            (PhaseFunction::new([0.8, -0.4], 1.0, 0.0), -0.4),
            (PhaseFunction::new([0.9, -0.5], 0.5, 0.4), 0.3 * 0.9 - 0.3 * 0.5),
        ];
        single.into_iter().chain(mixed).collect()
    }

    #[test]
    fn samples_follow_the_function() {
        let mut random = Random::new(31);
        let forward = DVec3::new(0.3, -0.5, 0.7).normalize();
        let all = functions();
        for (phase, _) in &all {
            let options = ChiSquareOptions::default();
            let value = |w: DVec3| phase.value(forward.dot(w));
            let test = chi_square_of_directions(&options, value, || {
                Some(phase.sample(forward, random.units::<2>()).0)
            });
            assert!(test.p_value > sidak_level(0.01, all.len()), "{phase:?}: {test:?}");
        }
    }

    /// By Simpson's rule over the cosine, with steps that resolve the peak.
    #[test]
    fn it_is_normalised_and_has_its_mean_cosine() {
        for (phase, expected) in functions() {
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
            assert!((total - 1.0).abs() < 1e-6, "{phase:?}: {total}");
            assert!((mean - expected).abs() < 1e-6, "{phase:?}: {mean}");
        }
    }

    /// The values at 0°, 90° and 180° of the textbooks.
    #[test]
    fn air_scatters_twice_as_much_along_the_axis() {
        let air = PhaseFunction::new([0.0; 2], 0.0, 1.0);
        for (cosine, expected) in [(1.0, 1.5), (0.0, 0.75), (-1.0, 1.5)] {
            assert!((4.0 * PI * air.value(cosine) - expected).abs() < 1e-12);
        }
        for u in [0.0, 0.1, 0.5, 0.9, 1.0] {
            // The distribution function, (4 + 3 c + c³) / 8, has the value u at the sampled cosine.
            let c = sample_rayleigh(u);
            assert!(((4.0 + 3.0 * c + c * c * c) / 8.0 - u).abs() < 1e-9, "{u}: {c}");
        }
    }

    #[test]
    fn a_sample_comes_with_its_density() {
        let mut random = Random::new(5);
        for (phase, _) in functions() {
            for _ in 0..200 {
                let forward = crate::sampler::uniform_sphere(random.units::<2>().into());
                let (wi, pdf) = phase.sample(forward, random.units::<2>());
                assert!((wi.length() - 1.0).abs() < 1e-12);
                assert!((pdf / phase.value(forward.dot(wi)) - 1.0).abs() < 1e-6, "{phase:?}");
            }
        }
    }
}
