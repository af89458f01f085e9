//! Spectra with names: metals, glasses, illuminants.

use super::metals::{self, METALS};
use super::{Sampled, of_chromaticity};
use turner::color::Spectrum;

/// A glass: IOR at 587.6 nm and Abbe number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Glass {
    pub(crate) ior: f64,
    pub(crate) abbe: f64,
}

/// Glasses by their catalogue names.
const GLASSES: &[(&str, Glass)] = &[
    ("BK7", Glass { ior: 1.5168, abbe: 64.17 }),
    ("BAF10", Glass { ior: 1.67003, abbe: 47.11 }),
    ("FK51A", Glass { ior: 1.48656, abbe: 84.47 }),
    ("LASF9", Glass { ior: 1.85025, abbe: 32.17 }),
    ("F5", Glass { ior: 1.60342, abbe: 38.03 }),
    ("F10", Glass { ior: 1.62299, abbe: 36.9 }),
    ("F11", Glass { ior: 1.62066, abbe: 36.2 }),
    ("SF5", Glass { ior: 1.6727, abbe: 32.25 }),
    ("SF10", Glass { ior: 1.72825, abbe: 28.53 }),
    ("SF11", Glass { ior: 1.78472, abbe: 25.68 }),
];

/// Chromaticities (x, y) of illuminants (CIE 15) and of the ACES white point.
const ILLUMINANTS: &[(&str, [f64; 2])] = &[
    ("stdillum-A", [0.44757, 0.40745]),
    ("stdillum-D50", [0.34567, 0.3585]),
    ("stdillum-D65", [0.31271, 0.32902]),
    ("stdillum-F1", [0.3131, 0.33727]),
    ("stdillum-F2", [0.37208, 0.37529]),
    ("stdillum-F3", [0.4091, 0.3943]),
    ("stdillum-F4", [0.44018, 0.40329]),
    ("stdillum-F5", [0.31379, 0.34531]),
    ("stdillum-F6", [0.3779, 0.38835]),
    ("stdillum-F7", [0.31292, 0.32933]),
    ("stdillum-F8", [0.34588, 0.35875]),
    ("stdillum-F9", [0.37417, 0.37281]),
    ("stdillum-F10", [0.34609, 0.35986]),
    ("stdillum-F11", [0.38052, 0.37713]),
    ("stdillum-F12", [0.43695, 0.40441]),
    ("illum-acesD60", [0.32168, 0.33767]),
];

/// A glass by its name.
pub(crate) fn glass(name: &str) -> Option<Glass> {
    GLASSES.iter().find(|(n, _)| *n == name).map(|(_, g)| *g)
}

/// The colour of an illuminant with luminance 1; D65 is exactly white.
pub(crate) fn illuminant(name: &str) -> Option<Spectrum> {
    if name == "stdillum-D65" {
        return Some(Spectrum::WHITE);
    }
    ILLUMINANTS.iter().find(|(n, _)| *n == name).map(|(_, [x, y])| of_chromaticity(*x, *y))
}

/// The complex index of refraction of a metal by its chemical symbol: η and k.
pub(crate) fn metal(symbol: &str) -> Option<[Sampled; 2]> {
    let found = METALS.iter().find(|m| m.symbol == symbol)?;
    Some([found.eta, found.k].map(|values| Sampled::of_steps(metals::FIRST, metals::STEP, &values)))
}
