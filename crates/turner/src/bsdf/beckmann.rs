//! Beckmann's distribution of microfacet normals, isotropic or anisotropic, with Smith's masking (Beckmann and Spizzichino
//! 1963; Walter et al. 2007; Heitz 2014). The slopes of its facets are normally distributed: highlights end without the
//! long tail of GGX.
//!
//! Visible normals (Jakob 2014, "An improved visible normal sampling routine for the Beckmann distribution") are sampled as
//! slopes of the stretched surface, whose α is 1. With wo in the xz plane, the slope across is independent of wo, and that
//! along has the density (cot θ − x) e^(−x²) below cot θ: facets with greater slopes face away.
//!
//! ```text
//!        wo            a facet of slope x has the normal ∝ (x, y, 1); wo sees (cot θ + x) of it
//!       /  θ|
//!      /    |  __      P(x) ∝ c √π/2 (1 + erf x) + e^(−x²)/2,   c = cot θ, x = −slope
//!   __/--\__|_/
//! ```

use std::f64::consts::PI;

use crate::math::DVec3;
use crate::math::elementary::{erf, erf_inv, exp};

/// Facets with a smaller square of the cosine have no share.
pub(super) const MIN_Z2: f64 = 1e-12;
/// Up to this tan θ · α, the Λ of a direction is below the smallest positive number.
pub(super) const MIN_SLOPE: f64 = 1e-3;
/// Slopes beyond this one have a share below 1e-16.
const MAX_SLOPE: f64 = 6.0;
/// Newton's method needs about six steps, bisection 50.
const MAX_STEPS: u32 = 60;

/// Widths α of the distribution along x and y, each greater than 0: √2 times the standard deviations of the slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beckmann {
    pub(super) ax: f64,
    pub(super) ay: f64,
}

impl Beckmann {
    /// Facet area per unit of surface area and solid angle around `h` (upper hemisphere): ∫ D cos θ = 1.
    pub(super) fn d(&self, h: DVec3) -> f64 {
        let z2 = h.z * h.z;
        if z2 < MIN_Z2 {
            return 0.0;
        }
        let (x, y) = (h.x / self.ax, h.y / self.ay);
        exp(-(x * x + y * y) / z2) / (PI * self.ax * self.ay * z2 * z2)
    }

    /// Smith's Λ of a direction: invisible over visible facet area.
    pub(super) fn lambda(&self, w: DVec3) -> f64 {
        let (x, y) = (self.ax * w.x, self.ay * w.y);
        let slope = (x * x + y * y).sqrt();
        if slope > MIN_SLOPE * w.z.abs() { lambda(w.z.abs() / slope) } else { 0.0 }
    }

    /// A normal sampled from those visible from `wo` (wo.z > 0). `u` in 0..1.
    pub(super) fn sample_visible(&self, wo: DVec3, u: [f64; 2]) -> DVec3 {
        let stretched = DVec3::new(self.ax * wo.x, self.ay * wo.y, wo.z);
        let across = (stretched.x * stretched.x + stretched.y * stretched.y).sqrt();
        let (cos, sin) = if across > 0.0 { (stretched.x / across, stretched.y / across) } else { (1.0, 0.0) };
        // Towards wo, and across it.
        let x = -visible_slope(stretched.z / across, u[0]);
        let y = erf_inv(2.0 * u[1] - 1.0).clamp(-MAX_SLOPE, MAX_SLOPE);
        let (sx, sy) = (cos * x - sin * y, sin * x + cos * y);
        DVec3::new(self.ax * sx, self.ay * sy, 1.0).normalize()
    }
}

/// Λ of a direction of the slope `a`, in units of α.
pub(super) fn lambda(a: f64) -> f64 {
    (0.5 * (exp(-a * a) / (a * PI.sqrt()) - (1.0 - erf(a)))).max(0.0)
}

/// The slope x with P(x) = u, by Newton's method within a bracket. `cot` may be infinite.
fn visible_slope(cot: f64, u: f64) -> f64 {
    // Steeper than 1e-6: the density is that of the distribution itself.
    if cot.is_nan() || cot > 1e6 {
        return erf_inv(2.0 * u - 1.0).clamp(-MAX_SLOPE, MAX_SLOPE);
    }
    let half_root = 0.5 * PI.sqrt();
    let below = |x: f64| {
        let e = exp(-x * x);
        (cot * half_root * (1.0 + erf(x)) + 0.5 * e, (cot - x) * e)
    };
    let (mut low, mut high) = (-MAX_SLOPE, cot.min(MAX_SLOPE));
    let wanted = u * below(high).0;
    let mut x = low.max(0.5 * (high - 1.0)).min(high);
    for _ in 0..MAX_STEPS {
        let (value, density) = below(x);
        let off = value - wanted;
        if off > 0.0 {
            high = x
        } else {
            low = x
        }
        let next = x - off / density;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - x).abs() < 1e-11 {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::sin_cos;

    #[test]
    fn the_distribution_and_its_visible_area_are_normalised() {
        for (ax, ay) in [(0.2, 0.2), (0.5, 0.1), (1.0, 1.0)] {
            let facets = Beckmann { ax, ay };
            for wo in [DVec3::new(0.5, 0.3, 0.4), DVec3::new(-0.9, 0.2, 0.1), DVec3::Z] {
                let wo = wo.normalize();
                let (mut projected, mut visible) = (0.0, 0.0);
                let n = 1000;
                for i in 0..n {
                    for j in 0..n {
                        let z = (f64::from(i) + 0.5) / f64::from(n);
                        let (s, c) = sin_cos(2.0 * PI * (f64::from(j) + 0.5) / f64::from(n));
                        let r = (1.0 - z * z).sqrt();
                        let h = DVec3::new(r * c, r * s, z);
                        let d = facets.d(h) * 2.0 * PI / f64::from(n * n);
                        projected += d * z;
                        visible += d * wo.dot(h).max(0.0) / ((1.0 + facets.lambda(wo)) * wo.z);
                    }
                }
                assert!((projected - 1.0).abs() < 2e-3, "{ax} {ay}: {projected}");
                assert!((visible - 1.0).abs() < 2e-3, "{ax} {ay} {wo}: {visible}");
            }
        }
    }

    #[test]
    fn slopes_invert_their_distribution() {
        let half_root = 0.5 * PI.sqrt();
        for cot in [0.0, 1e-3, 0.1, 1.0, 5.0, 300.0] {
            let below = |x: f64| cot * half_root * (1.0 + erf(x)) + 0.5 * exp(-x * x);
            for u in [0.0, 1e-9, 0.01, 0.3, 0.5, 0.9, 0.999_999, 1.0 - f64::EPSILON] {
                let x = visible_slope(cot, u);
                assert!(x <= cot && x.abs() <= MAX_SLOPE, "{cot} {u}: {x}");
                assert!((below(x) / below(cot.min(MAX_SLOPE)) - u).abs() < 1e-10, "{cot} {u}: {x}");
            }
        }
    }
}
