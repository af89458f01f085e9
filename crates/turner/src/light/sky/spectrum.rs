//! Sunlight and atmospheric extinction at sixteen wavelengths, and conversion to colours.
//!
//! RGB is too coarse for this: twilight and the blue of the zenith depend on narrow parts of the spectrum (ozone
//! absorbs orange), and light that crossed much air is far from what three values can represent. Light is therefore
//! computed at sixteen wavelengths and converted to a colour at the end.

use crate::color::Spectrum;
use crate::color::cie::{linear_srgb, matching};
use crate::math::elementary::pow;

/// Number of wavelengths.
pub(super) const BANDS: usize = 16;

/// One value per wavelength.
pub(super) type Bands = [f64; BANDS];

/// Wavelengths in nanometres: the centres of bands 20 wide.
const WAVELENGTHS: Bands =
    [400., 420., 440., 460., 480., 500., 520., 540., 560., 580., 600., 620., 640., 660., 680., 700.];

/// Sunlight above the atmosphere, W m⁻² nm⁻¹ (after ASTM G173-03, extraterrestrial).
const SUN: Bands =
    [1.73, 1.69, 1.91, 2.02, 1.93, 1.92, 1.87, 1.85, 1.83, 1.81, 1.75, 1.68, 1.60, 1.56, 1.47, 1.41];

/// Absorption cross section of ozone at −40 °C, 10⁻²⁷ m² (after Serdyuchenko et al. 2014).
const OZONE: Bands =
    [1.5, 5.5, 15.8, 36.7, 77.5, 148., 214., 309., 427., 440., 502., 374., 266., 185., 121., 74.6];

/// Molecules of ozone per square metre of ground: 300 Dobson units.
const OZONE_COLUMN: f64 = 300.0 * 2.687e20;

/// Vertical optical depth of dust in clear country air at 550 nm; it follows λ^−1.3 (Ångström 1929).
const DUST_DEPTH: f64 = 0.06;

/// Illuminance of the sun above the atmosphere on a surface that faces it, 133 kilolux, in units of the renderer.
pub(super) const SUN_ABOVE_AIR: f64 = 4.0;

/// Vertical optical depths of the atmosphere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Depths {
    pub(super) air: Bands,
    pub(super) dust: Bands,
    pub(super) ozone: Bands,
}

impl Depths {
    /// For these multiples of the usual amounts.
    pub(super) fn new(air: f64, dust: f64, ozone: f64) -> Depths {
        // Hansen & Travis 1974, eq. 2.30: air molecules at sea level; wavelength in micrometres.
        let rayleigh = |nm: f64| {
            let l2 = (1e-3 * nm) * (1e-3 * nm);
            0.008569 / (l2 * l2) * (1.0 + 0.0113 / l2 + 0.00013 / (l2 * l2))
        };
        Depths {
            air: WAVELENGTHS.map(|nm| air * rayleigh(nm)),
            dust: WAVELENGTHS.map(|nm| dust * DUST_DEPTH * pow(nm / 550.0, -1.3)),
            ozone: OZONE.map(|section| ozone * section * 1e-27 * OZONE_COLUMN),
        }
    }
}

/// Conversion from fractions of sunlight at each wavelength to linear sRGB in which full sunlight has the luminance
/// [`SUN_ABOVE_AIR`].
pub(super) struct Colors {
    weights: [[f64; 3]; BANDS],
}

impl Colors {
    pub(super) fn new() -> Colors {
        let mut weights = [[0.0; 3]; BANDS];
        for (i, (nm, sun)) in WAVELENGTHS.iter().zip(SUN).enumerate() {
            weights[i] = matching(*nm).map(|v| v * sun);
        }
        let luminance: f64 = weights.iter().map(|w| w[1]).sum();
        let scale = SUN_ABOVE_AIR / luminance;
        Colors { weights: weights.map(|w| linear_srgb(w.map(|v| v * scale))) }
    }

    /// Linear sRGB; colours outside its gamut are clipped at 0.
    pub(super) fn color(&self, light: &Bands) -> Spectrum {
        let mut sum = [0.0; 3];
        for (weight, v) in self.weights.iter().zip(light) {
            for (sum, w) in sum.iter_mut().zip(weight) {
                *sum += w * v;
            }
        }
        Spectrum::from(sum.map(|v| v.max(0.0) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sunlight_above_the_air_is_nearly_white() {
        let sun = Colors::new().color(&[1.0; BANDS]);
        assert!((f64::from(sun.luminance()) - SUN_ABOVE_AIR).abs() < 0.01, "{sun:?}");
        // A little warmer than D65.
        assert!(sun.r > sun.g && sun.g > sun.b && sun.b > 0.85 * sun.r, "{sun:?}");
    }

    #[test]
    fn optical_depths_agree_with_published_ones() {
        let depths = Depths::new(1.0, 1.0, 1.0);
        // Molecules at 560 nm: 0.0905 (Bodhaine et al. 1999); ozone of 300 DU at 600 nm: about 0.04.
        assert!((depths.air[8] - 0.0905).abs() < 0.001, "{}", depths.air[8]);
        assert!((depths.ozone[10] - 0.0405).abs() < 0.002, "{}", depths.ozone[10]);
        assert!(depths.dust[7] > DUST_DEPTH && depths.dust[8] < DUST_DEPTH);
    }
}
