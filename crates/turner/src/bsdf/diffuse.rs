//! Diffuse reflection: Lambert's, and the energy-preserving Oren–Nayar model for rough surfaces (Portsmouth, Kutz and Hill 2024,
//! "EON: A practical energy-preserving rough diffuse BRDF"), which is Lambert's at roughness 0.

use super::Rgb;
use crate::math::DVec3;
use crate::math::elementary::{acos, sin_cos_turns};
use std::f64::consts::PI;

/// Smoother bodies are Lambert's.
pub(super) const MIN_ROUGHNESS: f64 = 1e-6;

const C1: f64 = 0.5 - 2.0 / (3.0 * PI);
const C2: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// The diffuse BRDF of a surface of colour `rho` (the albedo of single scattering; of everything where it is 0 or 1), roughness 0..=1,
/// both directions above the surface.
pub(super) fn eon(rho: Rgb, roughness: f64, wo: DVec3, wi: DVec3) -> Rgb {
    if roughness < MIN_ROUGHNESS {
        return rho / PI;
    }
    let s = wo.dot(wi) - wo.z * wi.z;
    let st = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
    let af = 1.0 / (1.0 + C1 * roughness);
    let single = rho * (af * (1.0 + roughness * st) / PI);
    let average = af * (1.0 + C2 * roughness);
    let (eo, ei) = (single_albedo(wo.z, roughness), single_albedo(wi.z, roughness));
    let again = rho * rho * average / (Rgb::ONE - rho * (1.0 - average));
    single + again * ((1.0 - eo).max(0.0) * (1.0 - ei).max(0.0) / (PI * (1.0 - average)))
}

/// Share of light from direction µ that leaves a white surface after one scattering.
fn single_albedo(mu: f64, roughness: f64) -> f64 {
    let mu = mu.clamp(1e-6, 1.0);
    let sin = (1.0 - mu * mu).sqrt();
    let g = sin * (acos(mu) - sin * mu) + (2.0 / 3.0) * ((sin / mu) * (1.0 - sin * sin * sin) - sin);
    (1.0 + roughness * g / PI) / (1.0 + C1 * roughness)
}

/// A direction in the upper hemisphere with density cos/π.
pub(crate) fn sample_cosine(u: [f64; 2]) -> DVec3 {
    let r2 = u[0];
    let (sin, cos) = sin_cos_turns(u[1]);
    let r = r2.sqrt();
    DVec3::new(r * cos, r * sin, (1.0 - r2).max(0.0).sqrt())
}
