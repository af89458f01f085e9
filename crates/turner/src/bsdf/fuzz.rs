//! Fuzz, the sheen of cloth and dust: the "Charlie" distribution of fibre normals D ∝ sin^(1/α) θ, with the authors'
//! fit of Smith's masking (Estevez and Kulla 2017, "Production friendly microfacet sheen BRDF").

use super::albedo::FuzzAlbedo;
use crate::math::DVec3;
use crate::math::elementary::{exp, pow, sin_cos_turns};
use std::f64::consts::PI;

/// Fuzz of one roughness.
#[derive(Clone, Copy, Debug)]
pub(super) struct Charlie {
    /// Exponent of the sine, 1/α.
    exponent: f64,
    /// Coefficients a to e of the fit of Λ.
    masking: [f64; 5],
    albedo: FuzzAlbedo,
}

/// Lower roughnesses are clamped to this one: the fit of the masking would let them reflect more light than arrives.
pub(super) const MIN_ROUGHNESS: f64 = 0.27;

impl Charlie {
    /// `roughness` is within 0..=1; α is its square.
    pub(super) fn new(roughness: f64) -> Charlie {
        let roughness = roughness.clamp(MIN_ROUGHNESS, 1.0);
        let alpha = roughness * roughness;
        let t = (1.0 - alpha) * (1.0 - alpha);
        let mut masking = ROUGH;
        for (c, smooth) in masking.iter_mut().zip(SMOOTH) {
            *c += (smooth - *c) * t;
        }
        Charlie { exponent: 1.0 / alpha, masking, albedo: FuzzAlbedo::new(roughness) }
    }

    /// The BRDF; both directions above the surface.
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> f64 {
        let h = (wo + wi).normalize();
        let sin = (1.0 - h.z * h.z).max(0.0).sqrt();
        let d = (2.0 + self.exponent) * pow(sin, self.exponent) / (2.0 * PI);
        d / (4.0 * wo.z * wi.z * (1.0 + self.lambda(wo.z) + self.lambda(wi.z)))
    }

    /// Smith's Λ: invisible over visible area (§3 of the paper).
    fn lambda(&self, mu: f64) -> f64 {
        let [a, b, c, d, e] = self.masking;
        let l = |x: f64| a / (1.0 + b * pow(x, c)) + d * x + e;
        exp(if mu < 0.5 { l(mu) } else { 2.0 * l(0.5) - l(1.0 - mu) })
    }

    /// Directional albedo at the cosine µ.
    pub(super) fn albedo(&self, mu: f64) -> f64 {
        self.albedo.at(mu).clamp(0.0, 1.0)
    }

    /// A direction, uniform over the hemisphere.
    pub(super) fn sample(u: [f64; 2]) -> DVec3 {
        let (sin, cos) = sin_cos_turns(u[1]);
        let r = (1.0 - u[0] * u[0]).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, u[0])
    }

    /// Density of [`Charlie::sample`], per solid angle.
    pub(super) const PDF: f64 = 1.0 / (2.0 * PI);
}

/// Coefficients of Λ at α = 0 and α = 1 (table 1 of the paper).
const SMOOTH: [f64; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
const ROUGH: [f64; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
