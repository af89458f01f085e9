//! Colours: the spectrum type, tone mapping, transfer curves, colour names and a colour map.

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
