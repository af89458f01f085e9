//! Image files: PNG, OpenEXR, Radiance HDR, JPEG and WebP are read and written, TGA, BMP, PFM and KTX2 are read; and
//! safe replacement of files on disk.
//!
//! ```text
//! bytes ── decode ──> turner::image::Image          8 and 16 bits are kept, EXR, HDR and PFM become floats
//! OutputImage ── encode ──> bytes ── OutputFile::commit ──> disk, complete or not at all
//! StripImage ── write ──────────────────────────────────> the same, for pictures too large to be in memory
//! ```
//!
//! This module does not open a scene's files; bytes come through [`crate::assets::AssetSource`]. Decoders check the
//! claimed size before they reserve memory (see [`DecodeLimits`]), and a panic inside a decoding crate becomes an
//! [`ImageError`].
//!
//! Colour management is the caller's task: PNG gamma and profile chunks, JPEG profiles and the EXPOSURE line of HDR
//! files are not applied, and an [`OutputImage`] holds linear and display samples that the renderer has already
//! converted.

pub mod animation;
pub mod bmp;
pub(crate) mod contain;
mod decode_all;
mod error;
pub mod exr;
mod extra_channel;
mod format;
pub mod hdr;
mod icc;
pub mod jpeg;
mod kept;
pub mod ktx2;
mod limits;
mod metadata;
mod output;
mod output_image;
pub mod pfm;
pub mod png;
mod shrink;
mod strips;
mod temporary;
pub mod tga;
pub mod webp;

pub use contain::silence_contained_panics;
pub use decode_all::{ColorOrData, EncodedPicture, decode_all};
pub use error::{ImageError, SizeHelp};
pub use exr::{ExrCompression, ExrOptions};
pub use extra_channel::{ChannelValues, ExtraChannel, SampleKind};
pub use format::ImageFormat;
pub use kept::KeptPictures;
pub use limits::DecodeLimits;
pub use metadata::{MetaValue, Metadata};
pub use output::{OutputError, OutputFile};
pub use output_image::{Display, OutputImage, Transfer};
pub(crate) use shrink::to_fit;
pub use strips::{Strip, StripImage, WriteSeek, write};

use turner::image::Image;

/// Reads an image. The format is recognised from the bytes; `name` appears in messages, and its extension matters
/// only for TGA, which has no signature.
///
/// An image with alpha has straight alpha, whatever the file stores.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    match ImageFormat::of_bytes(bytes, name)? {
        ImageFormat::Png => png::decode(bytes, name, limits),
        ImageFormat::Exr => exr::decode(bytes, name, limits),
        ImageFormat::Hdr => hdr::decode(bytes, name, limits),
        ImageFormat::Jpeg => jpeg::decode(bytes, name, limits),
        ImageFormat::WebP => webp::decode(bytes, name, limits),
        ImageFormat::Tga => tga::decode(bytes, name, limits),
        ImageFormat::Bmp => bmp::decode(bytes, name, limits),
        ImageFormat::Pfm => pfm::decode(bytes, name, limits),
        ImageFormat::Ktx2 => ktx2::decode(bytes, name, limits),
    }
}

/// Reads an image whose user knows whether its samples of 8 and 16 bits are sRGB-encoded, whatever the file says.
fn decode_as_stored(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    match ImageFormat::of_bytes(bytes, name)? {
        ImageFormat::Ktx2 => ktx2::decode_as_stored(bytes, name, limits),
        _ => decode(bytes, name, limits),
    }
}

/// Encodes an image. The same input gives the same bytes on any machine and with any number of threads.
pub fn encode(image: &OutputImage<'_>, format: ImageFormat) -> Result<Vec<u8>, ImageError> {
    strips::encode(image, format)
}

/// The text and integer metadata of a PNG or EXR file, without decoding pixels; empty for other formats. PNG stores
/// only text, so an integer is read back as [`MetaValue::Text`].
pub fn read_metadata(bytes: &[u8], name: &str) -> Result<Metadata, ImageError> {
    match ImageFormat::of_bytes(bytes, name)? {
        ImageFormat::Png => png::read_metadata(bytes, name),
        ImageFormat::Exr => exr::read_metadata(bytes, name),
        ImageFormat::Hdr
        | ImageFormat::Jpeg
        | ImageFormat::WebP
        | ImageFormat::Tga
        | ImageFormat::Bmp
        | ImageFormat::Pfm
        | ImageFormat::Ktx2 => Ok(Metadata::new()),
    }
}
