//! Spectra to RGB: pbrt and Mitsuba give colours by wavelength, Turner renders in linear Rec. 709.
//!
//! A spectrum is weighted by the CIE 1931 colour matching functions x̄, ȳ, z̄ at 41 wavelengths ([`cie`]) and
//! summed to XYZ, which a matrix turns into Rec. 709. Reflectances are seen under daylight (D65), lights
//! directly:
//!
//! ```text
//! reflectance r(λ):   X = X_D65 · Σ r x̄ D65 / Σ x̄ D65      and so Y, Z: r = 1 is white
//! light s(λ):         X = Σ s x̄ / Σ s ȳ                    and so Y, Z: luminance 1
//! ```
//!
//! Colours outside Rec. 709 are clipped at 0 and keep their luminance. A metal's reflectance follows from
//! Fresnel's equations per wavelength before it is summed: the colour of a mean IOR differs. Black bodies
//! follow Planck's law, daylight of other temperatures the CIE D series. Products of spectra along a path
//! become products of RGB colours, which is the approximation of every RGB renderer.

mod cie;
mod metals;
mod named;
mod upsample;

pub(crate) use named::{Glass, glass, illuminant, metal};
pub(crate) use upsample::{Smooth, Upsampling};

use cie::{D65, FIRST, LAST, OBSERVER, STEP};
use turner::color::Spectrum;
use turner::material::metals::{MetalColors, colors_of_index, conductor};
use turner::math::elementary::{exp, pow_int};

/// A sampled spectrum: linear between ascending wavelengths in nm. Beyond both ends lights are 0, other spectra
/// keep the end values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sampled {
    /// (wavelength, value) in ascending order; at least one.
    points: Vec<(f64, f64)>,
}

impl Sampled {
    /// From alternating wavelengths and values; `None` unless these are pairs of finite numbers in ascending order.
    pub(crate) fn of_pairs(numbers: &[f64]) -> Option<Sampled> {
        let (pairs, rest) = numbers.as_chunks::<2>();
        if pairs.is_empty() || !rest.is_empty() || !numbers.iter().all(|v| v.is_finite()) {
            return None;
        }
        let points: Vec<(f64, f64)> = pairs.iter().map(|p| (p[0], p[1])).collect();
        points.is_sorted_by(|a, b| a.0 < b.0).then_some(Sampled { points })
    }

    /// From values at equal steps of wavelength.
    fn of_steps(first: f64, step: f64, values: &[f32]) -> Sampled {
        let at = |(i, v): (usize, &f32)| (first + step * i as f64, f64::from(*v));
        Sampled { points: values.iter().enumerate().map(at).collect() }
    }

    /// From the text of an .spd file: a wavelength and a value per line, comments after `#`.
    pub(crate) fn of_text(text: &str) -> Option<Sampled> {
        let mut numbers = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default();
            for word in line.split([' ', '\t', ',']).filter(|w| !w.trim().is_empty()) {
                numbers.push(word.trim().parse().ok()?);
            }
        }
        Sampled::of_pairs(&numbers)
    }

    /// The same with 0 beyond both ends.
    pub(crate) fn dark_beyond_its_ends(&self) -> Sampled {
        // Far less than the distance of two samples.
        const EDGE: f64 = 1e-6;
        let mut points = self.points.clone();
        if let Some(first) = points.first().filter(|p| p.0 > FIRST).map(|p| p.0) {
            points.insert(0, (first - EDGE, 0.0));
        }
        if let Some(last) = points.last().filter(|p| p.0 < LAST).map(|p| p.0) {
            points.push((last + EDGE, 0.0));
        }
        Sampled { points }
    }

    /// The value, if all samples have the same.
    fn constant(&self) -> Option<f64> {
        let first = self.points.first()?.1;
        self.points.iter().all(|p| p.1 == first).then_some(first)
    }

    /// The value at a wavelength; beyond the ends that of the end, or 0 for lights.
    pub(crate) fn at(&self, nm: f64, is_light: bool) -> f64 {
        let after = self.points.partition_point(|p| p.0 <= nm);
        let below = after.checked_sub(1).and_then(|i| self.points.get(i));
        match (below, self.points.get(after)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (nm - a.0) / (b.0 - a.0),
            (Some(end), None) if !is_light || end.0 == nm => end.1,
            (None, Some(end)) if !is_light => end.1,
            _ => 0.0,
        }
    }

    /// The colour of a surface with this reflectance under D65, or of a coefficient of a medium.
    pub(crate) fn reflectance(&self) -> Spectrum {
        if let Some(v) = self.constant() {
            return Spectrum::grey(v as f32);
        }
        seen_in_daylight(|nm| self.at(nm, false))
    }

    /// The colour of this light with luminance 1; black if it emits nothing visible.
    pub(crate) fn light(&self) -> Spectrum {
        of_light(|nm| self.at(nm, true))
    }

    /// The mean power of this light, weighted by ȳ.
    pub(crate) fn power(&self) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (nm, [_, y, _], _) in bins() {
            sum += y * self.at(nm, true);
            weight += y;
        }
        sum / weight
    }

    /// The mean over all wavelengths, weighted by ȳ.
    pub(crate) fn mean(&self) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (nm, [_, y, _], _) in bins() {
            sum += y * self.at(nm, false);
            weight += y;
        }
        sum / weight
    }
}

