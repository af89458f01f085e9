//! Checks of BSDFs: samples against densities, energy, reciprocity.

use super::chi_square::{ChiSquare, ChiSquareOptions, chi_square_of_directions};
use super::random::{Random, direction, spread};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::color::Spectrum;
use crate::math::DVec3;

/// What the checks ask of a BSDF; the conventions are those of [`crate::bsdf`].
pub trait Scattering {
    /// The BSDF without the cosine, and the density of [`sample`](Scattering::sample) per solid angle.
    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Spectrum, f64);
    /// A direction for numbers within 0..1.
    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample>;
}

impl Scattering for Bsdf {
    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Spectrum, f64) {
        Bsdf::eval_pdf(self, wo, wi)
    }
    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        Bsdf::sample(self, wo, u)
    }
}

/// Whether directions are drawn as the density says, for light that leaves towards `wo`. Directions of delta lobes count as no
/// sample, for which the density has no place.
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

/// Goes through `count` samples towards `wo`: each must be of a unit direction, finite, of a density above 0, on the side that its
/// lobe names, and of the values that `eval_pdf` gives for its direction (to 1e-4 of them). The first that is not is described.
pub fn samples_agree_with_eval(bsdf: &impl Scattering, wo: DVec3, count: u32) -> Result<(), String> {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-9;
    for k in 0..count {
        let Some(s) = bsdf.sample(wo, spread(k)) else { continue };
        if (s.wi.length() - 1.0).abs() > 1e-9 {
            return Err(format!("the direction is no unit vector: {s:?}"));
        }
        if !(s.pdf > 0.0 && s.pdf.is_finite() && s.f.is_finite()) {
            return Err(format!("not finite, or of no density: {s:?}"));
        }
        if s.lobe.is_transmission != (s.wi.z < 0.0) {
            return Err(format!("on the wrong side: {s:?}"));
        }
        let (f, pdf) = bsdf.eval_pdf(wo, s.wi);
        if s.lobe.is_delta {
            // A mirror's direction has no area: only other lobes answer for it.
            if !f.is_finite() || pdf > 1e3 {
                return Err(format!("a delta lobe is evaluated: density {pdf}, {s:?}"));
            }
            continue;
        }
        let same = f.to_array().into_iter().zip(s.f.to_array()).all(|(a, b)| close(a.into(), b.into()));
        if !close(pdf, s.pdf) || !same {
            return Err(format!("eval gives {f:?} with density {pdf}, but the sample is {s:?}"));
        }
    }
    Ok(())
}

/// The share of light from all around that leaves towards `wo`, by `count` samples: of power, so without the scale of radiance in a
/// denser medium. In a white furnace this is what is seen.
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

/// The largest difference, in relation to the larger value, between light that goes one way and light that goes the other, over
/// `count` pairs of directions. On one side of the surface f(wo, wi) = f(wi, wo). With `other`, the same surface seen from its other
/// side (x as it is, y and z turned over) and the index of refraction there over that on wo's side, pairs through the surface are
/// compared: f(wo, wi) · eta² = f(wi, wo). Values below 1e-7 do not count.
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
            // What is not a number is as wrong as can be.
            worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lobe;

    /// Lambert's reflection with faults on demand.
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
