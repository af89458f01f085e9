//! WebP: lossy or lossless, with or without alpha; 8 bits. Lossless files are written.
//!
//! Animations are rejected, because a texture is one image. Colour profiles and EXIF orientation are not applied. The
//! chunks and the sizes that they state are checked here, before the decoder reserves memory for them (RFC 9649; VP8
//! frame header: RFC 6386 §9.1).

use super::contain::contain;
use super::limits::{Source, buffer, probe};
use super::{DecodeLimits, ImageError, ImageFormat, OutputImage};
use image::codecs::webp::{WebPDecoder, WebPEncoder};
use image::{ExtendedColorType, ImageDecoder};
use std::io::Cursor;
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::WebP;

/// A macroblock of a lossy frame has 256 pixels, and its prediction modes take at least three bits, because their
/// probabilities in key frames are fixed.
const LOSSY_PIXELS_PER_BYTE: u64 = 1024;

/// Reads a still WebP image: 3 channels, or 4 with straight alpha.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    contain(name, FORMAT, || {
        let damaged = |problem: &str| ImageError::damaged(name, FORMAT, problem);
        let layout = Layout::of(bytes).ok_or_else(|| damaged("the chunks end before the image"))?;
        if layout.animated {
            return Err(ImageError::unsupported(name, FORMAT, "an animation", "a still image"));
        }
        let (width, height) = layout.frame.ok_or_else(|| damaged("it contains no image"))?;
        if layout.canvas.is_some_and(|canvas| canvas != (width, height)) {
            return Err(damaged("the image does not have the size of its canvas"));
        }
        // Pixels of a single-coloured lossless image take no bits, so a few bytes can represent any size.
        let density = if layout.lossy { LOSSY_PIXELS_PER_BYTE } else { u64::MAX };
        // The samples, and the planes or RGBA pixels that the decoder keeps in addition.
        let pixel_bytes = 8;
        let source = Source { name, format: FORMAT, bytes: bytes.len() };
        let size = limits.check(source, width.into(), height.into(), pixel_bytes, density)?;
        let decoder = WebPDecoder::new(Cursor::new(bytes))
            .map_err(|e| ImageError::of_decoder(name, FORMAT, e, "a still image"))?;
        if decoder.dimensions() != (width, height) {
            return Err(damaged("the headers state different sizes"));
        }
        let channels = if decoder.color_type().has_alpha() { 4 } else { 3 };
        let mut samples = buffer(size.pixels * usize::from(channels), name)?;
        probe(size.pixels * (8 - usize::from(channels)), name)?;
        decoder
            .read_image(&mut samples)
            .map_err(|e| ImageError::of_decoder(name, FORMAT, e, "a still image"))?;
        Ok(Image { width, height, channels, pixels: Pixels::U8(samples) })
    })
}

/// Most columns and most rows of a WebP file.
const MOST: u32 = 16384;

/// Encodes the display samples as lossless RGB or RGBA; metadata is dropped.
pub fn encode(image: &OutputImage<'_>) -> Result<Vec<u8>, ImageError> {
    let samples = image.eight_bit_srgb(FORMAT, image.alpha)?;
    if image.width > MOST || image.height > MOST {
        let problem = format!("{} x {} exceeds {MOST} on a side; use PNG", image.width, image.height);
        return Err(ImageError::encode(FORMAT, problem));
    }
    let kind = if image.alpha { ExtendedColorType::Rgba8 } else { ExtendedColorType::Rgb8 };
    let mut out = Vec::new();
    WebPEncoder::new_lossless(&mut out)
        .encode(&samples, image.width, image.height, kind)
        .map_err(|e| ImageError::encode(FORMAT, e))?;
    Ok(out)
}

/// Information from the chunks of a file.
#[derive(Default)]
struct Layout {
    /// The size in the VP8X chunk.
    canvas: Option<(u32, u32)>,
    /// The size of the image itself.
    frame: Option<(u32, u32)>,
    lossy: bool,
    animated: bool,
}

impl Layout {
    /// Parses the chunks up to the image; `None` if a header is truncated.
    fn of(bytes: &[u8]) -> Option<Layout> {
        let mut layout = Layout::default();
        let mut rest = bytes.get(12..)?;
        while let Some((kind, after)) = rest.split_first_chunk::<4>() {
            let (length, data) = after.split_first_chunk::<4>()?;
            let length = u32::from_le_bytes(*length) as usize;
            match kind {
                b"VP8X" => {
                    let &[flags, _, _, _, w0, w1, w2, h0, h1, h2] = data.first_chunk::<10>()?;
                    layout.animated = flags & 2 != 0;
                    let side = |a, b, c| u32::from_le_bytes([a, b, c, 0]) + 1;
                    layout.canvas = Some((side(w0, w1, w2), side(h0, h1, h2)));
                }
                b"VP8 " => {
                    let &[_, _, _, 0x9d, 0x01, 0x2a, w0, w1, h0, h1] = data.first_chunk::<10>()? else {
                        return None;
                    };
                    let side = |a, b| u32::from(u16::from_le_bytes([a, b]) & 0x3fff);
                    layout.frame = Some((side(w0, w1), side(h0, h1)));
                    layout.lossy = true;
                    return Some(layout);
                }
                b"VP8L" => {
                    let &[0x2f, a, b, c, d] = data.first_chunk::<5>()? else { return None };
                    let header = u32::from_le_bytes([a, b, c, d]);
                    layout.frame = Some(((header & 0x3fff) + 1, (header >> 14 & 0x3fff) + 1));
                    return Some(layout);
                }
                _ => {}
            }
            if layout.animated {
                return Some(layout);
            }
            // Chunks begin at even offsets.
            rest = data.get(length.checked_add(length & 1)?..).unwrap_or_default();
        }
        Some(layout)
    }
}
