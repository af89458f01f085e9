//! The clear coat: a dielectric layer over the base that reflects, absorbs and darkens what is below.
//!
//! ```text
//!    wo            wi
//!      \  GGX     /        reflection at the top, relative index `index`
//!   ----\--------/----
//!        \      /          absorption over the refracted path 1/cos θt in and out
//!   ======\====/======     internal reflection: light that the base sends up comes back,
//!          base            which darkens the base (OpenPBR's coat_darkening)
//! ```

use super::albedo::{AlbedoDirection, Reflected};
use super::facets::Facets;
use super::fresnel;
use super::{PrincipledPoint, Rgb, color, unit};
use crate::math::DVec3;
use crate::math::elementary::{exp, ln};

const MIN_ALPHA: f64 = 1e-4;

/// The prepared coat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coat {
    /// Fraction of the surface covered.
    pub(super) weight: f64,
    pub(super) facets: Facets,
    pub(super) smooth: bool,
    /// Index over that outside, at least 1.
    index: f64,
    /// Directional albedo, if rough.
    rough: Option<Reflected>,
    /// Logarithm of the colour; `None` for white.
    absorption: Option<Rgb>,
    /// Factor of what the base reflects.
    darkening: Rgb,
}

impl Coat {
    /// `None` without a coat. `base` is the base's albedo; `base_roughness` is 0 for a mirror, 1 for a diffuse base.
    pub(super) fn new(p: &PrincipledPoint, base: Rgb, base_roughness: f64) -> Option<Coat> {
        let weight = unit(p.coat_weight);
        if weight == 0.0 {
            return None;
        }
        let index = if p.coat_ior > 0.0 && p.coat_ior.is_finite() { p.coat_ior.min(1e6) } else { 1.0 };
        let index = if index < 1.0 { 1.0 / index } else { index };
        let alpha = unit(p.coat_roughness) * unit(p.coat_roughness);
        let smooth = alpha < MIN_ALPHA;
        let tint = color(p.coat_color);
        // Fraction of light from the base that the coat reflects back down, for a rough and for a smooth base
        // (OpenPBR).
        let k_rough = 1.0 - (1.0 - fresnel::dielectric_average(index)) / (index * index);
        let k_smooth = fresnel::f0(index);
        let internal = k_smooth + (k_rough - k_smooth) * base_roughness;
        let darkening = (1.0 - internal) / (Rgb::ONE - base * internal).max(Rgb::splat(1e-9));
        let facets = Facets::ggx(alpha.max(MIN_ALPHA), alpha.max(MIN_ALPHA));
        Some(Coat {
            weight,
            facets,
            smooth,
            index,
            rough: (!smooth).then(|| Reflected::new(&facets, index)),
            absorption: (tint != Rgb::ONE).then(|| Rgb::new(ln(tint.x), ln(tint.y), ln(tint.z))),
            darkening: Rgb::ONE.lerp(darkening.clamp(Rgb::ZERO, Rgb::ONE), unit(p.coat_darkening)),
        })
    }

    /// α of a coat's lobe, before the coat is made.
    pub(super) fn alpha(p: &PrincipledPoint) -> f64 {
        if unit(p.coat_weight) > 0.0 { unit(p.coat_roughness) * unit(p.coat_roughness) } else { 0.0 }
    }

    /// Reflectance at a facet.
    pub(super) fn fresnel(&self, mu: f64) -> f64 {
        fresnel::dielectric(mu, self.index)
    }

    /// Directional albedo of the coat, where it covers.
    pub(super) fn albedo(&self, mu: f64) -> f64 {
        self.rough.map_or_else(|| self.fresnel(mu), |rough| rough.at(AlbedoDirection::all(mu)))
    }

    /// Path length through a coat of thickness 1 along the refracted direction of µ.
    pub(super) fn path_length(&self, mu: f64) -> f64 {
        1.0 / fresnel::refracted_cosine(mu, self.index).unwrap_or(1.0).max(1e-3)
    }

    /// Transmission of the coat; `path_lengths` is the sum of the path lengths in and out. At 2 it is the coat's own
    /// colour.
    pub(super) fn tint(&self, path_lengths: f64, reflected: bool) -> Rgb {
        let mut tint = match self.absorption {
            None => Rgb::ONE,
            Some(log) => {
                let k = 0.5 * path_lengths;
                // The logarithm of black is −∞; over length 0 nothing is absorbed.
                if k > 0.0 { Rgb::new(exp(log.x * k), exp(log.y * k), exp(log.z * k)) } else { Rgb::ONE }
            }
        };
        if reflected {
            tint *= self.darkening;
        }
        Rgb::ONE.lerp(tint, self.weight)
    }

    /// BRDF of the coat, where it covers, and its density; (0, 0) for a smooth coat.
    pub(super) fn reflect(&self, wo: DVec3, wi: DVec3) -> (f64, f64) {
        if self.smooth {
            return (0.0, 0.0);
        }
        let h = (wo + wi).normalize();
        let d = self.facets.d(h);
        let (lo, li) = (self.facets.lambda(wo), self.facets.lambda(wi));
        let f = self.fresnel(wo.dot(h)) * d / ((1.0 + lo + li) * 4.0 * wo.z * wi.z);
        (f, d / ((1.0 + lo) * 4.0 * wo.z))
    }
}
