//! KTX 2.0, read only: Basis Universal (ETC1S with BasisLZ, UASTC LDR 4x4) and uncompressed samples, with or without
//! Zstandard or ZLIB.
//!
//! ```text
//! container ──> level ──> etc1s, uastc or plain ──> samples: swizzle, straight alpha, orientation ──> Image
//! ```
//!
//! The picture is level 0 of layer 0. Cube maps, 3-D textures and video are rejected. The colours of the picture are
//! those that the reference transcoder writes as RGBA, 8 bits each.

mod container;
mod etc1s;
mod fault;
mod level;
mod plain;
mod read;
mod samples;
mod uastc;

use super::contain::contain;
use super::limits::{Source, buffer};
use super::{DecodeLimits, ImageError, ImageFormat};
use crate::assets::printable;
use container::Container;
pub(super) use container::SIGNATURE;
use fault::Fault;
use read::Coding;
use samples::Samples;
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::Ktx2;

/// Reads a KTX2 file: 1 to 4 channels. Samples of 8 and 16 bits that the file says are linear become floats.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let (image, is_linear) = read(bytes, name, limits, true)?;
    if is_linear { floats(image, name) } else { Ok(image) }
}

/// Reads a KTX2 file whose user knows whether samples of 8 and 16 bits are sRGB-encoded, whatever the file says.
pub fn decode_as_stored(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    Ok(read(bytes, name, limits, false)?.0)
}

/// The image, and whether the file says that its samples are linear. `may_be_floats` tells whether linear samples will
/// become floats, for which there must be memory.
fn read(
    bytes: &[u8],
    name: &str,
    limits: &DecodeLimits,
    may_be_floats: bool,
) -> Result<(Image, bool), ImageError> {
    contain(name, FORMAT, || {
        let explain = |fault| match fault {
            Fault::Damaged(problem) => ImageError::damaged(name, FORMAT, problem),
            Fault::Unsupported { found, expected } => ImageError::unsupported(name, FORMAT, found, expected),
            Fault::Memory(bytes) => ImageError::OutOfMemory { name: printable(name), bytes },
        };
        let container = Container::read(bytes).map_err(explain)?;
        let coding = Coding::of(&container).map_err(explain)?;
        let source = Source { name, format: FORMAT, bytes: bytes.len() };
        let (width, height) = (u64::from(container.width), u64::from(container.height));
        let density = coding.pixels_per_byte(container.supercompression);
        let is_linear = read::is_linear(&container, coding);
        let pixel_bytes = coding.working_bytes(container.supercompression)
            + if is_linear && may_be_floats { 16 } else { 0 };
        let size = limits.check(source, width, height, pixel_bytes, density)?;
        let picture = read::picture(&container, coding).map_err(explain)?;
        let pixels = match picture.samples {
            Samples::U8(samples) => Pixels::U8(samples),
            Samples::U16(samples) => Pixels::U16(samples),
            Samples::F32(samples) => Pixels::F32(samples),
        };
        let image = Image { width: size.width, height: size.height, channels: picture.channels, pixels };
        Ok((image, is_linear))
    })
}

/// The image with float samples, which are linear.
fn floats(image: Image, name: &str) -> Result<Image, ImageError> {
    let pixels = match image.pixels {
        Pixels::U8(samples) => {
            let mut out = buffer::<f32>(samples.len(), name)?;
            out.iter_mut().zip(samples).for_each(|(out, v)| *out = f32::from(v) / 255.0);
            out
        }
        Pixels::U16(samples) => {
            let mut out = buffer::<f32>(samples.len(), name)?;
            out.iter_mut().zip(samples).for_each(|(out, v)| *out = f32::from(v) / 65535.0);
            out
        }
        Pixels::F32(samples) => samples,
    };
    Ok(Image { pixels: Pixels::F32(pixels), ..image })
}