/// Reflectance at normal incidence and tint at 82° of a metal with the relative complex IOR `eta` + i·`k` at a wavelength.
pub(crate) fn metal_at(eta: f64, k: f64) -> (f64, f64) {
    let index = |v: f64| Spectrum::grey(v.clamp(0.0, 1e6) as f32);
    let c = colors_of_index(index(eta), index(k));
    (f64::from(c.f0.r), f64::from(c.tint.r))
}

/// The colours of a metal with the complex IOR `eta` + i·`k`, below a medium with the IOR `outer`.
pub(crate) fn metal_of_index(eta: &Sampled, k: &Sampled, outer: f64) -> MetalColors {
    let [f0, grazing] = metal_reflectances(eta, k, outer);
    let tint = |f0: f32, grazing: f32| {
        let schlick = f0 + (1.0 - f0) * pow_int(6.0 / 7.0, 5) as f32;
        if schlick > 0.0 { (grazing / schlick).clamp(0.0, 1.0) } else { 1.0 }
    };
    let tint = Spectrum::new(tint(f0.r, grazing.r), tint(f0.g, grazing.g), tint(f0.b, grazing.b));
    MetalColors { f0: f0.map(|v| v.clamp(0.0, 1.0)), tint }
}

/// The reflectances of a metal at normal incidence and at 82° (cos θ = 1/7), by Fresnel's equations for each wavelength.
pub(crate) fn metal_reflectances(eta: &Sampled, k: &Sampled, outer: f64) -> [Spectrum; 2] {
    [1.0, 1.0 / 7.0]
        .map(|cos| seen_in_daylight(|nm| conductor(cos, eta.at(nm, false) / outer, k.at(nm, false) / outer)))
}

/// The colour of a black body at `kelvin`, with luminance 1.
pub(crate) fn blackbody(kelvin: f64) -> Spectrum {
    // Planck's law without its constant factor; the second radiation constant in nm·K.
    const C2: f64 = 1.438_776_877e7;
    let kelvin = kelvin.clamp(100.0, 1e7);
    // Relative to 560 nm: the values stay in range for the coldest bodies.
    let planck = |nm: f64| {
        let (x, x0) = (C2 / (nm * kelvin), C2 / (560.0 * kelvin));
        let ratio = if x > 1.0 {
            exp(x0 - x) * (1.0 - exp(-x0)) / (1.0 - exp(-x))
        } else {
            (exp(x0) - 1.0) / (exp(x) - 1.0)
        };
        ratio * pow_int(560.0 / nm, 5)
    };
    of_light(planck)
}

