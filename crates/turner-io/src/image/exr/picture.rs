//! Reads channels of an EXR file as an image.

use super::FORMAT;
use super::channels::{Choice, choose, in_layer_named};
use super::deep::Deep;
use super::read::{Line, Opened, Window};
use super::{chroma, primaries, subsampled};
use crate::image::contain::contain;
use crate::image::limits::buffer;
use crate::image::{DecodeLimits, ImageError};
use exr::meta::attribute::{Chromaticities, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;
use turner::image::{Image, Pixels};
use turner::math::DVec3;

/// Reads an EXR file. Colours are divided by alpha, because [`Image`] has straight alpha. Where alpha is 0 the colour
/// (emission without coverage) is kept. Colours with other chromaticities become those of Rec. 709.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let (mut image, chromaticities) =
        contain(name, FORMAT, || read_with_primaries(bytes, name, limits, choose))?;
    let matrix = chromaticities.as_ref().and_then(primaries::to_rec709);
    if let (Pixels::F32(samples), n @ (3 | 4), Some(matrix)) =
        (&mut image.pixels, usize::from(image.channels), matrix)
    {
        for pixel in samples.chunks_exact_mut(n) {
            if let [r, g, b, ..] = pixel {
                let rgb = DVec3::new(f64::from(*r), f64::from(*g), f64::from(*b));
                [*r, *g, *b] = (matrix * rgb).to_array().map(|v| v as f32);
            }
        }
    }
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
    Ok(read_with_primaries(bytes, name, limits, choose)?.0)
}

fn read_with_primaries(
    bytes: &[u8],
    name: &str,
    limits: &DecodeLimits,
    choose: impl FnOnce(&[Header], &str) -> Result<Choice, ImageError>,
) -> Result<(Image, Option<Chromaticities>), ImageError> {
    let file = Opened::new(bytes, name)?;
    let choice = choose(file.headers(), name)?;
    let channels = usize::from(choice.channels);
    let chromaticities = file.headers().get(choice.part).and_then(|h| h.shared_attributes.chromaticities);
    let window = file.window(choice.part, 4 * channels as u64, limits)?;
    let is_deep = file.headers().get(choice.part).is_some_and(|h| h.deep);
    let samples = if is_deep {
        Deep { bytes, name, headers: file.headers(), part: choice.part }.flatten(&choice, &window)?
    } else if choice.is_chroma {
        luminance_and_chroma(file, name, &choice, &window, chromaticities.as_ref())?
    } else {
        samples(file, name, &choice, &window)?
    };
    let (width, height) = (window.size.width, window.size.height);
    let image = Image { width, height, channels: choice.channels, pixels: Pixels::F32(samples) };
    Ok((image, chromaticities))
}

/// The samples of the chosen channels in a window, pixel by pixel.
fn samples(file: Opened<'_>, name: &str, choice: &Choice, window: &Window) -> Result<Vec<f32>, ImageError> {
    let channels = usize::from(choice.channels);
    let mut samples = buffer(window.size.pixels * channels, name)?;
    file.lines(choice.part, window, |line| {
        if let Some(Some(to)) = choice.to.get(line.channel)
            && let Some(out) = samples.get_mut(line.first * channels..)
        {
            floats(&line, out.chunks_exact_mut(channels).map(|p| &mut p[usize::from(*to)]));
        }
    })?;
    Ok(samples)
}

/// The colours of a picture of luminance and chroma, whose filters need the whole data window.
fn luminance_and_chroma(
    file: Opened<'_>,
    name: &str,
    choice: &Choice,
    window: &Window,
    chromaticities: Option<&Chromaticities>,
) -> Result<Vec<f32>, ImageError> {
    let channels = usize::from(choice.channels);
    let Some(header) = file.headers().get(choice.part) else { return Ok(Vec::new()) };
    let data = window.of_data(header);
    let is_sparse = subsampled::has_subsampled(header);
    let mut values = samples(file, name, choice, &data)?;
    let (width, height) = (data.size.width as usize, data.size.height as usize);
    let weights = chroma::weights(chromaticities);
    let mut picture = chroma::Picture { width, height, channels, values: &mut values };
    if is_sparse {
        picture.reconstruct();
    }
    picture.convert(weights);
    if is_sparse {
        picture.limit_saturation(weights);
    }
    let mut samples = buffer(window.size.pixels * channels, name)?;
    window.place(&data, &values, channels, &mut samples);
    Ok(samples)
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
