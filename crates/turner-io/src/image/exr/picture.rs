//! Reads channels of an EXR file as an image.

use super::FORMAT;
use super::channels::{Choice, choose, in_layer_named};
use super::read::{Line, Opened};
use crate::image::contain::contain;
use crate::image::limits::buffer;
use crate::image::{DecodeLimits, ImageError};
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;
use turner::image::{Image, Pixels};

/// Reads an EXR file. Colours are divided by alpha, because [`Image`] has straight alpha. Where alpha is 0 the colour
/// (emission without coverage) is kept.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let mut image = decode_as_stored(bytes, name, limits)?;
    if let (Pixels::F32(samples), n @ (2 | 4)) = (&mut image.pixels, usize::from(image.channels)) {
        for pixel in samples.chunks_exact_mut(n) {
            let alpha = pixel[n - 1];
            if alpha > 0.0 && alpha != 1.0 {
                pixel[..n - 1].iter_mut().for_each(|v| *v /= alpha);
            }
        }
    }
    Ok(image)
}

/// Reads an EXR file with the values as stored: colours stay premultiplied by alpha.
pub fn decode_as_stored(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    contain(name, FORMAT, || read(bytes, name, limits, choose))
}

/// Reads one layer of an EXR file with the values as stored: the channels `LAYER.R LAYER.G LAYER.B [LAYER.A]`, or
/// `.X .Y .Z`, or `.Y`, or the channel `LAYER` itself, as grey. Two channels, such as `.U .V`, become red and green.
///
/// An error names the layers of the file if it has no such layer.
pub fn decode_layer(
    bytes: &[u8],
    name: &str,
    layer: &str,
    limits: &DecodeLimits,
) -> Result<Image, ImageError> {
    contain(name, FORMAT, || read(bytes, name, limits, |headers, name| in_layer_named(headers, name, layer)))
}

fn read(
    bytes: &[u8],
    name: &str,
    limits: &DecodeLimits,
    choose: impl FnOnce(&[Header], &str) -> Result<Choice, ImageError>,
) -> Result<Image, ImageError> {
    let file = Opened::new(bytes, name)?;
    let choice = choose(file.headers(), name)?;
    let channels = usize::from(choice.channels);
    let window = file.window(choice.part, 4 * channels as u64, limits)?;
    let mut samples = buffer(window.size.pixels * channels, name)?;
    file.lines(choice.part, &window, |line| {
        if let Some(Some(to)) = choice.to.get(line.channel)
            && let Some(out) = samples.get_mut(line.first * channels..)
        {
            floats(&line, out.chunks_exact_mut(channels).map(|p| &mut p[usize::from(*to)]));
        }
    })?;
    let (width, height) = (window.size.width, window.size.height);
    Ok(Image { width, height, channels: choice.channels, pixels: Pixels::F32(samples) })
}

/// Converts the samples of a line to floats.
pub(super) fn floats<'a>(line: &Line<'_>, out: impl Iterator<Item = &'a mut f32>) {
    match line.kind {
        SampleType::F16 => copy(line.bytes, out, |b| f16::from_ne_bytes(b).to_f32()),
        SampleType::F32 => copy(line.bytes, out, f32::from_ne_bytes),
        SampleType::U32 => copy(line.bytes, out, |b| u32::from_ne_bytes(b) as f32),
    }
}

/// Converts samples of `N` bytes.
pub(super) fn copy<'a, T: 'a, const N: usize>(
    bytes: &[u8],
    out: impl Iterator<Item = &'a mut T>,
    convert: impl Fn([u8; N]) -> T,
) {
    let (samples, _) = bytes.as_chunks::<N>();
    out.zip(samples).for_each(|(to, from)| *to = convert(*from));
}