/// The colour of CIE daylight (D series, CIE 15) at `kelvin`, with luminance 1; below 4000 K a black body.
pub(crate) fn daylight(kelvin: f64) -> Spectrum {
    // The D series was defined with a second radiation constant of 1.438e-2 m·K.
    let kelvin = kelvin.clamp(100.0, 25_000.0) * 1.4388 / 1.438;
    if kelvin < 4000.0 {
        return blackbody(kelvin);
    }
    let t = 1e3 / kelvin;
    let x = if kelvin <= 7000.0 {
        0.244_063 + t * (0.099_11 + t * (2.9678 - t * 4.607))
    } else {
        0.237_04 + t * (0.247_48 + t * (1.9018 - t * 2.0064))
    };
    of_chromaticity(x, x * (2.87 - 3.0 * x) - 0.275)
}

/// The mean radiance of a black body, weighted by ȳ, in W/(m²·sr·nm).
pub(crate) fn blackbody_power(kelvin: f64) -> f64 {
    // 2hc² for wavelengths in nm; the second radiation constant in nm·K.
    const C1: f64 = 1.191_042_972e20;
    const C2: f64 = 1.438_776_877e7;
    let kelvin = kelvin.clamp(100.0, 1e7);
    let (mut sum, mut weight) = (0.0, 0.0);
    for (nm, [_, y, _], _) in bins() {
        sum += y * C1 * pow_int(1.0 / nm, 5) / (exp(C2 / (nm * kelvin)) - 1.0);
        weight += y;
    }
    sum / weight
}

/// Wavelength, colour matching functions and D65, every 10 nm.
fn bins() -> impl Iterator<Item = (f64, [f64; 3], f64)> {
    OBSERVER.iter().zip(&D65).enumerate().map(|(i, (seen, light))| (FIRST + STEP * i as f64, *seen, *light))
}

/// The colour of a surface with this reflectance under D65.
pub(crate) fn seen_in_daylight(value: impl Fn(f64) -> f64) -> Spectrum {
    rgb(xyz_in_daylight(value))
}

/// The same, unclipped: linear in the values.
pub(crate) fn linear_in_daylight(value: impl Fn(f64) -> f64) -> [f64; 3] {
    linear_rgb(xyz_in_daylight(value))
}

fn xyz_in_daylight(value: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for (nm, seen, light) in bins() {
        let v = value(nm);
        xyz.iter_mut().zip(seen).for_each(|(s, c)| *s += v * c * light);
    }
    let white = white_under_daylight();
    [xyz[0] * white[0], xyz[1] * white[1], xyz[2] * white[2]]
}

/// Factors on sums of x̄ D65, ȳ D65, z̄ D65: a surface that reflects all light is exactly white.
fn white_under_daylight() -> [f64; 3] {
    let mut white = [0.0; 3];
    for (_, seen, light) in bins() {
        white.iter_mut().zip(seen).for_each(|(w, c)| *w += c * light);
    }
    let d65 = [0.950_470, 1.0, 1.088_830];
    [d65[0] / white[0], d65[1] / white[1], d65[2] / white[2]]
}

/// What a function of the wavelength is at each of the wavelengths that [`seen_in_daylight`] asks for.
pub(crate) fn at_each_wavelength<T>(value: impl Fn(f64) -> T) -> Vec<T> {
    bins().map(|(nm, ..)| value(nm)).collect()
}

/// [`seen_in_daylight`] of values at each wavelength.
pub(crate) fn seen_values(values: &[f64]) -> Spectrum {
    let index = |nm: f64| ((nm - FIRST) / STEP).round() as usize;
    seen_in_daylight(|nm| values.get(index(nm)).copied().unwrap_or(0.0))
}

fn of_light(power: impl Fn(f64) -> f64) -> Spectrum {
    let mut xyz = [0.0; 3];
    for (nm, seen, _) in bins() {
        let v = power(nm);
        xyz.iter_mut().zip(seen).for_each(|(s, c)| *s += v * c);
    }
    if !(xyz[1] > 0.0 && xyz.iter().all(|v| v.is_finite())) {
        return Spectrum::BLACK;
    }
    rgb(xyz.map(|v| v / xyz[1]))
}

/// The colour of a chromaticity, with luminance 1.
fn of_chromaticity(x: f64, y: f64) -> Spectrum {
    rgb([x / y, 1.0, (1.0 - x - y) / y])
}

