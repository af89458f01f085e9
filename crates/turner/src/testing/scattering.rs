//! Checks of BSDFs: sampled directions, sampled values, energy, reciprocity.
//!
//! * [`samples_follow_density`]: the χ² test of the sampled directions against the pdf.
//! * [`samples_agree_with_eval`]: f and pdf of a sample are those that `eval_pdf` returns for its direction.
//! * [`albedo`]: the mean of f·|cos θ| / pdf over samples is the reflected fraction of light. It is at most 1,
//!   and exactly 1 for a BSDF that does not absorb (white furnace test).
//! * [`reciprocity_error`]: f(wo, wi) = f(wi, wo), and f(wo, wi)·η² = f(wi, wo) for transmission, because
//!   radiance is compressed into a smaller solid angle in a denser medium.
//!
//! The checks complement each other. The first two make every estimator consistent, but both accept a wrong f.
//! Energy and reciprocity find most errors of f itself.

use super::chi_square::{ChiSquare, ChiSquareOptions, chi_square_of_directions};
use super::random::{Random, direction, spread};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::color::Spectrum;
use crate::math::DVec3;

/// The BSDF interface that the checks need; its conventions are those of [`crate::bsdf`].
pub trait Scattering {
    /// The BSDF without the cosine, and the pdf of [`sample`](Scattering::sample) per solid angle.
    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Spectrum, f64);
    /// Samples a direction with random numbers in 0..1.
    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample>;
}

impl Scattering for Bsdf<'_> {
    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Spectrum, f64) {
        Bsdf::eval_pdf(self, wo, wi)
    }
    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        Bsdf::sample(self, wo, u)
    }
}

/// Tests whether sampled directions follow the pdf, for light that leaves towards `wo`. Directions of delta
/// lobes count as no sample, because the pdf does not cover them.
pub fn samples_follow_density(
    bsdf: &impl Scattering,
    wo: DVec3,
    seed: u64,
    options: &ChiSquareOptions,
) -> ChiSquare {
    let mut random = Random::new(seed);
    let sample = || bsdf.sample(wo, random.units()).filter(|s| !s.lobe.is_delta).map(|s| s.wi);
    chi_square_of_directions(options, |wi| bsdf.eval_pdf(wo, wi).1, sample)
}

/// Checks `count` samples for `wo`. Each must have a finite unit direction, a pdf above 0, the side that its
/// lobe names, and the values of `eval_pdf` for its direction (relative error 1e-4). The error describes the
/// first sample that fails.
pub fn samples_agree_with_eval(bsdf: &impl Scattering, wo: DVec3, count: u32) -> Result<(), String> {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-9;
    for k in 0..count {
        let Some(s) = bsdf.sample(wo, spread(k)) else { continue };
        if (s.wi.length() - 1.0).abs() > 1e-9 {
            return Err(format!("the direction is not a unit vector: {s:?}"));
        }
        if !(s.pdf > 0.0 && s.pdf.is_finite() && s.f.is_finite()) {
            return Err(format!("a non-finite value, or a pdf that is not positive: {s:?}"));
        }
        if s.lobe.is_transmission != (s.wi.z < 0.0) {
            return Err(format!("on the wrong side: {s:?}"));
        }
        let (f, pdf) = bsdf.eval_pdf(wo, s.wi);
        if s.lobe.is_delta {
            // Other lobes may contribute at the direction of a delta lobe, but not the delta lobe itself.
            if !f.is_finite() || pdf > 1e3 {
                return Err(format!("a delta lobe is evaluated: pdf {pdf}, {s:?}"));
            }
            continue;
        }
        let same = f.to_array().into_iter().zip(s.f.to_array()).all(|(a, b)| close(a.into(), b.into()));
        if !close(pdf, s.pdf) || !same {
            return Err(format!("eval_pdf returns {f:?} and the pdf {pdf}, but the sample is {s:?}"));
        }
    }
    Ok(())
}

