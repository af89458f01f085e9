//! Fresnel reflectance of dielectrics and metals. All cosines are within 0..=1.
//!
//! ```text
//!         |  θi /            η = n2 / n1
//!   n1    |    /
//!   ------|---/---------     Snell: sin θi = η sin θt
//!   n2   /|                  total reflection where sin θi ≥ η
//!       / | θt
//! ```

use super::Rgb;
use super::mixture::GAUSS;
use crate::color::Spectrum;
use crate::math::elementary::ln;

/// Unpolarised reflectance of an interface between dielectrics; `eta` is the index behind it over that in front. 1
/// beyond the critical angle, 0 for equal indices.
pub(super) fn dielectric(cos: f64, eta: f64) -> f64 {
    if eta == 1.0 {
        return 0.0;
    }
    if eta == f64::INFINITY {
        return 1.0;
    }
    let (s, p) = amplitudes(cos, eta);
    0.5 * (s * s + p * p)
}

/// Amplitudes of reflected light, polarised perpendicular (s) and parallel (p) to the plane of incidence; 1 beyond the
/// critical angle.
pub(super) fn amplitudes(cos: f64, eta: f64) -> (f64, f64) {
    let cos = cos.clamp(0.0, 1.0);
    let Some(cos_t) = refracted_cosine(cos, eta) else { return (1.0, 1.0) };
    let s = (cos - eta * cos_t) / (cos + eta * cos_t);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t);
    // At grazing angles with equal indices both denominators vanish.
    if s.is_finite() && p.is_finite() { (s, p) } else { (1.0, 1.0) }
}

/// Cosine of the refracted direction; `None` beyond the critical angle.
pub(super) fn refracted_cosine(cos: f64, eta: f64) -> Option<f64> {
    let sin2 = (1.0 - cos * cos).max(0.0) / (eta * eta);
    (sin2 < 1.0).then(|| (1.0 - sin2).sqrt())
}

/// Cosine-weighted mean reflectance, ∫ F(µ) 2µ dµ, for `eta` >= 1 (Dunkle 1963).
pub(super) fn dielectric_average(eta: f64) -> f64 {
    let n = eta;
    if n < 1.0 + 1e-4 {
        return 0.0;
    }
    if n > 1e4 {
        return 1.0;
    }
    let (n2, n4) = (n * n, n * n * n * n);
    let average = 0.5
        + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * (n2 - 1.0) * (n2 - 1.0) / ((n2 + 1.0) * (n2 + 1.0) * (n2 + 1.0)) * ln((n - 1.0) / (n + 1.0))
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0) * (n4 - 1.0)) * ln(n);
    average.clamp(0.0, 1.0)
}

/// Reflectance at normal incidence, ((η − 1)/(η + 1))².
pub(super) fn f0(eta: f64) -> f64 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// The index whose F₀ is `scale` times that of `eta`, on the same side of 1 (OpenPBR's `specular_weight`); infinite
/// where all light would be reflected.
pub(super) fn scaled_index(eta: f64, scale: f64) -> f64 {
    let f0 = f0(eta) * scale;
    if f0 >= 0.9999 {
        return f64::INFINITY;
    }
    let r = f0.sqrt() * if eta < 1.0 { -1.0 } else { 1.0 };
    (1.0 + r) / (1.0 - r)
}

/// Unpolarised reflectance of a metal in air, by its index of refraction `eta` + i `k`, at a cosine greater than 0; 1
/// where the equations have no value.
#[inline]
pub fn conductor(cos: f64, eta: f64, k: f64) -> f64 {
    let cos2 = cos * cos;
    let sin2 = 1.0 - cos2;
    let real = eta * eta - k * k - sin2;
    let a2b2 = (real * real + 4.0 * (eta * eta) * (k * k)).sqrt();
    let a = (0.5 * (a2b2 + real)).max(0.0).sqrt();
    let (sum, cross) = (a2b2 + cos2, 2.0 * a * cos);
    let s = (sum - cross) / (sum + cross);
    let (sum, cross) = (cos2 * a2b2 + sin2 * sin2, cross * sin2);
    let p = s * (sum - cross) / (sum + cross);
    let f = 0.5 * (s + p);
    if f.is_finite() { f.clamp(0.0, 1.0) } else { 1.0 }
}

