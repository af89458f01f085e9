//! GIF 89a: 256 colours for each frame, chosen by a neural network (Dekker 1994, "Kohonen neural networks for optimal
//! colour quantization"), and an ordered dither that stands still from frame to frame.

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, Repeat};

use super::{AnimationFormat, Frame, Frames, Shape, failed};
use crate::image::ImageError;

const FORMAT: AnimationFormat = AnimationFormat::Gif;

/// One in this many pixels teaches the network: fewer are faster, but rare colours suffer.
const SAMPLED: i32 = 3;

/// Width of the dither pattern in display values: about the distance of neighbouring colours in a smooth gradient.
const DITHER: f32 = 5.0;

/// The coverage from which a pixel is opaque.
const OPAQUE: u8 = 128;

pub(super) fn encode(shape: &Shape, frames: &mut Frames<'_>) -> Result<Vec<u8>, ImageError> {
    let wrong = |e: gif::EncodingError| failed(FORMAT, e);
    let (width, height) = (shape.width as u16, shape.height as u16);
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, width, height, &[]).map_err(wrong)?;
    encoder.set_repeat(Repeat::Infinite).map_err(wrong)?;
    for i in 0..shape.frames {
        let frame = frames(i)?;
        let transparent = frame.pixels.iter().any(|p| p[3] < OPAQUE);
        let (palette, indices) = indexed(&frame, transparent);
        encoder
            .write_frame(&gif::Frame {
                width,
                height,
                delay: shape.duration(i, 100.0) as u16,
                dispose: if transparent { DisposalMethod::Background } else { DisposalMethod::Keep },
                transparent: transparent.then_some(0),
                palette: Some(palette),
                buffer: indices.into(),
                ..gif::Frame::default()
            })
            .map_err(wrong)?;
    }
    drop(encoder);
    Ok(out)
}

/// The palette of a frame as red, green and blue bytes, and the index of each pixel. Index 0 is transparent if any pixel
/// is.
fn indexed(frame: &Frame, transparent: bool) -> (Vec<u8>, Vec<u8>) {
    let opaque: Vec<u8> =
        frame.pixels.iter().filter(|p| p[3] >= OPAQUE).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
    let first = usize::from(transparent);
    let mut colors: Vec<[u8; 3]> = opaque.as_chunks::<4>().0.iter().map(|p| [p[0], p[1], p[2]]).collect();
    colors.sort_unstable();
    colors.dedup();
    let mut palette = vec![[0; 3]; first];
    if colors.len() <= 256 - first {
        // Few colours are kept exactly.
        palette.extend(&colors);
        let index = |p: &[u8; 4]| match p[3] >= OPAQUE {
            true => colors.binary_search(&[p[0], p[1], p[2]]).map_or(0, |i| (i + first) as u8),
            false => 0,
        };
        let indices = frame.pixels.iter().map(index).collect();
        return (as_bytes(palette), indices);
    }
    let network = NeuQuant::new(SAMPLED, 256 - first, &opaque);
    palette.extend(network.color_map_rgb().as_chunks::<3>().0);
    let width = frame.width as usize;
    let index = |(i, p): (usize, &[u8; 4])| {
        if p[3] < OPAQUE {
            return 0;
        }
        let shift = (threshold((i % width) as u32, (i / width) as u32) - 0.5) * DITHER;
        let dithered = |v: u8| (f32::from(v) + shift).round().clamp(0.0, 255.0) as u8;
        (network.index_of(&[dithered(p[0]), dithered(p[1]), dithered(p[2]), 255]) + first) as u8
    };
    let indices = frame.pixels.iter().enumerate().map(index).collect();
    (as_bytes(palette), indices)
}

fn as_bytes(palette: Vec<[u8; 3]>) -> Vec<u8> {
    palette.into_flattened()
}

/// An ordered dither, 0 included to 1 excluded: multiples of the powers of the plastic number (M. Roberts, "The
/// unreasonable effectiveness of quasirandom sequences", 2018).
fn threshold(x: u32, y: u32) -> f32 {
    let at = x.wrapping_mul(0xc13f_a9a9).wrapping_add(y.wrapping_mul(0x91e1_0da6));
    (at >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Frames and durations in milliseconds.
    pub(crate) fn decoded(bytes: &[u8]) -> Vec<(Vec<[u8; 4]>, f64)> {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(bytes).unwrap();
        let mut out = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            out.push((frame.buffer.as_chunks().0.to_vec(), 10.0 * f64::from(frame.delay)));
        }
        out
    }

    #[test]
    fn few_colours_are_exact_and_gradients_keep_their_mean() {
        let flat = |i: u32| [(i % 16 * 16) as u8, 10, 200, if i.is_multiple_of(5) { 0 } else { 255 }];
        let frame = Frame { width: 64, height: 64, pixels: (0..4096).map(flat).collect() };
        let (palette, indices) = indexed(&frame, true);
        for (pixel, index) in frame.pixels.iter().zip(&indices) {
            let at = 3 * usize::from(*index);
            assert!(pixel[3] == 0 && *index == 0 || palette[at..at + 3] == pixel[..3]);
        }
        // 65536 colours, in blocks of 16 x 16 pixels.
        let smooth = |i: u32| [(i % 256) as u8, (i / 256) as u8, 128, 255];
        let frame = Frame { width: 256, height: 256, pixels: (0..65536).map(smooth).collect() };
        let (palette, indices) = indexed(&frame, false);
        for block in 0..256 {
            let (mut wanted, mut found) = (0.0, 0.0);
            for i in 0..256 {
                let at = (block / 16 * 16 + i / 16) * 256 + block % 16 * 16 + i % 16;
                wanted += f64::from(frame.pixels[at][0]) / 256.0;
                found += f64::from(palette[3 * usize::from(indices[at])]) / 256.0;
            }
            assert!((wanted - found).abs() < 9.0, "{block}: {wanted} {found}");
        }
    }
}
