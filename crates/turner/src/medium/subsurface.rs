//! The medium inside a translucent object, from the colour that it should show.

use super::{Coefficients, Homogeneous, PhaseFunction};
use crate::color::Spectrum;

/// Single-scattering albedo of a medium whose half-space reflects the fraction `color` of diffuse light: van de Hulst's
/// formula for the albedo of a semi-infinite medium (Kulla and Conty 2017, "Revisiting physically based shading at
/// Imageworks"), inverted as in OpenPBR 1.1. `g` is the mean cosine of scattering. Without refraction and reflection at
/// the boundary, the colour is correct within 0.0025 for `g` from 0 to 0.95, within 0.01 for −0.5 and within 0.025 for
/// −0.9.
pub fn scattering_albedo(color: f64, g: f64) -> f64 {
    let c = color.clamp(0.0, 1.0);
    let s = 4.09712 + 4.20863 * c - (9.59217 + 41.6808 * c + 17.7126 * c * c).sqrt();
    let s2 = (s * s).min(1.0);
    match c {
        // The constants are rounded, so the ends are set exactly.
        c if c >= 1.0 => 1.0,
        c if c > 0.0 => (1.0 - s2) / (1.0 - g * s2),
        _ => 0.0,
    }
}

impl Homogeneous {
    /// From a colour, the mean free paths by colour band (all above 0) and the mean cosine `g`.
    pub(crate) fn of_body(color: Spectrum, ways: [f64; 3], g: f64) -> Homogeneous {
        let extinction = ways.map(|way| 1.0 / way);
        let colors = color.to_array();
        let scattering = [0, 1, 2].map(|i: usize| extinction[i] * scattering_albedo(f64::from(colors[i]), g));
        Homogeneous {
            coefficients: Coefficients {
                extinction,
                scattering,
                emission: [0.0; 3],
                phase: PhaseFunction::new([g, 0.0], 0.0, 0.0),
            },
        }
    }

    /// Transmittance of each band over the distance `t`, and the probability of passing it for a path of these band
    /// fractions.
    #[inline]
    pub(crate) fn left(&self, shares: [f64; 3], t: f64) -> ([f64; 3], f64) {
        let left = self.band_transmittance(t);
        (left, shares[0] * left[0] + shares[1] * left[1] + shares[2] * left[2])
    }

    /// Scattering of each band at the distance `t`, per unit of length, and the density of that distance for a path of
    /// these band fractions.
    #[inline]
    pub(crate) fn scattered(&self, shares: [f64; 3], t: f64) -> ([f64; 3], f64) {
        let Coefficients { extinction: e, scattering: s, .. } = &self.coefficients;
        let left = self.band_transmittance(t);
        let band = |i: usize| shares[i] * e[i] * left[i];
        ([s[0] * left[0], s[1] * left[1], s[2] * left[2]], band(0) + band(1) + band(2))
    }

    /// The phase function.
    #[inline]
    pub(crate) fn phase(&self) -> PhaseFunction {
        self.coefficients.phase
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_albedo_lies_between_black_and_white() {
        for g in [-0.999, -0.5, 0.0, 0.5, 0.999] {
            assert_eq!(scattering_albedo(0.0, g), 0.0);
            assert_eq!(scattering_albedo(1.0, g), 1.0);
            let mut last = -1.0;
            for i in 0..=1000 {
                let a = scattering_albedo(f64::from(i) / 1000.0, g);
                assert!(a > last && (0.0..=1.0).contains(&a), "{g} {i}: {a}");
                last = a;
            }
        }
    }
}
