//! Truevision TGA, read only: grey, 15 to 32 bits of colour, colour maps, run lengths; 8 bits per channel.
//!
//! TGA has no signature. A file is recognised by the footer of version 2.0 or by its extension.

use super::contain::contain;
use super::limits::{Source, buffer, probe};
use super::{DecodeLimits, ImageError, ImageFormat};
use image::codecs::tga::TgaDecoder;
use image::{ColorType, ImageDecoder};
use std::io::Cursor;
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::Tga;

/// The last bytes of a version 2.0 file.
pub(super) const FOOTER: &[u8] = b"TRUEVISION-XFILE.\0";

/// A run of 128 pixels takes at least two bytes.
const RUN_PIXELS_PER_BYTE: u64 = 64;

/// Reads a TGA: 1, 3 or 4 channels; 2 for grey with alpha. A 32-bit file that declares no alpha bits and whose alpha
/// is 0 everywhere is read as opaque.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    contain(name, FORMAT, || {
        let expected = "8 bits of grey or 15 to 32 bits of colour, with or without a colour map";
        let damaged = |e| ImageError::of_decoder(name, FORMAT, e, expected);
        let Some(&[_, _, kind, _, _, _, _, _, _, _, _, _, w0, w1, h0, h1, depth, attributes]) =
            bytes.first_chunk::<18>()
        else {
            return Err(ImageError::damaged(name, FORMAT, "the file ends inside the header"));
        };
        if !matches!(kind, 1..=3 | 9..=11) {
            let problem = format!("image type {kind}; expected 1, 2, 3, 9, 10 or 11");
            return Err(ImageError::damaged(name, FORMAT, problem));
        }
        let side = |a, b| u64::from(u16::from_le_bytes([a, b]));
        let (width, height) = (side(w0, w1), side(h0, h1));
        let density = if kind >= 9 { RUN_PIXELS_PER_BYTE } else { 1 };
        let source = Source { name, format: FORMAT, bytes: bytes.len() };
        // Four channels and, for indexed images, a copy of the indices.
        let size = limits.check(source, width, height, 6, density)?;
        let decoder = TgaDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
        let mut channels = match decoder.color_type() {
            ColorType::L8 => 1,
            ColorType::La8 => 2,
            ColorType::Rgb8 => 3,
            ColorType::Rgba8 => 4,
            other => {
                return Err(ImageError::unsupported(name, FORMAT, format!("{other:?} samples"), "8 bits"));
            }
        };
        let mut samples: Vec<u8> = buffer(size.pixels * usize::from(channels), name)?;
        probe(size.pixels * 2, name)?;
        decoder.read_image(&mut samples).map_err(damaged)?;
        if depth == 32 && attributes & 15 == 0 && samples.iter().skip(3).step_by(4).all(|&a| a == 0) {
            drop_alpha(&mut samples);
            channels = 3;
        }
        Ok(Image { width: size.width, height: size.height, channels, pixels: Pixels::U8(samples) })
    })
}

/// Converts RGBA to RGB, in place.
fn drop_alpha(samples: &mut Vec<u8>) {
    let pixels = samples.len() / 4;
    for i in 0..pixels {
        samples.copy_within(4 * i..4 * i + 3, 3 * i);
    }
    samples.truncate(3 * pixels);
    samples.shrink_to_fit();
}
