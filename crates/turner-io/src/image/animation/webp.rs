//! Animated WebP, after the container specification of RFC 9649: lossless frames in a VP8X container.

use image::ExtendedColorType;
use image::codecs::webp::WebPEncoder;

use super::{AnimationFormat, Frame, Frames, Shape, failed};
use crate::image::ImageError;

const FORMAT: AnimationFormat = AnimationFormat::WebP;

/// Flags of VP8X.
const ANIMATION: u8 = 0x02;
const ALPHA: u8 = 0x10;

/// Flag of ANMF: the frame replaces what is there.
const NO_BLENDING: u8 = 0x02;

pub(super) fn encode(shape: &Shape, frames: &mut Frames<'_>) -> Result<Vec<u8>, ImageError> {
    let mut chunks = Vec::new();
    let mut alpha = false;
    for i in 0..shape.frames {
        let frame = frames(i)?;
        alpha |= frame.has_alpha();
        let mut body = Vec::new();
        // Position (0, 0) in units of two pixels, then the size less 1.
        for value in [0, 0, shape.width - 1, shape.height - 1, shape.duration(i, 1000.0)] {
            body.extend(&value.to_le_bytes()[..3]);
        }
        body.push(NO_BLENDING);
        body.extend(lossless(&frame)?);
        chunk(&mut chunks, b"ANMF", &body);
    }
    let mut content = b"WEBP".to_vec();
    let mut header = vec![ANIMATION | if alpha { ALPHA } else { 0 }, 0, 0, 0];
    for side in [shape.width - 1, shape.height - 1] {
        header.extend(&side.to_le_bytes()[..3]);
    }
    chunk(&mut content, b"VP8X", &header);
    // Background: transparent black; 0 repetitions are endless.
    chunk(&mut content, b"ANIM", &[0; 6]);
    content.extend(chunks);
    if content.len() > u32::MAX as usize - 8 {
        return Err(failed(FORMAT, "the file would exceed 4 GB; render fewer frames or smaller ones"));
    }
    let mut out = Vec::with_capacity(content.len() + 8);
    chunk(&mut out, b"RIFF", &content);
    Ok(out)
}

/// A chunk, padded to an even length.
fn chunk(out: &mut Vec<u8>, name: &[u8; 4], body: &[u8]) {
    out.extend(name);
    out.extend((body.len() as u32).to_le_bytes());
    out.extend(body);
    if body.len() % 2 == 1 {
        out.push(0);
    }
}

/// The VP8L chunk of a frame.
fn lossless(frame: &Frame) -> Result<Vec<u8>, ImageError> {
    /// RIFF, its length, WEBP.
    const START: usize = 12;
    let mut file = Vec::new();
    let encoder = WebPEncoder::new_lossless(&mut file);
    let done = if frame.has_alpha() {
        let bytes = frame.pixels.as_flattened();
        encoder.encode(bytes, frame.width, frame.height, ExtendedColorType::Rgba8)
    } else {
        let bytes: Vec<u8> = frame.pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        encoder.encode(&bytes, frame.width, frame.height, ExtendedColorType::Rgb8)
    };
    done.map_err(|e| failed(FORMAT, e))?;
    if file.get(START..START + 4) != Some(b"VP8L") {
        return Err(failed(FORMAT, "the encoder wrote no lossless frame"));
    }
    Ok(file.split_off(START))
}
