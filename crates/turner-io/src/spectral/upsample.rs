//! Smooth reflectance spectra of colours (Jakob and Hanika 2019, "A low-dimensional function space for efficient spectral
//! upsampling"): pbrt and other spectral renderers give every RGB colour such a spectrum.
//!
//! ```text
//! S(λ) = ½ + x / (2 √(1 + x²)),   x = c0 t² + c1 t + c2,   t = 0 at 380 nm, 1 at 780 nm
//! ```
//!
//! The three coefficients are those with which the spectrum has the colour under D65. They are found by damped
//! Gauss-Newton steps, on a straight way from grey to the colour.

use super::cie::{FIRST, LAST};
use super::{bins, linear_rgb, seen_in_daylight, white_under_daylight};
use turner::color::Spectrum;
use turner::math::{DMat3, DVec3};

/// Steps on the way from grey, and Gauss-Newton steps at each.
const WAY: u32 = 8;
const ROUNDS: u32 = 8;
/// The darkest and the brightest component: spectra of 0 and 1 have no coefficients.
const LEAST: f64 = 1e-4;
const MOST: f64 = 1.0 - 1e-4;
/// Largest coefficient.
const BOUND: f64 = 1e4;

/// A smooth spectrum within 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Smooth {
    coefficients: DVec3,
    /// Its colour, linear Rec. 709, which saturated colours reach only nearly.
    color: DVec3,
}

/// Finds [`Smooth`] spectra.
pub(crate) struct Upsampling {
    /// t and the colour of a narrow band of unit reflectance at each wavelength.
    bands: Vec<(f64, DVec3)>,
}

impl Default for Upsampling {
    fn default() -> Upsampling {
        let white = white_under_daylight();
        let band = |(nm, seen, light): (f64, [f64; 3], f64)| {
            let xyz = [0, 1, 2].map(|i| seen[i] * light * white[i]);
            (t_of(nm), DVec3::from(linear_rgb(xyz)))
        };
        Upsampling { bands: bins().map(band).collect() }
    }
}

fn t_of(nm: f64) -> f64 {
    (nm - FIRST) / (LAST - FIRST)
}

/// The sigmoid of x, and its derivative.
fn sigmoid(x: f64) -> (f64, f64) {
    let r = 1.0 / (1.0 + x * x).sqrt();
    (0.5 + 0.5 * x * r, 0.5 * r * r * r)
}

fn x_of(coefficients: DVec3, t: f64) -> f64 {
    (coefficients.x * t + coefficients.y) * t + coefficients.z
}

impl Upsampling {
    /// The spectrum of a colour in linear Rec. 709.
    pub(crate) fn of(&self, color: Spectrum) -> Smooth {
        let target = DVec3::from(color.to_array().map(|v| f64::from(v).clamp(LEAST, MOST)));
        let grey = (target.element_sum() / 3.0).clamp(LEAST, MOST);
        let mut coefficients = DVec3::Z * ((grey - 0.5) / (grey * (1.0 - grey)).sqrt());
        if target.max_element() - target.min_element() > 1e-9 {
            for step in 1..=WAY {
                let part = DVec3::splat(grey).lerp(target, f64::from(step) / f64::from(WAY));
                coefficients = self.nearer(coefficients, part);
            }
        }
        Smooth { coefficients, color: self.color(coefficients) }
    }

    fn color(&self, coefficients: DVec3) -> DVec3 {
        self.bands.iter().fold(DVec3::ZERO, |sum, (t, band)| sum + *band * sigmoid(x_of(coefficients, *t)).0)
    }

    /// Coefficients whose colour is nearer to the target.
    fn nearer(&self, mut at: DVec3, target: DVec3) -> DVec3 {
        let mut damping = 1e-6;
        let mut off = self.color(at) - target;
        for _ in 0..ROUNDS {
            if off.length_squared() < 1e-18 {
                break;
            }
            // Columns: the derivatives of the colour by the coefficients.
            let mut columns = [DVec3::ZERO; 3];
            for (t, band) in &self.bands {
                let slope = *band * sigmoid(x_of(at, *t)).1;
                for (column, power) in columns.iter_mut().zip([t * t, *t, 1.0]) {
                    *column += slope * power;
                }
            }
            let jacobian = DMat3::from_cols(columns[0], columns[1], columns[2]);
            let square = jacobian.transpose() * jacobian;
            let gradient = jacobian.transpose() * off;
            // More damping until the step is an improvement.
            for _ in 0..12 {
                let scale = damping * square.to_cols_array().iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                let damped = square + DMat3::from_diagonal(DVec3::splat(scale.max(1e-30)));
                let next = at - damped.inverse() * gradient;
                let next_off = self.color(next) - target;
                let is_sound = next.is_finite() && next.abs().max_element() < BOUND;
                if is_sound && next_off.length_squared() < off.length_squared() {
                    (at, off, damping) = (next, next_off, (damping * 0.1).max(1e-12));
                    break;
                }
                damping *= 8.0;
            }
        }
        at
    }
}

impl Smooth {
    /// The reflectance at a wavelength.
    pub(crate) fn at(&self, nm: f64) -> f64 {
        sigmoid(x_of(self.coefficients, t_of(nm))).0
    }

    /// The colour of a function of the reflectance, wavelength by wavelength. Where the spectrum does not quite have its
    /// colour, what the function makes of the difference is added.
    pub(crate) fn through(&self, color: Spectrum, f: impl Fn(f64) -> f64) -> Spectrum {
        let [r, g, b] = seen_in_daylight(|nm| f(self.at(nm))).to_array();
        let rest = |made: f32, wanted: f32, own: f64| {
            (f64::from(made) + f(f64::from(wanted)) - f(own.clamp(0.0, 1.0))).clamp(0.0, 1.0) as f32
        };
        Spectrum::new(
            rest(r, color.r, self.color.x),
            rest(g, color.g, self.color.y),
            rest(b, color.b, self.color.z),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectra_have_their_colours() {
        let upsampling = Upsampling::default();
        let mut worst = 0.0f64;
        for i in 0..1000u32 {
            let color = [i % 10, i / 10 % 10, i / 100].map(|v| 0.05 + 0.1 * v as f32);
            let smooth = upsampling.of(color.into());
            let off = smooth.color - DVec3::from(color.map(f64::from));
            worst = worst.max(off.abs().max_element());
            assert!((380..=780).all(|nm| (0.0..=1.0).contains(&smooth.at(f64::from(nm)))));
        }
        assert!(worst < 1e-4, "{worst}");
        // Greys are flat, and whatever the colour, the identity returns it.
        let grey = upsampling.of(Spectrum::grey(0.3));
        assert!((grey.at(400.0) - 0.3).abs() < 1e-6 && grey.at(400.0) == grey.at(700.0));
        for color in [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.8, 0.3, 0.0], [0.0; 3], [1.0; 3]]
        {
            let found = upsampling.of(color.into()).through(color.into(), |v| v);
            let off = found.to_array().into_iter().zip(color).map(|(a, b): (f32, f32)| (a - b).abs());
            assert!(off.fold(0.0, f32::max) < 2e-3, "{color:?} {found:?}");
        }
    }
}