/// Fraction of the power of uniform illumination that leaves towards `wo`, from `count` samples. The scaling of
/// radiance in a denser medium is undone. In a white furnace this is the radiance of the surface.
pub fn albedo(bsdf: &impl Scattering, wo: DVec3, count: u32) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for k in 0..count {
        if let Some(s) = bsdf.sample(wo, spread(k)) {
            let weight = s.wi.z.abs() / s.pdf * s.eta * s.eta;
            for (sum, f) in sum.iter_mut().zip(s.f.to_array()) {
                *sum += f64::from(f) * weight;
            }
        }
    }
    sum.map(|v| v / f64::from(count.max(1)))
}

/// The largest relative difference between f and f with the directions exchanged, over `count` pairs of
/// directions. On one side of the surface f(wo, wi) = f(wi, wo). With `other`, the same surface from its other
/// side (x unchanged, y and z negated) and the relative index of refraction `eta` of that side, pairs through
/// the surface are compared: f(wo, wi) · eta² = f(wi, wo). Values below 1e-7 are ignored.
pub fn reciprocity_error<B: Scattering>(bsdf: &B, other: Option<(&B, f64)>, count: u32) -> f64 {
    let mut worst: f64 = 0.0;
    for k in 0..count {
        let [a, b, c] = spread(k);
        let (wo, wi) = (direction(a * 0.99 + 0.01, c * 7.0), direction(b * 0.99 + 0.01, c * 23.0));
        let (there, back) = match other {
            None => (bsdf.eval_pdf(wo, wi).0, bsdf.eval_pdf(wi, wo).0),
            Some((other, eta)) => {
                let behind = |w: DVec3| DVec3::new(w.x, -w.y, -w.z);
                let there = bsdf.eval_pdf(wo, -wi).0 * (eta * eta) as f32;
                (there, other.eval_pdf(behind(-wi), behind(wo)).0)
            }
        };
        for (x, y) in there.to_array().into_iter().zip(back.to_array()) {
            let (x, y) = (f64::from(x), f64::from(y));
            let error = ((x - y).abs() - 1e-7).max(0.0) / x.abs().max(y.abs()).max(1e-300);
            // A NaN is as wrong as possible.
            worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lobe;

    /// Lambertian reflection with optional errors.
    struct Faulty {
        albedo: f32,
        density: f64,
        tilt: f32,
    }

    impl Scattering for Faulty {
        fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Spectrum, f64) {
            if wo.z <= 0.0 || wi.z <= 0.0 {
                return (Spectrum::BLACK, 0.0);
            }
            let f = self.albedo / std::f32::consts::PI * (1.0 + self.tilt * wo.x as f32);
            (Spectrum::grey(f), self.density * wi.z / std::f64::consts::PI)
        }
        fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
            let wi = direction(u[0].sqrt(), std::f64::consts::TAU * u[1]);
            let (f, pdf) = self.eval_pdf(wo, wi);
            let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
            (pdf > 0.0).then_some(BsdfSample { wi, f, pdf: pdf / self.density, lobe, eta: 1.0 })
        }
    }

    #[test]
    fn faults_are_found() {
        let wo = direction(0.6, 1.0);
        let good = Faulty { albedo: 0.5, density: 1.0, tilt: 0.0 };
        let options = ChiSquareOptions::default();
        assert!(samples_follow_density(&good, wo, 1, &options).p_value > 0.01);
        assert_eq!(samples_agree_with_eval(&good, wo, 100), Ok(()));
        assert!((albedo(&good, wo, 1000)[0] - 0.5).abs() < 1e-6);
        assert_eq!(reciprocity_error(&good, None, 100), 0.0);

        let wrong = Faulty { density: 1.02, ..good };
        assert!(samples_follow_density(&wrong, wo, 1, &options).p_value < 1e-3);
        assert!(samples_agree_with_eval(&wrong, wo, 100).is_err());
        assert!(albedo(&Faulty { albedo: 1.01, ..good }, wo, 1000)[0] > 1.005);
        assert!(reciprocity_error(&Faulty { tilt: 0.1, ..good }, None, 100) > 0.01);
    }
}
