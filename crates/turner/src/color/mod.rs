//! Colours: the working spectrum, tone mapping, transfer curves, names, a map from values to colours.

mod heat;
mod names;
mod spectrum;
mod tonemap;
mod transfer;

pub use heat::heat;
pub(crate) use names::from_rgb24;
pub use names::{NAMES, named};
pub use spectrum::Spectrum;
pub use tonemap::Tonemap;
pub use transfer::{Transfer, srgb_decode, srgb_encode};
