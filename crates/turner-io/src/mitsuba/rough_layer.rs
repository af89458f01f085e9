//! The diffuse light of `roughplastic` as Mitsuba counts it: what gets in and out of a rough layer without being reflected twice between its microfacets.
//! Turner loses none of that light, so that the base takes what the file's renderer would have left of it.

use turner::math::DVec3;
use turner::math::elementary::{cos, sin};

/// Directions over the hemisphere: as many as Mitsuba takes, since its sum depends on it.
const DIRECTIONS: usize = 64;
/// Microfacet normals per direction are the square of this.
const NORMALS: usize = 32;

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
        let alpha = alpha.clamp(1e-3, 1.0);
        let inward = |mu| over_normals(mu, alpha, |wi, m| through(wi, m, alpha, ior));
        let inside = |mu| over_normals(mu, alpha, |wi, m| back(wi, m, alpha, 1.0 / ior));
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

/// The mean over the microfacets that are visible from a direction of cosine `mu` (Heitz, "Sampling the GGX distribution of visible normals", 2018).
fn over_normals(mu: f64, alpha: f64, f: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let wi = DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let vh = DVec3::new(alpha * wi.x, 0.0, wi.z).normalize();
    let (t1, t2) = (DVec3::Y, vh.cross(DVec3::Y));
    let place = |i: usize| (i as f64 + 0.5) / NORMALS as f64;
    let mut sum = 0.0;
    for i in 0..NORMALS {
        for j in 0..NORMALS {
            let (r, angle) = (place(i).sqrt(), std::f64::consts::TAU * place(j));
            let (a, b) = (r * cos(angle), r * sin(angle));
            let s = 0.5 * (1.0 + vh.z);
            let b = (1.0 - s) * (1.0 - a * a).max(0.0).sqrt() + s * b;
            let n = t1 * a + t2 * b + vh * (1.0 - a * a - b * b).max(0.0).sqrt();
            sum += f(wi, DVec3::new(alpha * n.x, alpha * n.y, n.z.max(1e-9)).normalize());
        }
    }
    sum / (NORMALS * NORMALS) as f64
}

/// Smith's shadowing of a direction on either side.
fn visible(w: DVec3, m: DVec3, alpha: f64) -> f64 {
    if w.dot(m) * w.z <= 0.0 {
        return 0.0;
    }
    let c2 = (w.z * w.z).max(1e-12);
    2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 - c2) / c2).sqrt())
}

/// Fresnel's reflectance and the cosine beyond the boundary; `eta` is the index there over that here.
fn fresnel(c: f64, eta: f64) -> (f64, f64) {
    let c = c.clamp(0.0, 1.0);
    let s2 = (1.0 - c * c) / (eta * eta);
    if s2 >= 1.0 {
        return (1.0, 0.0);
    }
    let t = (1.0 - s2).sqrt();
    let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
    (0.5 * (s * s + p * p), t)
}

fn back(wi: DVec3, m: DVec3, alpha: f64, eta: f64) -> f64 {
    let d = wi.dot(m);
    let wo = 2.0 * d * m - wi;
    if wo.z > 0.0 { fresnel(d, eta).0 * visible(wo, m, alpha) } else { 0.0 }
}

fn through(wi: DVec3, m: DVec3, alpha: f64, eta: f64) -> f64 {
    let d = wi.dot(m);
    let (f, t) = fresnel(d, eta);
    let wo = m * (d / eta - t) - wi / eta;
    if wo.z < 0.0 { (1.0 - f) * visible(-wo, m, alpha) } else { 0.0 }
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
            let ahead = over_normals(1.0, alpha, |wi, m| through(wi, m, alpha, ior));
            let base = 0.6 * layer.transmitted * ahead / (ior * ior);
            let found = [base / (1.0 - layer.inner), base / (1.0 - 0.6 * layer.inner)];
            assert!((found[0] / linear - 1.0).abs() < 0.012, "{ior} {alpha}: {found:?}");
            assert!((found[1] / nonlinear - 1.0).abs() < 0.012, "{ior} {alpha}: {found:?}");
        }
    }

    #[test]
    fn a_smooth_layer_gains_nothing() {
        let smooth = crate::whole::inner_reflectance(1.5);
        let (gain, inner) = RoughLayer::new(0.0, 1.5).gain(smooth);
        // In a linear file ρ stays ρ.
        assert!((gain / (1.0 - inner) - 1.0).abs() < 0.05, "{gain} {inner}");
    }
}
