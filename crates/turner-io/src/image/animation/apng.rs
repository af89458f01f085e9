//! Animated PNG: the chunks acTL, fcTL and fdAT of the PNG specification, third edition.

use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, Encoder, SrgbRenderingIntent};

use super::{AnimationFormat, Frames, Shape, failed};
use crate::image::ImageError;

const FORMAT: AnimationFormat = AnimationFormat::Apng;

pub(super) fn encode(shape: &Shape, frames: &mut Frames<'_>) -> Result<Vec<u8>, ImageError> {
    let wrong = |e: png::EncodingError| failed(FORMAT, e);
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, shape.width, shape.height);
    // All frames have the same channels, and whether a later one is transparent is not known yet.
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    encoder.set_animated(shape.frames, 0).map_err(wrong)?;
    encoder.set_dispose_op(DisposeOp::None).map_err(wrong)?;
    encoder.set_blend_op(BlendOp::Source).map_err(wrong)?;
    let mut writer = encoder.write_header().map_err(wrong)?;
    for i in 0..shape.frames {
        let frame = frames(i)?;
        writer.set_frame_delay(shape.duration(i, 1000.0) as u16, 1000).map_err(wrong)?;
        writer.write_image_data(frame.pixels.as_flattened()).map_err(wrong)?;
    }
    writer.finish().map_err(wrong)?;
    Ok(out)
}

#[cfg(test)]
pub(super) mod tests {
    /// Frames and durations in milliseconds.
    pub(crate) fn decoded(bytes: &[u8]) -> Vec<(Vec<[u8; 4]>, f64)> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let count = reader.info().animation_control().unwrap().num_frames;
        let mut out = Vec::new();
        for _ in 0..count {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let control = *reader.info().frame_control().unwrap();
            let duration = 1000.0 * f64::from(control.delay_num) / f64::from(control.delay_den);
            out.push((pixels.as_chunks().0.to_vec(), duration));
        }
        out
    }
}