/// The index of refraction of a metal by colour band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalIndex {
    /// Real part, η.
    pub(super) eta: Rgb,
    /// Imaginary part.
    pub(super) k: Rgb,
    /// Cosine-weighted mean reflectance.
    average: Rgb,
}

impl MetalIndex {
    /// Values are clamped to 0..=100; NaN counts as 0.
    pub fn new(eta: Spectrum, k: Spectrum) -> MetalIndex {
        let sound = |v: f32| if v > 0.0 { f64::from(v).min(100.0) } else { 0.0 };
        let (eta, k) = (Rgb::from(eta.to_array().map(sound)), Rgb::from(k.to_array().map(sound)));
        let band = |i: usize| -> f64 {
            GAUSS.iter().map(|(mu, w)| 2.0 * mu * w * conductor(*mu, eta[i], k[i])).sum()
        };
        MetalIndex { eta, k, average: Rgb::new(band(0), band(1), band(2)).min(Rgb::ONE) }
    }

    /// Reflectance at a cosine.
    fn at(&self, cos: f64) -> Rgb {
        let band = |i: usize| conductor(cos, self.eta[i], self.k[i]);
        Rgb::new(band(0), band(1), band(2))
    }
}

/// A metal by its F₀ and its tint at 82° (Kutz, Hašan and Edmondson 2021, "Novel aspects of the Adobe Standard
/// Material": F82-tint): F(µ) = F₀ + (1 − F₀)(1 − µ)⁵ − b µ (1 − µ)⁶, multiplied by a weight. Or by its index of refraction,
/// multiplied by a colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Metal {
    /// Reflectance at normal incidence.
    pub(super) f0: Rgb,
    /// b, the factor of (1 − µ)⁶ µ.
    pub(super) dip: Rgb,
    /// Factor of the result.
    pub(super) weight: f64,
    /// The index of refraction and the colour, which replace F₀ and the tint.
    pub(super) index: Option<(MetalIndex, Rgb)>,
}

/// The cosine of the tint, at 82°.
const MU_TINT: f64 = 1.0 / 7.0;

impl Metal {
    /// From colours within 0..=1.
    pub(super) fn new(f0: Rgb, tint: Rgb, weight: f64) -> Metal {
        let one = 1.0 - MU_TINT;
        let five = one * one * one * one * one;
        let schlick = f0 + (Rgb::ONE - f0) * five;
        Metal { f0, dip: schlick * (Rgb::ONE - tint) / (MU_TINT * five * one), weight, index: None }
    }

    /// From an index of refraction and a colour within 0..=1, the factor of reflectance at all angles.
    pub(super) fn of_index(index: MetalIndex, color: Rgb, weight: f64) -> Metal {
        let f0 = index.at(1.0) * color;
        Metal { f0, dip: Rgb::ZERO, weight, index: Some((index, color)) }
    }

    /// Reflectance at a cosine.
    pub(super) fn at(&self, cos: f64) -> Rgb {
        self.colour(cos) * self.weight
    }

