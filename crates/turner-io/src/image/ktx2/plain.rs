//! Uncompressed formats, by Vulkan's numbers.

use super::fault::Outcome;
use super::fault::list;
use super::samples::Samples;

/// How a sample is stored, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stored {
    U8,
    U16,
    Half,
    Float,
    /// 11, 11 and 10 bits without a sign, packed in 32: 5 bits of exponent.
    Packed111110,
    /// Three mantissas of 9 bits with a shared exponent of 5.
    SharedExponent,
}

/// An uncompressed format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Plain {
    stored: Stored,
    pub(super) channels: usize,
    /// Whether blue comes first.
    is_bgr: bool,
    /// Whether the format's name ends in SRGB.
    pub(super) is_srgb: bool,
}

/// The formats that are read: number of the format without and with sRGB, samples, channels, whether blue is first.
const FORMATS: &[(u32, u32, Stored, usize, bool)] = &[
    (9, 15, Stored::U8, 1, false),
    (16, 22, Stored::U8, 2, false),
    (23, 29, Stored::U8, 3, false),
    (30, 36, Stored::U8, 3, true),
    (37, 43, Stored::U8, 4, false),
    (44, 50, Stored::U8, 4, true),
    (70, 70, Stored::U16, 1, false),
    (77, 77, Stored::U16, 2, false),
    (84, 84, Stored::U16, 3, false),
    (91, 91, Stored::U16, 4, false),
    (76, 76, Stored::Half, 1, false),
    (83, 83, Stored::Half, 2, false),
    (90, 90, Stored::Half, 3, false),
    (97, 97, Stored::Half, 4, false),
    (100, 100, Stored::Float, 1, false),
    (103, 103, Stored::Float, 2, false),
    (106, 106, Stored::Float, 3, false),
    (109, 109, Stored::Float, 4, false),
    (122, 122, Stored::Packed111110, 3, false),
    (123, 123, Stored::SharedExponent, 3, false),
];

impl Plain {
    /// The format of a number, if it is one that is read.
    pub(super) fn of(format: u32) -> Option<Plain> {
        let row = FORMATS.iter().find(|row| row.0 == format || row.1 == format)?;
        let &(linear, srgb, stored, channels, is_bgr) = row;
        Some(Plain { stored, channels, is_bgr, is_srgb: format == srgb && srgb != linear })
    }

    /// Bytes of a pixel in the file.
    pub(super) fn pixel_bytes(self) -> usize {
        match self.stored {
            Stored::U8 => self.channels,
            Stored::U16 | Stored::Half => 2 * self.channels,
            Stored::Float => 4 * self.channels,
            Stored::Packed111110 | Stored::SharedExponent => 4,
        }
    }

    /// Bytes of a pixel when decoded.
    pub(super) fn decoded_bytes(self) -> usize {
        match self.stored {
            Stored::U8 => self.channels,
            Stored::U16 => 2 * self.channels,
            _ => 4 * self.channels,
        }
    }

    /// The samples of whole pixels.
    pub(super) fn decode(self, bytes: &[u8]) -> Outcome<Samples> {
        let mut samples = match self.stored {
            Stored::U8 => {
                let mut out = list(bytes.len())?;
                out.copy_from_slice(bytes);
                Samples::U8(out)
            }
            Stored::U16 => Samples::U16(each(bytes, |v| u16::from_le_bytes(*v))?),
            Stored::Half => Samples::F32(each(bytes, |v| half(u16::from_le_bytes(*v)))?),
            Stored::Float => Samples::F32(each(bytes, |v| f32::from_le_bytes(*v))?),
            Stored::Packed111110 => Samples::F32(triples(bytes, packed_111110)?),
            Stored::SharedExponent => Samples::F32(triples(bytes, shared_exponent)?),
        };
        if let (Samples::U8(samples), true) = (&mut samples, self.is_bgr) {
            samples.chunks_exact_mut(self.channels).for_each(|pixel| pixel.swap(0, 2));
        }
        Ok(samples)
    }
}

/// Converts each group of `N` bytes.
fn each<const N: usize, T: Clone + Default>(
    bytes: &[u8],
    convert: impl Fn(&[u8; N]) -> T,
) -> Outcome<Vec<T>> {
    let groups = bytes.as_chunks::<N>().0;
    let mut out = list(groups.len())?;
    out.iter_mut().zip(groups).for_each(|(value, group)| *value = convert(group));
    Ok(out)
}

/// Converts each group of four bytes to three values.
fn triples(bytes: &[u8], convert: impl Fn(u32) -> [f32; 3]) -> Outcome<Vec<f32>> {
    let groups = bytes.as_chunks::<4>().0;
    let mut out = list::<f32>(3 * groups.len())?;
    for (three, group) in out.as_chunks_mut::<3>().0.iter_mut().zip(groups) {
        *three = convert(u32::from_le_bytes(*group));
    }
    Ok(out)
}

/// 2^`exponent` for exponents of normal numbers.
fn power(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127).clamp(1, 254) as u32) << 23)
}

/// A number without a sign, with 5 bits of exponent and `bits` bits of mantissa, as in half floats.
fn small_float(value: u32, bits: u32) -> f32 {
    let (exponent, mantissa) = ((value >> bits & 31) as i32, value & ((1 << bits) - 1));
    match exponent {
        0 => mantissa as f32 * power(-14 - bits as i32),
        31 if mantissa == 0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1 << bits | mantissa) as f32 * power(exponent - 15 - bits as i32),
    }
}

/// A half float.
fn half(value: u16) -> f32 {
    let magnitude = small_float(u32::from(value & 0x7fff), 10);
    if value >> 15 == 1 { -magnitude } else { magnitude }
}

/// Red in the lowest bits.
fn packed_111110(v: u32) -> [f32; 3] {
    [small_float(v & 0x7ff, 6), small_float(v >> 11 & 0x7ff, 6), small_float(v >> 22, 5)]
}

/// Red in the lowest bits; the exponent has a bias of 15 and the mantissas have no hidden bit.
fn shared_exponent(v: u32) -> [f32; 3] {
    let scale = power((v >> 27) as i32 - 15 - 9);
    [v & 0x1ff, v >> 9 & 0x1ff, v >> 18 & 0x1ff].map(|mantissa| mantissa as f32 * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_floats_are_those_of_ieee_754() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 5.960_464_5e-8),
            (0x03ff, 6.097_555_e-5),
            (0x3555, 0.333_251_95),
            (0xfc00, f32::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7c01).is_nan());
        // 1.5, 0.25 and 3.0.
        assert_eq!(packed_111110(0x3e0 | 0x340 << 11 | 0x210 << 22), [1.5, 0.25, 3.0]);
        // Exponent 16: the scale is 2^-8.
        assert_eq!(shared_exponent(16 << 27 | 256 | 511 << 9 | 1 << 18), [1.0, 511.0 / 256.0, 1.0 / 256.0]);
    }

    #[test]
    fn blue_first_is_reordered() {
        let samples = Plain::of(50).unwrap().decode(&[1, 2, 3, 4, 5, 6, 7, 8]).unwrap();
        assert_eq!(samples, Samples::U8(vec![3, 2, 1, 4, 7, 6, 5, 8]));
        assert!(Plain::of(50).unwrap().is_srgb && !Plain::of(44).unwrap().is_srgb);
    }
}
