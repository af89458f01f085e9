//! Windows BMP, read only: palettes, run lengths, 16 to 32 bits per pixel with or without masks; 8 bits per channel.

use super::contain::contain;
use super::limits::{Source, buffer};
use super::{DecodeLimits, ImageError, ImageFormat};
use image::codecs::bmp::BmpDecoder;
use image::{ColorType, ImageDecoder};
use std::io::Cursor;
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::Bmp;

/// A run of 255 pixels takes two bytes.
const RUN_PIXELS_PER_BYTE: u64 = 128;

/// Whether the bytes begin with a BMP header. The letters alone could begin a text.
pub(super) fn is_bmp(bytes: &[u8]) -> bool {
    let size = bytes.get(14..18).and_then(|b| b.first_chunk::<4>()).map(|b| u32::from_le_bytes(*b));
    bytes.starts_with(b"BM")
        && size.is_some_and(|size| matches!(size, 12 | 16 | 40 | 52 | 56 | 64 | 108 | 124))
}

/// Reads a BMP: 3 channels, or 4 if the file has an alpha mask.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    contain(name, FORMAT, || {
        let expected = "RGB with or without a palette, masks or run lengths";
        let damaged = |e| ImageError::of_decoder(name, FORMAT, e, expected);
        let (width, height) = stated_size(bytes)
            .ok_or_else(|| ImageError::damaged(name, FORMAT, "the file ends inside the header"))?;
        let source = Source { name, format: FORMAT, bytes: bytes.len() };
        let size = limits.check(source, width, height, 4, pixels_per_byte(bytes))?;
        let decoder = BmpDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
        if decoder.dimensions() != (size.width, size.height) {
            return Err(ImageError::damaged(name, FORMAT, "the headers state different sizes"));
        }
        let channels = match decoder.color_type() {
            ColorType::Rgb8 => 3,
            ColorType::Rgba8 => 4,
            other => {
                return Err(ImageError::unsupported(name, FORMAT, format!("{other:?} samples"), expected));
            }
        };
        let mut samples = buffer(size.pixels * usize::from(channels), name)?;
        decoder.read_image(&mut samples).map_err(damaged)?;
        Ok(Image { width: size.width, height: size.height, channels, pixels: Pixels::U8(samples) })
    })
}

/// Whether the header is the oldest version, with 16-bit sides and no compression field.
fn is_core(bytes: &[u8]) -> bool {
    bytes.get(14..18) == Some(&[12, 0, 0, 0])
}

/// Columns and rows of the header; a negative row count means that rows are stored from the top.
fn stated_size(bytes: &[u8]) -> Option<(u64, u64)> {
    let &[a, b, c, d, e, f, g, h] = bytes.get(18..)?.first_chunk::<8>()?;
    if is_core(bytes) {
        return Some((u16::from_le_bytes([a, b]).into(), u16::from_le_bytes([c, d]).into()));
    }
    let columns = i32::from_le_bytes([a, b, c, d]);
    let rows = i32::from_le_bytes([e, f, g, h]);
    Some((u64::try_from(columns).unwrap_or_default(), rows.unsigned_abs().into()))
}

/// Most pixels that a byte can represent, by the compression in the header.
fn pixels_per_byte(bytes: &[u8]) -> u64 {
    let compressed = !is_core(bytes) && matches!(bytes.get(30), Some(1 | 2));
    if compressed { RUN_PIXELS_PER_BYTE } else { 8 }
}