    /// Reflectance without the weight.
    pub(super) fn colour(&self, cos: f64) -> Rgb {
        if let Some((index, color)) = &self.index {
            return index.at(cos) * *color;
        }
        let c = (1.0 - cos).clamp(0.0, 1.0);
        let c5 = c * c * c * c * c;
        let f = self.f0 + (Rgb::ONE - self.f0) * c5 - self.dip * (cos.clamp(0.0, 1.0) * c5 * c);
        f.clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// Cosine-weighted mean reflectance.
    pub(super) fn average(&self) -> Rgb {
        if let Some((index, color)) = &self.index {
            return index.average * *color * self.weight;
        }
        let f = self.f0 + (Rgb::ONE - self.f0) / 21.0 - self.dip / 126.0;
        f.clamp(Rgb::ZERO, Rgb::ONE) * self.weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn average(f: impl Fn(f64) -> f64) -> f64 {
        let n = 20_000;
        (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n)).map(|mu| f(mu) * 2.0 * mu).sum::<f64>()
            / f64::from(n)
    }

    #[test]
    fn glass_at_known_angles() {
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-12);
        assert!((dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-12);
        assert!((dielectric(0.0, 1.5) - 1.0).abs() < 1e-12);
        assert_eq!(dielectric(0.5, 1.0 / 1.5), 1.0);
        assert_eq!(dielectric(0.0, 1.0), 0.0);
        // Brewster's angle, tan θ = η: parallel polarised light is not reflected.
        let brewster = 1.0 / (1.0f64 + 2.25).sqrt();
        assert!(amplitudes(brewster, 1.5).1.abs() < 1e-12);
    }

    #[test]
    fn averages_are_the_integrals() {
        for eta in [1.0, 1.0002, 1.01, 1.1, 1.33, 1.5, 2.4, 10.0, 100.0] {
            let (closed, summed) = (dielectric_average(eta), average(|mu| dielectric(mu, eta)));
            assert!((closed - summed).abs() < 2e-4, "{eta}: {closed} and {summed}");
        }
        let metal = Metal::new(Rgb::new(0.9, 0.5, 0.1), Rgb::new(0.8, 1.0, 0.9), 0.9);
        for band in 0..3 {
            assert!((metal.average()[band] - average(|mu| metal.at(mu)[band])).abs() < 1e-4);
        }
    }

    #[test]
    fn a_metal_has_its_colours_head_on_at_82_degrees_and_at_grazing() {
        let (f0, tint) = (Rgb::new(0.9, 0.5, 0.1), Rgb::new(0.8, 1.0, 0.9));
        let (metal, plain) = (Metal::new(f0, tint, 1.0), Metal::new(f0, Rgb::ONE, 1.0));
        assert!((metal.at(1.0) - f0).length() < 1e-12);
        assert!((metal.at(MU_TINT) - plain.at(MU_TINT) * tint).length() < 1e-12);
        assert!((metal.at(0.0) - Rgb::ONE).length() < 1e-12);
    }

    #[test]
    fn conductors_follow_the_fresnel_equations() {
        // Without absorption they are dielectrics.
        for cos in [0.05, 0.3, 0.6, 1.0] {
            assert!((conductor(cos, 1.5, 0.0) - dielectric(cos, 1.5)).abs() < 1e-12, "{cos}");
        }
        // F₀ = ((η − 1)² + k²) / ((η + 1)² + k²).
        let (eta, k) = (0.9, 6.0);
        let expected = ((eta - 1.0f64) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
        assert!((conductor(1.0, eta, k) - expected).abs() < 1e-12);
        let index = MetalIndex::new(Spectrum::new(0.2, 1.4, 3.0), Spectrum::new(4.0, 1.6, 0.5));
        let color = Rgb::new(1.0, 0.5, 0.8);
        let metal = Metal::of_index(index, color, 0.9);
        for band in 0..3 {
            assert!((metal.average()[band] - average(|mu| metal.at(mu)[band])).abs() < 1e-4, "{band}");
        }
        assert!(
            (metal.at(0.4).y - 0.45 * conductor(0.4, f64::from(1.4f32), f64::from(1.6f32))).abs() < 1e-12
        );
    }

    #[test]
    fn scaled_index_scales_f0() {
        for eta in [0.7, 1.0, 1.5, 2.4] {
            assert!((f0(scaled_index(eta, 0.3)) - 0.3 * f0(eta)).abs() < 1e-12);
            assert_eq!(scaled_index(eta, 1.0) < 1.0, eta < 1.0);
        }
        assert_eq!(scaled_index(1.5, 1000.0), f64::INFINITY);
    }
}
