//! A colour map for values from 0 to 1: black, violet, magenta, orange, pale yellow.
//!
//! It is "magma" by S. van der Walt and N. Smith (2015, CC0). Its lightness rises evenly, so that equal steps look
//! equal, also in greyscale and to colour-blind viewers. Every eighth of its 256 colours is stored and the others are
//! interpolated, to within 0.005 of the original.

use super::{Spectrum, from_rgb24};

/// Display colours of 0, 1/32, …, 1.
#[rustfmt::skip]
const STEPS: [u32; 33] = [
    0x000004, 0x030311, 0x0a0822, 0x130d33, 0x1d1146, 0x28115a, 0x36106a, 0x430f76, 0x50127c, 0x5d177f, 0x691c81,
    0x762181, 0x822681, 0x8f2a81, 0x9c2e7f, 0xa9327d, 0xb63779, 0xc33b75, 0xcf4170, 0xdb486a, 0xe65163, 0xee5c5e,
    0xf5695c, 0xf9785d, 0xfb8761, 0xfd9668, 0xfea571, 0xfeb47b, 0xfec387, 0xfed194, 0xfde0a2, 0xfceeb0, 0xfcfdbf,
];

/// The display colour (sRGB, 0..=1) of a value. Values outside 0..=1 are clamped; NaN counts as 0.
pub fn heat(value: f32) -> Spectrum {
    let at = if value > 0.0 { value.min(1.0) } else { 0.0 } * 32.0;
    let i = (at as usize).min(31);
    from_rgb24(STEPS[i]).lerp(from_rgb24(STEPS[i + 1]), at - i as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb_decode;
    use crate::math::elementary::cbrt;

    /// CIE lightness, 0 to 100.
    fn lightness(value: f32) -> f64 {
        let y = f64::from(heat(value).map(srgb_decode).luminance());
        if y > 216.0 / 24389.0 { 116.0 * cbrt(y) - 16.0 } else { y * 24389.0 / 27.0 }
    }

    #[test]
    fn lightness_rises_evenly() {
        for i in 0..64 {
            let step = lightness((i + 1) as f32 / 64.0) - lightness(i as f32 / 64.0);
            // 98 in 64 steps: 1.5 each.
            assert!((0.2..2.6).contains(&step), "{i}: {step}");
        }
        assert!((lightness(0.5) - 49.0).abs() < 6.0, "{}", lightness(0.5));
    }

    #[test]
    fn ends_hold_beyond_the_range() {
        for v in [-1.0, f32::NAN, f32::NEG_INFINITY] {
            assert_eq!(heat(v), heat(0.0));
        }
        assert_eq!(heat(f32::INFINITY), from_rgb24(0xfcfdbf));
        assert_eq!(heat(0.25), from_rgb24(0x50127c));
    }
}
