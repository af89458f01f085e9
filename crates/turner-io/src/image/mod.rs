//! Pictures: PNG, OpenEXR, Radiance HDR and JPEG to and from memory, WebP, TGA, BMP and PFM from it, and the safe way to
//! put one on disk.
//!
//! ```text
//! bytes ── decode ──> turner::image::Image          8 bits stay 8 bits, 16 stay 16, EXR and HDR are floats
//! OutputImage ── encode ──> bytes ── OutputFile::commit ──> disk, whole or not at all
//! ```
//!
//! Nothing here opens a scene's files: bytes come through [`crate::assets::AssetSource`]. A decoder looks at the
//! size that a file claims before it reserves any memory (see [`DecodeLimits`]), and a panic inside one of the
//! decoding crates becomes an [`ImageError`].
//!
//! Colour management is the caller's: PNG gamma and profile chunks, JPEG profiles and the EXPOSURE line of HDR
//! files are not applied, and the transform from the linear to the display samples of an [`OutputImage`] is the
//! renderer's.

pub mod bmp;
mod contain;
mod decode_all;
mod error;
pub mod exr;
mod format;
pub mod hdr;
pub mod jpeg;
mod kept;
mod limits;
mod metadata;
mod output;
mod output_image;
pub mod pfm;
pub mod png;
mod shrink;
mod temporary;
pub mod tga;
pub mod webp;

pub use contain::silence_contained_panics;
pub use decode_all::{ColorOrData, EncodedPicture, decode_all};
pub use error::{ImageError, SizeHelp};
pub use format::ImageFormat;
pub use kept::KeptPictures;
pub use limits::DecodeLimits;
pub use metadata::{MetaValue, Metadata};
pub use output::{OutputError, OutputFile};
pub use output_image::{Display, OutputImage, Transfer};
pub(crate) use shrink::to_fit;

use turner::image::Image;

/// Reads a picture. The format is found from its bytes; `name` is for messages, and its extension counts only for
/// TGA, which has no signature.
///
/// A picture with alpha comes back with straight alpha, whatever the file stores.
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
    }
}

/// Writes a picture into memory. The same input gives the same bytes, on any machine and any number of threads.
pub fn encode(image: &OutputImage<'_>, format: ImageFormat) -> Result<Vec<u8>, ImageError> {
    match format {
        ImageFormat::Png => png::encode(image),
        ImageFormat::Exr => exr::encode(image),
        ImageFormat::Hdr => hdr::encode(image),
        ImageFormat::Jpeg => jpeg::encode(image),
        ImageFormat::WebP | ImageFormat::Tga | ImageFormat::Bmp | ImageFormat::Pfm => {
            Err(ImageError::encode(format, "it is read, not written; use PNG"))
        }
    }
}

/// The text and integer metadata of a PNG or EXR file, without decoding a pixel; empty for the others.
/// PNG knows text only, so an integer written there comes back as [`MetaValue::Text`].
pub fn read_metadata(bytes: &[u8], name: &str) -> Result<Metadata, ImageError> {
    match ImageFormat::of_bytes(bytes, name)? {
        ImageFormat::Png => png::read_metadata(bytes, name),
        ImageFormat::Exr => exr::read_metadata(bytes, name),
        ImageFormat::Hdr
        | ImageFormat::Jpeg
        | ImageFormat::WebP
        | ImageFormat::Tga
        | ImageFormat::Bmp
        | ImageFormat::Pfm => Ok(Metadata::new()),
    }
}
