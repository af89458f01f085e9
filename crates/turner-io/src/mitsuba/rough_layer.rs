//! Mitsuba's `roughplastic` as OpenPBR: the light that passes a rough dielectric layer over a diffuse base.
//!
//! ```text
//!    wi ↘      ↗ wo
//!   ═════════════════  rough interface: transmits T from outside, reflects r from inside
//!         ↘↗ ↘↗
//!   ─────────────────  diffuse base of reflectance ρ
//! ```
//!
//! Reflections between base and interface are a geometric series: ρ T² / (η² (1 − ρ r)) leaves. Without
//! `nonlinear`, Mitsuba uses 1 − r in place of 1 − ρ r. Its T and r count single scattering at microfacets only, so
//! that a rough layer loses light, and so does Turner's without `specular_multiple_scattering`. Turner divides T² by its
//! mean, so that the base colour is ρ · gain / (1 − ρ · inner). Means of T and r are averages over 64 directions of the
//! averages over visible normals; one layer takes milliseconds.

use turner::bsdf::FacetDistribution;

use crate::scene_import::Microfacets;

/// Directions over the hemisphere. Mitsuba takes as many, and its result depends on it.
const DIRECTIONS: usize = 64;

/// The diffuse transmittance and inner reflectance of a rough interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoughLayer {
    /// Fraction of diffuse light from outside that is transmitted.
    transmitted: f64,
    /// Fraction of diffuse light from inside that is reflected back.
    inner: f64,
    ior: f64,
}

impl RoughLayer {
    /// For an interface of roughness `alpha` with the relative index of refraction `ior`, at least 1.
    pub(super) fn new(distribution: FacetDistribution, alpha: f64, ior: f64) -> RoughLayer {
        let microfacets = Microfacets::new(alpha.max(1e-3), false).of(distribution);
        let inward = |mu| microfacets.mean(mu, |wi, m| microfacets.through(wi, m, ior).0);
        let inside = |mu| microfacets.mean(mu, |wi, m| microfacets.back(wi, m, 1.0 / ior).0);
        let n = DIRECTIONS as f64;
        // The cosine-weighted mean in equal steps of μ²; then Mitsuba's own sum, in equal steps of μ.
        let transmitted = (0..DIRECTIONS).map(|i| inward(((i as f64 + 0.5) / n).sqrt())).sum::<f64>() / n;
        let even = (0..DIRECTIONS).map(|i| (i as f64 / (n - 1.0)).max(1e-6));
        let inner = 2.0 * even.map(|mu| mu * inside(mu)).sum::<f64>() / n;
        RoughLayer { transmitted, inner, ior }
    }

    /// (gain, inner): the base colour is ρ · gain / (1 − ρ · inner), or ρ · gain / (1 − inner) if the file is
    /// linear in ρ.
    pub(super) fn gain(self) -> (f64, f64) {
        (self.transmitted / (self.ior * self.ior), self.inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GGX: FacetDistribution = FacetDistribution::Ggx;

    #[test]
    fn mitsubas_inner_reflectance_is_met() {
        // From the reflectance of Mitsuba 3.9.1 with and without `nonlinear`, base 0.6.
        for (ior, alpha, inner) in [(1.5, 0.05, 0.5761), (1.5, 0.2, 0.4863), (1.9, 0.4, 0.5087)] {
            let found = RoughLayer::new(GGX, alpha, ior).inner;
            assert!((found - inner).abs() < 3e-3, "{ior} {alpha}: {found} for {inner}");
        }
    }

    #[test]
    fn a_white_furnace_leaves_what_mitsubas_leaves() {
        // Mitsuba's reflectance at normal incidence, base 0.6; `ahead` is the transmittance there.
        for (ior, alpha, linear, nonlinear) in
            [(1.5, 0.1, 0.5217, 0.3495), (1.5, 0.2, 0.4540, 0.3293), (1.9, 0.2, 0.3747, 0.2122)]
        {
            let layer = RoughLayer::new(GGX, alpha, ior);
            let microfacets = Microfacets::new(alpha, false);
            let ahead = microfacets.mean(1.0, |wi, m| microfacets.through(wi, m, ior).0);
            let base = 0.6 * layer.transmitted * ahead / (ior * ior);
            let found = [base / (1.0 - layer.inner), base / (1.0 - 0.6 * layer.inner)];
            assert!((found[0] / linear - 1.0).abs() < 0.012, "{ior} {alpha}: {found:?}");
            assert!((found[1] / nonlinear - 1.0).abs() < 0.012, "{ior} {alpha}: {found:?}");
        }
    }

    #[test]
    fn a_smooth_layer_gains_nothing() {
        let smooth = crate::scene_import::inner_reflectance(1.5);
        let (gain, inner) = RoughLayer::new(GGX, 0.0, 1.5).gain();
        // A linear file keeps ρ.
        assert!((gain / (1.0 - inner) - 1.0).abs() < 0.05, "{gain} {inner}");
        assert!((gain - (1.0 - smooth)).abs() < 0.01, "{gain} {smooth}");
    }
}
