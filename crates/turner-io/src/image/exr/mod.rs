//! OpenEXR: linear floats with metadata.
//!
//! An EXR file has one or more parts (layers). Each part has channels with names such as `R` or `diffuse.R`, stored
//! as half, float or 32-bit integer, in blocks of scan lines or tiles, and two rectangles in pixels:
//!
//! ```text
//!   display window: the image          data window: the pixels stored
//!   ┌───────────────────┐              may be smaller, larger or elsewhere
//!   │     ┌─────────────┼───┐
//!   │ 0   │ shown       │cut│
//!   └─────┼─────────────┘   │
//!         └─────────────────┘
//! ```
//!
//! Reading: the image is the display window. Pixels outside the data window are 0; pixels outside the display window
//! are dropped. The channels are, in this order: `R G B [A]` of the first part that has them, luminance and chroma
//! `Y RY BY [A]`, `Y [A]`, the same in a named layer, or a single channel as grey. All compressions of the exr crate are supported. NaN and infinite values
//! are kept. EXR stores colours premultiplied by alpha; [`decode`] divides by alpha, [`decode_as_stored`] does not.
//! [`decode`] converts colours with other `chromaticities` to Rec. 709, and X, Y and Z as well.
//! Deep parts are flattened if no part is flat.
//! [`decode_layer`] reads another layer, [`parts`] lists everything, and [`read_channels`] reads any channels.
//!
//! Writing: one part with `R G B [A]` and any further channels ([`super::ExtraChannel`]), with ZIP, PIZ or no
//! compression ([`ExrOptions`]), and metadata as `string` and `int` attributes sorted by name. Nothing depends on
//! time, machine or thread count.

mod attributes;
mod channels;
mod chroma;
mod columns;
mod deep;
mod options;
mod parts;
mod picture;
mod primaries;
mod read;
mod sorted_header;
mod subsampled;
mod write;

pub use attributes::read_metadata;
pub use options::{ExrCompression, ExrOptions};
pub use parts::{ExrChannel, ExrPart, parts, read_channels};
pub use picture::{decode, decode_as_stored, decode_layer};
pub(super) use write::write;
pub use write::{encode, encode_samples};

const FORMAT: super::ImageFormat = super::ImageFormat::Exr;
