//! Transfer curves between scene values and display values.

use super::Spectrum;
use crate::choice::choice;
use crate::math::elementary::pow;

choice! {
    /// The curve between scene values and the values of 8-bit images. It also applies to `#rrggbb`, colour names and
    /// 8-bit textures.
    pub enum Transfer {
        /// No curve: values are written unchanged, clamped to 0..1, as in the classic documents.
        None = "none",
        /// Scene values are linear; pictures, hex colours and 8-bit textures are sRGB-encoded (IEC 61966-2-1).
        Srgb = "srgb",
    }
}

impl Transfer {
    /// From a scene value to a display value in 0..=1; the scene value is clamped to 0..=1, NaN becomes 0.
    pub fn encode(self, v: f32) -> f32 {
        let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
        match self {
            Transfer::None => v,
            Transfer::Srgb => srgb_encode(v),
        }
    }

    /// From a display value in 0..=1 to a scene value.
    pub fn decode(self, v: f32) -> f32 {
        match self {
            Transfer::None => v,
            Transfer::Srgb => srgb_decode(v),
        }
    }

    /// From a display colour to a scene colour.
    pub fn decode_color(self, c: Spectrum) -> Spectrum {
        c.map(|v| self.decode(v))
    }
}

/// Linear 0..=1 to sRGB 0..=1.
pub fn srgb_encode(v: f32) -> f32 {
    if v <= 0.003_130_8 { 12.92 * v } else { (1.055 * pow(f64::from(v), 1.0 / 2.4) - 0.055) as f32 }
}

/// sRGB 0..=1 to linear 0..=1.
pub fn srgb_decode(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { pow((f64::from(v) + 0.055) / 1.055, 2.4) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_bit_value_survives_decoding_and_encoding() {
        for i in 0..=255u8 {
            let v = f32::from(i) / 255.0;
            let back = Transfer::Srgb.encode(Transfer::Srgb.decode(v));
            assert_eq!((back * 255.0).round() as u8, i);
        }
        assert!((srgb_decode(0.5) - 0.214_041_14).abs() < 1e-7);
    }

    #[test]
    fn encoding_clamps() {
        assert_eq!(Transfer::None.encode(-1.0), 0.0);
        assert_eq!(Transfer::None.encode(7.0), 1.0);
        assert_eq!(Transfer::None.encode(f32::NAN), 0.0);
    }
}
