//! Media that are the same everywhere.

use super::{Coefficients, Stretch, Walk};
use crate::color::Spectrum;
use crate::math::elementary::{exp, ln};
use crate::schema::{Range, SceneError, params};

params! {
    /// A medium that is the same everywhere: fog, murky water, wax. What it does to light is said either by `extinction` and `albedo`
    /// or by `absorption` and `scattering`, each per unit of length and by colour.
    pub struct HomogeneousMedium as "homogeneous" {
        /// A factor of all coefficients and of the emission.
        density: f64 = 1.0, in Range::closed(0.0, 1e30);
        /// What is lost per unit of length, absorbed or scattered: 1 over the mean way of light. 1 if nothing else says it.
        extinction: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// The share of that which is scattered, not absorbed: 0 is black smoke, 1 a white cloud.
        albedo: Option<Spectrum> = None, in Range::UNIT;
        /// In place of `extinction` and `albedo`: what is absorbed per unit of length.
        absorption: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// In place of `extinction` and `albedo`: what is scattered per unit of length.
        scattering: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// The mean cosine g of Henyey and Greenstein's phase function: 0 scatters evenly, haze and cloud go forwards (0.7 to 0.9), below 0 backwards.
        anisotropy: f64 = 0.0, in Range::closed(-0.999, 0.999);
        /// Radiance that it emits per unit of length.
        emission: Spectrum = Spectrum::BLACK, in Range::closed(0.0, 1e15);
    }
    example r##"[medium.fog]
extinction = 0.2
albedo = [0.9, 0.92, 0.95]
anisotropy = 0.6

[[object]]
type = "box"
medium = "fog"

[[object]]
type = "sphere"
radius = 0.3
material = { type = "emissive", color = "gold" }
"##
}

/// A medium that is the same everywhere, ready.
#[derive(Clone, Debug)]
pub struct Homogeneous {
    pub(super) coefficients: Coefficients,
}

impl HomogeneousMedium {
    /// Makes it ready.
    ///
    /// Errors: both ways to say the coefficients at once.
    pub fn prepare(&self) -> Result<Homogeneous, SceneError> {
        let coefficients = Coefficients::new(
            self.density,
            [self.extinction, self.albedo],
            [self.absorption, self.scattering],
            self.anisotropy,
            self.emission,
        )?;
        Ok(Homogeneous { coefficients })
    }
}

/// e^(−σ·t), for 0 · ∞ as well.
#[inline]
fn left(sigma: f64, t: f64) -> f64 {
    if sigma == 0.0 { 1.0 } else { exp(-sigma * t) }
}

/// ∫ e^(−σ·s) ds over 0 to t: the length that still shines through.
#[inline]
fn shining_length(sigma: f64, t: f64) -> f64 {
    let depth = sigma * t;
    if sigma == 0.0 || depth < 1e-5 {
        // Nothing that has no end and does not absorb shines: its light would be infinite.
        return if t < f64::INFINITY { t * (1.0 - 0.5 * depth) } else { 0.0 };
    }
    (1.0 - left(sigma, t)) / sigma
}

/// What a path finds at a place of its way.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Density with which paths of the given shares scatter there, per unit of length.
    pub pdf: f64,
    /// What is scattered per unit of length there, of what began the way.
    pub scattered: Spectrum,
}

impl Homogeneous {
    /// One that does nothing.
    pub(super) fn void() -> Homogeneous {
        let none = [0.0; 3];
        let phase = super::HenyeyGreenstein { g: 0.0 };
        Homogeneous {
            coefficients: Coefficients { extinction: none, scattering: none, emission: none, phase },
        }
    }

    /// What is left after a way of length `t`, by band.
    #[inline]
    pub(super) fn bands_left(&self, t: f64) -> [f64; 3] {
        let [r, g, b] = self.coefficients.extinction;
        if r == g && g == b {
            return [left(r, t); 3];
        }
        [left(r, t), left(g, t), left(b, t)]
    }

