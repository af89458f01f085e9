//! The GGX (Trowbridge-Reitz) distribution of microfacet normals, isotropic or anisotropic, with Smith's masking
//! (Walter et al. 2007; Heitz 2014, "Understanding the masking-shadowing function in microfacet-based BRDFs").
//!
//! Sampling the distribution of visible normals (VNDF, Heitz 2018) picks a facet as often as wo sees it, so that the
//! weight of a sample is F·G2/G1 ≤ 1. GGX is an ellipsoid's distribution: scaling x and y by α turns the ellipsoid into
//! a unit hemisphere and wo into wo'. From wo', a hemisphere of normals is visible such that the reflections of wo'
//! about them fill a spherical cap uniformly (Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical
//! caps"):
//!
//! ```text
//!         z                1. wo' = normalize(αx wo.x, αy wo.y, wo.z)
//!    .----|----.           2. c = uniform point of the cap { z ≥ −wo'.z } of the unit sphere
//!   /  cap|  c  \          3. h' = c + wo'       (half vector, not normalised)
//!   |     o     |          4. h = normalize(αx h'.x, αy h'.y, h'.z)
//!   \...........\ z = −wo'.z
//! ```

use crate::math::DVec3;
#[cfg(test)]
use crate::math::elementary::sin_cos;
use crate::math::elementary::sin_cos_turns;
use std::f64::consts::PI;

/// Widths α of the distribution along x and y, each greater than 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ggx {
    /// Along the tangent.
    pub(super) ax: f64,
    /// Along the bitangent.
    pub(super) ay: f64,
}

impl Ggx {
    /// Facet area per unit of surface area and solid angle around `h` (upper hemisphere): ∫ D cos θ = 1.
    pub(super) fn d(&self, h: DVec3) -> f64 {
        let (x, y) = (h.x / self.ax, h.y / self.ay);
        let s = x * x + y * y + h.z * h.z;
        1.0 / (PI * self.ax * self.ay * s * s)
    }

    /// Smith's Λ of a direction: invisible over visible facet area.
    pub(super) fn lambda(&self, w: DVec3) -> f64 {
        let (x, y) = (self.ax * w.x, self.ay * w.y);
        let t2 = (x * x + y * y) / (w.z * w.z);
        0.5 * ((1.0 + t2).sqrt() - 1.0)
    }

    /// A normal sampled from those visible from `wo` (wo.z > 0). `u` in 0..1.
    pub(super) fn sample_visible(&self, wo: DVec3, u: [f64; 2]) -> DVec3 {
        let stretched = DVec3::new(self.ax * wo.x, self.ay * wo.y, wo.z).normalize();
        let z = (1.0 - u[0]) * (1.0 + stretched.z) - stretched.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turns(u[1]);
        let cap = DVec3::new(r * cos, r * sin, z) + stretched;
        let h = DVec3::new(self.ax * cap.x, self.ay * cap.y, cap.z.max(0.0));
        let length = h.length();
        if length > 0.0 { h / length } else { DVec3::Z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distribution_and_its_visible_area_are_normalised() {
        for (ax, ay) in [(0.2, 0.2), (0.5, 0.1), (1.0, 1.0)] {
            let ggx = Ggx { ax, ay };
            let wo = DVec3::new(0.5, 0.3, 0.4).normalize();
            let (mut projected, mut visible) = (0.0, 0.0);
            let n = 1000;
            for i in 0..n {
                for j in 0..n {
                    let z = (f64::from(i) + 0.5) / f64::from(n);
                    let (s, c) = sin_cos(2.0 * PI * (f64::from(j) + 0.5) / f64::from(n));
                    let r = (1.0 - z * z).sqrt();
                    let h = DVec3::new(r * c, r * s, z);
                    let cell = 2.0 * PI / f64::from(n * n);
                    projected += ggx.d(h) * h.z * cell;
                    visible += wo.dot(h).max(0.0) * ggx.d(h) / ((1.0 + ggx.lambda(wo)) * wo.z) * cell;
                }
            }
            assert!((projected - 1.0).abs() < 2e-3, "{ax} {ay}: {projected}");
            assert!((visible - 1.0).abs() < 2e-3, "{ax} {ay}: {visible}");
        }
    }
}
