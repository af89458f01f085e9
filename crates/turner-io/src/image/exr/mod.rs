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
//! are dropped. The channels are, in this order: `R G B [A]` of the first part that has them, `Y [A]`, the same in a
//! named layer, or a single channel as grey. All compressions of the exr crate are supported. NaN and infinite values
//! are kept. EXR stores colours premultiplied by alpha; [`decode`] divides by alpha, [`decode_as_stored`] does not.
//!
//! Writing: one part with 32-bit `R G B [A]`, ZIP compression of 16 scan lines per block, and metadata as `string`
//! and `int` attributes sorted by name. Nothing depends on time, machine or thread count.

mod attributes;
mod channels;
mod read;
mod write;

pub use attributes::read_metadata;
pub use read::{decode, decode_as_stored};
pub use write::{encode, encode_samples};

const FORMAT: super::ImageFormat = super::ImageFormat::Exr;
