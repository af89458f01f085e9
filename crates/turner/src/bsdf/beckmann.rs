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

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

use crate::math::DVec3;
use crate::math::elementary::exponential;
use crate::math::gaussian::{gaussian_and_tail, inverse_erf, inverse_erf_start};

/// Facets with a smaller square of the cosine have no share.
pub(super) const MIN_Z2: f64 = 1e-12;
/// Up to this tan θ · α, the Λ of a direction is below the smallest positive number.
pub(super) const MIN_SLOPE: f64 = 1e-3;
/// Slopes beyond this one have a share below 1e-16.
pub(super) const MAX_SLOPE: f64 = 6.0;
/// From this cot θ / α on, all facets count as visible by their area; the error is below 1e-9.
pub(super) const MAX_COT: f64 = 1e9;
/// √π / 2.
pub(super) const HALF_ROOT_PI: f64 = 0.886_226_925_452_758;
/// A slope is found if this is its error as a part of all facets.
pub(super) const ENOUGH: f64 = 1e-11;
/// A slope is found after a step of this part of what is left to cot θ: the error is then about the cube of it.
pub(super) const NEAR: f64 = 3e-4;
/// Halley's method takes two steps for nearly all slopes, bisection 50.
pub(super) const MAX_STEPS: u32 = 60;
/// Coefficients of n^i g^j in [`visible_slope_start`], g = 2 / (2 + cot θ), fitted to slopes for 0.001 < u < 0.999.
pub(super) const START: [[f64; 3]; 3] =
    [[-0.9836, -0.3595, 0.6487], [-0.4742, -0.5918, 0.5571], [0.0084, -0.1891, 0.1587]];
/// The cot θ where g = 1/2.
pub(super) const START_COT: f64 = 2.0;

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
        exponential(-(x * x + y * y) / z2) / (PI * self.ax * self.ay * z2 * z2)
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
        let y = inverse_erf(2.0 * u[1] - 1.0).clamp(-MAX_SLOPE, MAX_SLOPE);
        let (sx, sy) = (cos * x - sin * y, sin * x + cos * y);
        DVec3::new(self.ax * sx, self.ay * sy, 1.0).normalize()
    }
}

/// Λ of a direction with this cotangent, in units of 1 / α.
fn lambda(cot: f64) -> f64 {
    let (e, tail) = gaussian_and_tail(cot);
    (0.5 * (e * (0.5 * FRAC_2_SQRT_PI) / cot - tail)).max(0.0)
}

/// The slope x with P(x) = u, by Halley's method within a bracket. `cot` may be infinite.
fn visible_slope(cot: f64, u: f64) -> f64 {
    let cot = if cot < MAX_COT { cot } else { MAX_COT };
    let (mut low, mut high) = (-MAX_SLOPE, if cot < MAX_SLOPE { cot } else { MAX_SLOPE });
    let total = below(cot, high).0;
    let wanted = u * total;
    let start = visible_slope_start(cot, u);
    let mut x = if start > low && start < high { start } else { high - 0.5 };
    for _ in 0..MAX_STEPS {
        let (value, e) = below(cot, x);
        let off = value - wanted;
        if off.abs() <= ENOUGH * total {
            break;
        }
        if off > 0.0 {
            high = x
        } else {
            low = x
        }
        // The density is z e, its derivative −(1 + 2 x z) e.
        let z = cot - x;
        let next = x - off * z / (z * z * e + off * (0.5 + x * z));
        let next = if next >= low && next < high { next } else { 0.5 * (low + high) };
        let near = (next - x).abs() <= NEAR * if z < 1.0 { z } else { 1.0 };
        x = next;
        if near {
            break;
        }
    }
    x
}

/// The visible area of facets below a slope, not normalised, and e^(−x²).
#[inline]
fn below(cot: f64, x: f64) -> (f64, f64) {
    let (e, tail) = gaussian_and_tail(x);
    let share = if x > 0.0 { 2.0 - tail } else { tail };
    (cot * HALF_ROOT_PI * share + 0.5 * e, e)
}

/// About the slope x with P(x) = u: within .1 for most u. √(cot θ + 2 − x) is nearly normally distributed for all θ (for
/// grazing ones, Weibull's distribution with exponent 4), so that it is about linear in the normally distributed n(u).
#[inline]
fn visible_slope_start(cot: f64, u: f64) -> f64 {
    let n = inverse_erf_start(2.0 * u - 1.0);
    let g = START_COT / (cot + START_COT);
    let [a, b, d] = START.map(|c| c[0] + g * (c[1] + g * c[2]));
    let h = a + n * (b + n * d);
    -START_COT - h * (2.0 + h * g / START_COT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::{erf, exp, pow_int, sin_cos};

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

    /// The visible area of facets below a slope, by libm.
    fn area_below(cot: f64, x: f64) -> f64 {
        cot * 0.5 * PI.sqrt() * libm::erfc(-x) + 0.5 * exp(-x * x)
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

    #[test]
    fn slopes_of_any_cotangent_and_number() {
        for i in 0..=400 {
            let cot = pow_int(f64::from(i), 3) * 1e-6;
            let total = area_below(cot, cot.min(MAX_SLOPE));
            let mut last = -MAX_SLOPE;
            for j in 0..=1000 {
                let u = f64::from(j) / 1000.0;
                let x = visible_slope(cot, u);
                assert!((area_below(cot, x) / total - u).abs() < 1e-10, "{cot} {u}: {x}");
                assert!(x >= last, "{cot} {u}: {x} below {last}");
                last = x;
            }
        }
        // Steep directions see the distribution itself.
        for cot in [1e8, MAX_COT, 1e300, f64::INFINITY, f64::NAN] {
            for u in [1e-9, 0.1, 0.5, 0.8, 1.0 - 1e-9] {
                let x = visible_slope(cot, u);
                assert!((0.5 * libm::erfc(-x) - u).abs() < 1e-8, "{cot} {u}: {x}");
            }
        }
    }

    #[test]
    fn density_and_masking_are_those_of_libm() {
        let facets = Beckmann { ax: 0.3, ay: 0.1 };
        for i in 1..2000 {
            let (sin, cos) = sin_cos(f64::from(i) * PI / 4000.0);
            for (s, c) in [(0.0, 1.0), (0.6, 0.8), (-1.0, 0.0)] {
                let w = DVec3::new(sin * c, sin * s, cos);
                let slope2 = ((w.x / 0.3) * (w.x / 0.3) + (w.y / 0.1) * (w.y / 0.1)) / (cos * cos);
                let d = exp(-slope2) / (PI * 0.03 * pow_int(cos, 4));
                assert!((facets.d(w) - d).abs() <= 1e-12 * d + 1e-300, "{w}: {}, not {d}", facets.d(w));
                let (x, y) = (0.3 * w.x, 0.1 * w.y);
                let a = cos / (x * x + y * y).sqrt();
                let lambda = 0.5 * (exp(-a * a) / (a * PI.sqrt()) - libm::erfc(a));
                let got = facets.lambda(w);
                assert!((got - lambda).abs() < 1e-13 * (1.0 + lambda), "{w}: {got}, not {lambda}");
            }
        }
    }
}
