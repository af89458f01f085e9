//! Colours: the working spectrum, transfer curves, names.

mod names;
mod spectrum;
mod transfer;

pub(crate) use names::from_rgb24;
pub use names::{NAMES, named};
pub use spectrum::Spectrum;
pub use transfer::{Transfer, srgb_decode, srgb_encode};
