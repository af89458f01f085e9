//! The CIE 1931 standard observer, linear sRGB from XYZ, and black bodies.

use super::Spectrum;
use crate::math::elementary::{exp, pow_int};

/// Colour matching functions of the CIE 1931 standard observer at a wavelength in nm (Wyman, Sloan & Shirley 2013, "Simple
/// analytic approximations to the CIE XYZ color matching functions", eq. 4).
pub(crate) fn matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, center: f64, before: f64, after: f64| {
        let x = (nm - center) / if nm < center { before } else { after };
        height * exp(-0.5 * x * x)
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

/// CIE XYZ to linear sRGB (IEC 61966-2-1).
pub(crate) fn linear_srgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ]
}

/// The colour of a black body at a temperature in kelvin, as linear sRGB in which a spectrum of 1 everywhere has
/// luminance 1. The spectrum is scaled so that its greatest value is 1, visible or not: cold bodies are dark. Black at
/// 100 K or less. Colours outside the gamut are clipped at 0.
pub fn black_body(kelvin: f64) -> Spectrum {
    // The second radiation constant in nm·K, and hc/λkT at the greatest value of Planck's law (Wien).
    const C2: f64 = 1.438_776_877e7;
    const PEAK: f64 = 4.965_114_231_744_276;
    if kelvin.is_nan() || kelvin <= 100.0 {
        return Spectrum::BLACK;
    }
    let kelvin = kelvin.min(1e7);
    let most = pow_int(PEAK, 5) / (exp(PEAK) - 1.0);
    let (mut sum, mut white) = ([0.0; 3], 0.0);
    for i in 0..=94 {
        let nm = 360.0 + 5.0 * f64::from(i);
        let x = C2 / (nm * kelvin);
        // e^x overflows for cold bodies, whose light is nothing then.
        let light = if x > 700.0 { 0.0 } else { pow_int(x, 5) / (exp(x) - 1.0) / most };
        let seen = matching(nm);
        white += seen[1];
        sum.iter_mut().zip(seen).for_each(|(s, v)| *s += v * light);
    }
    Spectrum::from(linear_srgb(sum.map(|v| v / white)).map(|v| v.max(0.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_bodies_have_their_colours() {
        // Nearly the white point at 6500 K.
        let day = black_body(6504.0);
        let near = |a: f32, b: f32| (a / b - 1.0).abs() < 0.06;
        assert!(near(day.r, day.g) && near(day.b, day.g), "{day:?}");
        // The greatest value is visible there, so much of the spectrum is nearly 1.
        assert!(day.luminance() > 0.85 && day.luminance() <= 1.0, "{day:?}");
        // Planckian locus at 2856 K, illuminant A: x = 0.4476, y = 0.4074.
        let a = black_body(2856.0);
        let xyz = [
            0.4124 * a.r + 0.3576 * a.g + 0.1805 * a.b,
            0.2126 * a.r + 0.7152 * a.g + 0.0722 * a.b,
            0.0193 * a.r + 0.1192 * a.g + 0.9505 * a.b,
        ];
        let total: f32 = xyz.iter().sum();
        assert!((xyz[0] / total - 0.4476).abs() < 0.004, "{}", xyz[0] / total);
        assert!((xyz[1] / total - 0.4074).abs() < 0.004, "{}", xyz[1] / total);
        // Colder bodies are redder and darker.
        let fire = black_body(1500.0);
        assert!(fire.luminance() < 0.1 * a.luminance() && fire.g < 0.4 * fire.r, "{fire:?}");
        assert_eq!(black_body(100.0), Spectrum::BLACK);
        assert!(black_body(101.0).is_finite() && black_body(f64::INFINITY).is_finite());
    }
}
