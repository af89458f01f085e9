//! Diffuse reflection: Lambert's, and the energy-preserving Oren-Nayar model for rough surfaces (Portsmouth, Kutz and
//! Hill 2024, "EON: A practical energy-preserving rough diffuse BRDF"). The model is the sum of single scattering
//! between facets and a lobe that returns multiple scattering; at roughness 0 it is Lambert's.

use super::Rgb;
use crate::math::DVec3;
use crate::math::elementary::{acos, sin_cos_turns};
use std::f64::consts::PI;

/// Below this roughness the reflection is Lambert's.
pub(super) const MIN_ROUGHNESS: f64 = 1e-6;

const C1: f64 = 0.5 - 2.0 / (3.0 * PI);
const C2: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// The diffuse BRDF. `rho` is the albedo of single scattering, equal to the total albedo where it is 0 or 1.
/// `roughness` is within 0..=1; both directions are above the surface.
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

/// Directional albedo of single scattering of a white surface.
fn single_albedo(mu: f64, roughness: f64) -> f64 {
    let mu = mu.clamp(1e-6, 1.0);
    let sin = (1.0 - mu * mu).sqrt();
    let g = sin * (acos(mu) - sin * mu) + (2.0 / 3.0) * ((sin / mu) * (1.0 - sin * sin * sin) - sin);
    (1.0 + roughness * g / PI) / (1.0 + C1 * roughness)
}

/// A direction in the upper hemisphere with density cos θ / π. `u` in 0..1.
pub(crate) fn sample_cosine(u: [f64; 2]) -> DVec3 {
    let r2 = u[0];
    let (sin, cos) = sin_cos_turns(u[1]);
    let r = r2.sqrt();
    DVec3::new(r * cos, r * sin, (1.0 - r2).max(0.0).sqrt())
}
