//! OpenEXR: linear floats with metadata.
//!
//! Read: scan lines and tiles, every compression of the exr crate, half, float and integer channels, many layers.
//! The picture is what the display window shows: pixels outside the data window are 0, those outside the display
//! window are cut off. Chosen, in this order, are the first part's `R G B [A]`, `Y [A]`, the same in a named layer
//! (`diffuse.R`, …), or an only channel as grey. NaN and infinities come back as stored.
//!
//! Written: one part of 32-bit `R G B [A]`, ZIP16, metadata as `string` and `int` attributes in the order of their
//! names, nothing that depends on time or machine.

mod attributes;
mod channels;
mod read;
mod write;

pub use attributes::read_metadata;
pub use read::{decode, decode_as_stored};
pub use write::{encode, encode_samples};

const FORMAT: super::ImageFormat = super::ImageFormat::Exr;