/// CIE XYZ to linear Rec. 709. Colours outside it are clipped at 0 and scaled to keep their luminance.
fn rgb([x, y, z]: [f64; 3]) -> Spectrum {
    let v = linear_rgb([x, y, z]);
    let cut = v.map(|v| v.max(0.0));
    let luminance = 0.212_672_9 * cut[0] + 0.715_152_2 * cut[1] + 0.072_175 * cut[2];
    let factor = if v != cut && luminance > 0.0 && y > 0.0 { y / luminance } else { 1.0 };
    Spectrum::new((cut[0] * factor) as f32, (cut[1] * factor) as f32, (cut[2] * factor) as f32)
}

/// CIE XYZ to linear Rec. 709, unclipped.
fn linear_rgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(c: Spectrum, expected: [f32; 3], within: f32) {
        let all = c.to_array().into_iter().zip(expected).all(|(a, b)| (a - b).abs() <= within);
        assert!(all, "{c:?}, expected {expected:?}");
    }

    #[test]
    fn daylight_is_white() {
        let pairs: Vec<f64> = bins().flat_map(|(nm, _, light)| [nm, light]).collect();
        near(Sampled::of_pairs(&pairs).unwrap().light(), [1.0; 3], 4e-3);
        near(Sampled::of_pairs(&[400.0, 0.5, 700.0, 0.5]).unwrap().reflectance(), [0.5; 3], 0.0);
        near(Sampled::of_pairs(&[300.0, 0.5, 350.0, 0.2, 360.0, 0.5]).unwrap().reflectance(), [0.5; 3], 1e-6);
        near(of_chromaticity(0.312_71, 0.329_02), [1.0; 3], 1e-3);
    }

    #[test]
    fn bodies_glow_in_their_colours() {
        // CIE illuminant A is a black body of 2856 K: x = 0.44757, y = 0.40745.
        let a = of_chromaticity(0.447_57, 0.407_45);
        near(blackbody(2855.5), a.to_array(), 5e-3);
        // 6504 K lies near D65, a little below the locus.
        near(blackbody(6504.0), [1.03, 0.99, 1.0], 0.04);
        for kelvin in [0.0, 1.0, 500.0, 1e4, 1e9, f64::MAX] {
            let c = blackbody(kelvin);
            assert!(c.is_finite() && (c.luminance() - 1.0).abs() < 0.01, "{kelvin}: {c:?}");
        }
        let [r, _, b] = blackbody(1500.0).to_array();
        assert!(r > 2.0 && b < 0.05);
    }

    #[test]
    fn daylight_is_the_illuminants() {
        near(daylight(6500.0), [1.0, 1.0, 1.0], 0.01);
        near(daylight(5000.0), illuminant("stdillum-D50").unwrap().to_array(), 0.01);
        let [r, _, b] = daylight(9000.0).to_array();
        assert!(r < 0.95 && b > 1.15);
    }

    #[test]
    fn pairs_must_ascend() {
        for bad in [&[][..], &[1.0], &[2.0, 1.0, 1.0, 1.0], &[1.0, f64::NAN], &[1.0, 1.0, 1.0, 2.0]] {
            assert_eq!(Sampled::of_pairs(bad), None, "{bad:?}");
        }
        let text = "# a comment\n400 0.5\n500.5\t1e-1 # more\n\n";
        assert_eq!(Sampled::of_text(text), Sampled::of_pairs(&[400.0, 0.5, 500.5, 0.1]));
        assert_eq!(Sampled::of_text("400 x"), None);
    }

    #[test]
    fn spectral_metals_are_those_of_the_bands() {
        let flat = |v: f64| Sampled::of_pairs(&[400.0, v, 700.0, v]).unwrap();
        let (found, expected) = (
            metal_of_index(&flat(0.4), &flat(7.8), 2.0),
            colors_of_index(Spectrum::grey(0.2), Spectrum::grey(3.9)),
        );
        near(found.f0, expected.f0.to_array(), 1e-5);
        near(found.tint, expected.tint.to_array(), 1e-5);
    }
}
