//! Colours: the working spectrum, tone mapping, transfer curves, names.

mod names;
mod spectrum;
mod tonemap;
mod transfer;

pub(crate) use names::from_rgb24;
pub use names::{NAMES, named};
pub use spectrum::Spectrum;
pub use tonemap::Tonemap;
pub use transfer::{Transfer, srgb_decode, srgb_encode};
