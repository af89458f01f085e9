//! JPEG: 8 bits, lossy. Grey files stay grey; CMYK and YCCK become RGB. Colour profiles and EXIF orientation are not
//! applied.

use super::contain::contain;
use super::limits::{Source, buffer};
use super::{DecodeLimits, ImageError, ImageFormat, OutputImage};
use image::codecs::jpeg::{JpegDecoder, JpegEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder};
use std::io::Cursor;
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::Jpeg;

/// Quality of written files, 1 to 100. At 95 no blocks are visible, and files are about a sixth of the PNG's size.
pub const QUALITY: u8 = 95;

/// Each 8 x 8 block of the component with the highest resolution has at least one code of at least one bit.
const PIXELS_PER_BYTE: u64 = 8 * 64;

/// Reads a baseline or progressive JPEG.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    contain(name, FORMAT, || {
        let damaged = |e: image::ImageError| ImageError::damaged(name, FORMAT, e);
        let decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let channels = match decoder.color_type() {
            ColorType::L8 => 1,
            ColorType::Rgb8 => 3,
            other => {
                let expected = "8-bit grey, YCbCr, RGB or CMYK";
                return Err(ImageError::unsupported(name, FORMAT, format!("{other:?} samples"), expected));
            }
        };
        // Progressive files keep 16-bit coefficients for each sample during decoding.
        let pixel_bytes = u64::from(channels) * 3;
        let source = Source { name, format: FORMAT, bytes: bytes.len() };
        let size = limits.check(source, width.into(), height.into(), pixel_bytes, PIXELS_PER_BYTE)?;
        let mut samples = buffer(size.pixels * usize::from(channels), name)?;
        decoder.read_image(&mut samples).map_err(damaged)?;
        Ok(Image { width, height, channels, pixels: Pixels::U8(samples) })
    })
}

/// Encodes the display samples as RGB with quality [`QUALITY`]; alpha and metadata are dropped.
pub fn encode(image: &OutputImage<'_>) -> Result<Vec<u8>, ImageError> {
    let rgb = image.eight_bit_srgb(FORMAT, false)?;
    if image.width > 65535 || image.height > 65535 {
        let problem = format!("{} x {} exceeds 65535 on a side; use PNG", image.width, image.height);
        return Err(ImageError::encode(FORMAT, problem));
    }
    let mut out = Vec::new();
    JpegEncoder::new_with_quality(&mut out, QUALITY)
        .encode(&rgb, image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(|e| ImageError::encode(FORMAT, e))?;
    Ok(out)
}
