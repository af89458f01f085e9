//! Homogeneous media. Beer-Lambert transmittance e^(−σt·t); free paths are sampled exactly.

use super::{Coefficients, PhaseFunction, RaySegment, Walk};
use crate::color::Spectrum;
use crate::math::elementary::{exp, ln};
use crate::schema::{Range, SceneError, params};

params! {
    /// A medium with the same density everywhere: fog, murky water, wax. Give either `extinction` and `albedo` or
    /// `absorption` and `scattering`, each per scene unit and by colour.
    pub struct HomogeneousMedium as "homogeneous" {
        /// Factor of all coefficients and of the emission.
        density: f64 = 1.0, in Range::closed(0.0, 1e30);
        /// Extinction coefficient (absorption + scattering) per scene unit, by colour: 1 / mean free path. 1 if no
        /// coefficient is given.
        extinction: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// Single-scattering albedo, by colour: the fraction of the extinction that is scattered. 0 is black smoke, 1 a
        /// white cloud. 1 if not given.
        albedo: Option<Spectrum> = None, in Range::UNIT;
        /// Absorption coefficient per scene unit, by colour; with `scattering`, instead of `extinction` and `albedo`.
        absorption: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// Scattering coefficient per scene unit, by colour; with `absorption`, instead of `extinction` and `albedo`.
        scattering: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// Mean cosine g of the Henyey-Greenstein phase function: 0 is isotropic, 0.7 to 0.9 is haze and cloud
        /// (forward), below 0 backward.
        anisotropy: f64 = 0.0, in Range::closed(-0.999, 0.999);
        /// Mean cosine of a second Henyey-Greenstein lobe: clouds have one that scatters back.
        second_anisotropy: f64 = 0.0, in Range::closed(-0.999, 0.999);
        /// Fraction of light that the second lobe scatters.
        second_weight: f64 = 0.0, in Range::UNIT;
        /// Fraction of light that is scattered by Rayleigh's phase function, as by particles much smaller than the
        /// wavelength: 1 is clear air. The lobes above share the rest.
        rayleigh: f64 = 0.0, in Range::UNIT;
        /// Emitted radiance per scene unit.
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

/// A prepared homogeneous medium.
#[derive(Clone, Debug)]
pub struct Homogeneous {
    pub(super) coefficients: Coefficients,
}

impl HomogeneousMedium {
    /// Prepares the medium.
    ///
    /// Errors: both pairs of coefficients at once.
    pub fn prepare(&self) -> Result<Homogeneous, SceneError> {
        let coefficients = Coefficients::new(
            self.density,
            [self.extinction, self.albedo],
            [self.absorption, self.scattering],
            PhaseFunction::new([self.anisotropy, self.second_anisotropy], self.second_weight, self.rayleigh),
            self.emission,
        )?;
        Ok(Homogeneous { coefficients })
    }
}

/// e^(−σ·t), also for 0 · ∞.
#[inline]
fn beam_transmittance(sigma: f64, t: f64) -> f64 {
    if sigma == 0.0 { 1.0 } else { exp(-sigma * t) }
}

/// ∫ e^(−σ·s) ds from 0 to t: the effective length of emission.
#[inline]
fn emission_length(sigma: f64, t: f64) -> f64 {
    let depth = sigma * t;
    if sigma == 0.0 || depth < 1e-5 {
        // An infinite medium without absorption would emit infinite light: it emits none.
        return if t < f64::INFINITY { t * (1.0 - 0.5 * depth) } else { 0.0 };
    }
    (1.0 - beam_transmittance(sigma, t)) / sigma
}

/// Scattering at one distance.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Density with which paths of the given band fractions scatter there, per unit of length.
    pub pdf: f64,
    /// Fraction scattered per unit of length there, of what entered the segment: σs · transmittance.
    pub scattered: Spectrum,
}

impl Homogeneous {
    /// A medium without effect.
    pub(super) fn void() -> Homogeneous {
        let none = [0.0; 3];
        let phase = PhaseFunction::ISOTROPIC;
        Homogeneous {
            coefficients: Coefficients { extinction: none, scattering: none, emission: none, phase },
        }
    }

    /// Transmittance over the length `t`, by band.
    #[inline]
    pub(super) fn band_transmittance(&self, t: f64) -> [f64; 3] {
        let [r, g, b] = self.coefficients.extinction;
        if r == g && g == b {
            return [beam_transmittance(r, t); 3];
        }
        [beam_transmittance(r, t), beam_transmittance(g, t), beam_transmittance(b, t)]
    }

    /// Transmittance over the length `t`.
    #[inline]
    pub fn transmittance(&self, t: f64) -> Spectrum {
        Spectrum::from(self.band_transmittance(t).map(|v| v as f32))
    }

    /// Scattering at the distance `t`, for a path of these band fractions.
    #[inline]
    pub fn place(&self, shares: [f64; 3], t: f64) -> Place {
        let c = &self.coefficients;
        let transmittance = self.band_transmittance(t);
        let pdf = (0..3).map(|i| shares[i] * c.extinction[i] * transmittance[i]).sum();
        let band = |i: usize| (c.scattering[i] * transmittance[i]) as f32;
        Place { pdf, scattered: Spectrum::from([band(0), band(1), band(2)]) }
    }

    /// Mean free path of the band with the greatest extinction; infinite without extinction.
    #[inline]
    pub fn mean_free_path(&self) -> f64 {
        let [a, b, c] = self.coefficients.extinction;
        1.0 / a.max(b).max(c)
    }

    /// Samples scattering along a segment; `u` chooses the band and the distance. A band is chosen by its fraction of
    /// the throughput, and the density is that of all bands together (one-sample MIS with the balance heuristic, Veach
    /// 1997, §9.2.4).
    #[inline]
    pub fn walk(&self, stretch: &RaySegment<'_>, u: [f64; 2]) -> Walk {
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

    /// A free path for a path of these band fractions; `u` chooses the band and the distance.
    #[inline]
    pub fn distance(&self, shares: [f64; 3], u: [f64; 2]) -> f64 {
        let s = self.coefficients.extinction;
        let band = match u[0] {
            u if u < shares[0] => 0,
            u if u < shares[0] + shares[1] => 1,
            _ => 2,
        };
        // Rounding must not choose a black band.
        let band = if shares[band] > 0.0 { band } else { (0..3).find(|i| shares[*i] > 0.0).unwrap_or(0) };
        if s[band] > 0.0 { -ln(1.0 - u[1]) / s[band] } else { f64::INFINITY }
    }

    /// Weight of a path that scatters at the distance `t`, and the density of that.
    #[inline]
    pub fn scattered_at(&self, shares: [f64; 3], t: f64) -> (Spectrum, f64) {
        let place = self.place(shares, t);
        let weight =
            if place.pdf > 0.0 { place.scattered * (1.0 / place.pdf) as f32 } else { Spectrum::BLACK };
        // Where the transmittance is tiny, the density underflows in single precision.
        (if weight.is_finite() { weight } else { Spectrum::BLACK }, place.pdf)
    }

    /// Weight of a path that passes `end` without scattering.
    #[inline]
    pub fn passed(&self, shares: [f64; 3], end: f64) -> Spectrum {
        let through = self.band_transmittance(end);
        let probability: f64 = (0..3).map(|i| shares[i] * through[i]).sum();
        let weight = if probability > 0.0 { through.map(|v| (v / probability) as f32) } else { [0.0; 3] };
        Spectrum::from(weight)
    }

    /// Radiance emitted along the length `t`, as it arrives at the start of the segment.
    #[inline]
    fn emitted(&self, t: f64) -> Spectrum {
        let c = &self.coefficients;
        if !c.emits() {
            return Spectrum::BLACK;
        }
        let band = |i: usize| (c.emission[i] * emission_length(c.extinction[i], t)) as f32;
        Spectrum::from([band(0), band(1), band(2)])
    }
}
