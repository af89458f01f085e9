//! Portable float map, read only: 32-bit floats, grey or RGB, rows from the bottom up.
//!
//! The header consists of words: `PF` (RGB) or `Pf` (grey), width, height, and a scale. A negative scale means
//! little-endian. All values are multiplied by the scale's absolute value, as in pbrt.

use super::limits::{Source, reserve};
use super::{DecodeLimits, ImageError, ImageFormat};
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::Pfm;

/// Longest header, in bytes.
const MAX_HEADER: usize = 256;

/// Whether the bytes begin with a PFM header. The letters alone could begin a text.
pub(super) fn is_pfm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace())
}

/// Reads a PFM: 1 or 3 channels.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let damaged = |problem: &str| ImageError::damaged(name, FORMAT, problem);
    let mut words = Words { bytes: &bytes[..bytes.len().min(MAX_HEADER)], at: 0 };
    let channels: u8 = if words.next() == Some("PF") { 3 } else { 1 };
    let mut number = || words.next().and_then(|word| word.parse::<f64>().ok()).filter(|v| v.is_finite());
    let (Some(width), Some(height), Some(scale)) = (number(), number(), number()) else {
        return Err(damaged("expected PF or Pf, a width, a height and a scale"));
    };
    let side = |v: f64| if v >= 0.0 && v.fract() == 0.0 && v < 1e15 { v as u64 } else { 0 };
    // A single white-space character separates header and samples.
    let data = bytes.get(words.at + 1..).unwrap_or_default();
    let source = Source { name, format: FORMAT, bytes: bytes.len() };
    let size = limits.check(source, side(width), side(height), 4 * u64::from(channels), 1)?;
    let row = size.width as usize * usize::from(channels);
    let rows = data.as_chunks::<4>().0;
    if rows.len() / row < size.height as usize {
        let problem = format!("{} bytes cannot hold {} rows of {}", data.len(), size.height, 4 * row);
        return Err(damaged(&problem));
    }
    let factor = if scale == 0.0 { 1.0 } else { scale.abs() as f32 };
    let value = |b: &[u8; 4]| {
        let v = if scale < 0.0 { f32::from_le_bytes(*b) } else { f32::from_be_bytes(*b) };
        if factor == 1.0 { v } else { v * factor }
    };
    let mut samples = Vec::new();
    reserve(&mut samples, size.pixels * usize::from(channels), name)?;
    for line in rows.chunks_exact(row).take(size.height as usize).rev() {
        samples.extend(line.iter().map(value));
    }
    Ok(Image { width: size.width, height: size.height, channels, pixels: Pixels::F32(samples) })
}

/// The words of the header.
struct Words<'a> {
    bytes: &'a [u8],
    /// End of the previous word.
    at: usize,
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let rest = self.bytes.get(self.at..)?;
        let start = self.at + rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = self.bytes.get(start..)?;
        self.at = start + rest.iter().position(u8::is_ascii_whitespace)?;
        std::str::from_utf8(self.bytes.get(start..self.at)?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pfm(header: &str, values: &[f32], little: bool) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        for v in values {
            bytes.extend(if little { v.to_le_bytes() } else { v.to_be_bytes() });
        }
        bytes
    }

    fn samples(bytes: &[u8]) -> Option<(u32, u32, u8, Vec<f32>)> {
        let image = decode(bytes, "a.pfm", &DecodeLimits::default()).ok()?;
        let Pixels::F32(v) = image.pixels else { return None };
        Some((image.width, image.height, image.channels, v))
    }

    #[test]
    fn rows_come_from_the_bottom_in_either_order_of_bytes() {
        let grey = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let turned = vec![5.0, 6.0, 3.0, 4.0, 1.0, 2.0];
        let expected = Some((2, 3, 1, turned));
        assert_eq!(samples(&pfm("Pf\n2 3\n-1.0\n", &grey, true)), expected);
        assert_eq!(samples(&pfm("Pf\r\n2\t3 1\n", &grey, false)), expected);
        let color = [0.5, 1e30, -1.0, 0.25, 0.0, 7.0];
        let doubled = vec![0.5, 0.0, 14.0, 1.0, 2e30, -2.0];
        assert_eq!(samples(&pfm("PF\n1 2\n-2\n", &color, true)), Some((1, 2, 3, doubled)));
        // A first sample whose bytes are spaces.
        let spaces = f32::from_le_bytes(*b"    ");
        assert_eq!(samples(&pfm("Pf\n1 1\n-1\n", &[spaces], true)), Some((1, 1, 1, vec![spaces])));
    }

    #[test]
    fn damage_is_refused() {
        let whole = pfm("PF\n4 4\n-1\n", &[1.0; 48], true);
        assert!(samples(&whole).is_some());
        assert!((0..whole.len()).all(|end| samples(&whole[..end]).is_none()));
        for header in
            ["PF 0 4 -1\n", "PF -4 4 -1\n", "PF 1e9 1e9 -1\n", "PF 4.5 4 1\n", "PF 4 4 nan\n", "PF 4 4\n"]
        {
            assert!(samples(&pfm(header, &[1.0; 48], true)).is_none(), "{header}");
        }
    }
}
