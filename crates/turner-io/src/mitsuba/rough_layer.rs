//! The diffuse light of `roughplastic` as Mitsuba counts it: what gets in and out of a rough layer without being reflected twice between its microfacets.
//! Turner loses none of that light, so that the base takes what the file's renderer would have left of it.

use crate::scene_import::Microfacets;

/// Directions over the hemisphere: as many as Mitsuba takes, since its sum depends on it.
const DIRECTIONS: usize = 64;

/// What a rough boundary lets through and turns back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoughLayer {
    /// Share of diffuse light from outside that gets in.
    transmitted: f64,
    /// Share of diffuse light from inside that is reflected back in.
    inner: f64,
    ior: f64,
}

impl RoughLayer {
    /// Of a GGX boundary of width `alpha` with `ior` inside over outside, at least 1.
    pub(super) fn new(alpha: f64, ior: f64) -> RoughLayer {
        let microfacets = Microfacets::new(alpha.max(1e-3), false);
        let inward = |mu| microfacets.mean(mu, |wi, m| microfacets.through(wi, m, ior).0);
        let inside = |mu| microfacets.mean(mu, |wi, m| microfacets.back(wi, m, 1.0 / ior).0);
        let n = DIRECTIONS as f64;
        // The square of the cosine in even steps, each at its middle; and Mitsuba's own sum, the cosine in even steps.
        let transmitted = (0..DIRECTIONS).map(|i| inward(((i as f64 + 0.5) / n).sqrt())).sum::<f64>() / n;
        let even = (0..DIRECTIONS).map(|i| (i as f64 / (n - 1.0)).max(1e-6));
        let inner = 2.0 * even.map(|mu| mu * inside(mu)).sum::<f64>() / n;
        RoughLayer { transmitted, inner, ior }
    }

    /// Gain and inner reflectance: the base's reflectance ρ becomes ρ · gain / (1 − ρ · inner), or without the ρ below where the file is linear in it.
    /// `smooth` is what the smooth boundary reflects of diffuse light from inside.
    pub(super) fn gain(self, smooth: f64) -> (f64, f64) {
        // Here 1 − R of the smooth boundary, by reciprocity times η², gets out of the layer and in.
        let here = (1.0 - smooth) * self.ior * self.ior;
        (self.transmitted * self.transmitted / (self.ior * self.ior * here), self.inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mitsubas_inner_reflectance_is_met() {
        // From what Mitsuba 3.9.1 reflects with and without `nonlinear`, base 0.6.
        for (ior, alpha, inner) in [(1.5, 0.05, 0.5761), (1.5, 0.2, 0.4863), (1.9, 0.4, 0.5087)] {
            let found = RoughLayer::new(alpha, ior).inner;
            assert!((found - inner).abs() < 3e-3, "{ior} {alpha}: {found} for {inner}");
        }
    }

    #[test]
    fn a_white_furnace_leaves_what_mitsubas_leaves() {
        // Mitsuba's reflectance from ahead, base 0.6: T(1) is what gets in from there.
        for (ior, alpha, linear, nonlinear) in
            [(1.5, 0.1, 0.5217, 0.3495), (1.5, 0.2, 0.4540, 0.3293), (1.9, 0.2, 0.3747, 0.2122)]
        {
            let layer = RoughLayer::new(alpha, ior);
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
        let (gain, inner) = RoughLayer::new(0.0, 1.5).gain(smooth);
        // In a linear file ρ stays ρ.
        assert!((gain / (1.0 - inner) - 1.0).abs() < 0.05, "{gain} {inner}");
    }
}