    /// The share of light that is left after a way of length `t`.
    #[inline]
    pub fn transmittance(&self, t: f64) -> Spectrum {
        Spectrum::from(self.bands_left(t).map(|v| v as f32))
    }

    /// The place at a way of length `t`, for a path of these shares by band.
    #[inline]
    pub fn place(&self, shares: [f64; 3], t: f64) -> Place {
        let c = &self.coefficients;
        let left = self.bands_left(t);
        let pdf = (0..3).map(|i| shares[i] * c.extinction[i] * left[i]).sum();
        let band = |i: usize| (c.scattering[i] * left[i]) as f32;
        Place { pdf, scattered: Spectrum::from([band(0), band(1), band(2)]) }
    }

    /// The mean way of light in the band that is stopped soonest; infinite where nothing stops it.
    #[inline]
    pub fn mean_free_path(&self) -> f64 {
        let [a, b, c] = self.coefficients.extinction;
        1.0 / a.max(b).max(c)
    }

    /// A way through it, of which `u` chooses the band and the length. One band is chosen by its share, and what is found counts as if all bands had
    /// been tried (one-sample MIS with the balance heuristic, Veach 1997, section 9.2.4).
    #[inline]
    pub fn walk(&self, stretch: &Stretch<'_>, u: [f64; 2]) -> Walk {
        let end = stretch.end;
        let emitted = self.emitted(end);
        if !stretch.scatters {
            return Walk { scattered: None, weight: self.transmittance(end), pdf: 0.0, emitted };
        }
        let t = self.distance(stretch.shares, u);
        if t < end {
            let (weight, pdf) = self.scattered_at(stretch.shares, t);
            return Walk { scattered: Some(t), weight, pdf, emitted };
        }
        let weight = self.passed(stretch.shares, end);
        Walk { scattered: None, weight, pdf: 0.0, emitted }
    }

    /// A distance at which a path of these shares by band is scattered; `u` chooses the band and the length.
    #[inline]
    pub fn distance(&self, shares: [f64; 3], u: [f64; 2]) -> f64 {
        let s = self.coefficients.extinction;
        let band = match u[0] {
            u if u < shares[0] => 0,
            u if u < shares[0] + shares[1] => 1,
            _ => 2,
        };
        // Roundings choose no band that is black.
        let band = if shares[band] > 0.0 { band } else { (0..3).find(|i| shares[*i] > 0.0).unwrap_or(0) };
        if s[band] > 0.0 { -ln(1.0 - u[1]) / s[band] } else { f64::INFINITY }
    }

    /// The weight of a path that is scattered at such a distance, and the density of that.
    #[inline]
    pub fn scattered_at(&self, shares: [f64; 3], t: f64) -> (Spectrum, f64) {
        let place = self.place(shares, t);
        let weight =
            if place.pdf > 0.0 { place.scattered * (1.0 / place.pdf) as f32 } else { Spectrum::BLACK };
        // Where next to nothing arrives, the density is too small for single precision.
        (if weight.is_finite() { weight } else { Spectrum::BLACK }, place.pdf)
    }

    /// The weight of a path whose distance is larger than `end`.
    #[inline]
    pub fn passed(&self, shares: [f64; 3], end: f64) -> Spectrum {
        let through = self.bands_left(end);
        let probability: f64 = (0..3).map(|i| shares[i] * through[i]).sum();
        let weight = if probability > 0.0 { through.map(|v| (v / probability) as f32) } else { [0.0; 3] };
        Spectrum::from(weight)
    }

    /// The radiance that it emits along a way of length `t`, as it arrives at its begin.
    #[inline]
    fn emitted(&self, t: f64) -> Spectrum {
        let c = &self.coefficients;
        if !c.emits() {
            return Spectrum::BLACK;
        }
        let band = |i: usize| (c.emission[i] * shining_length(c.extinction[i], t)) as f32;
        Spectrum::from([band(0), band(1), band(2)])
    }
}
