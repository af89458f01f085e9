//! Colours: the spectrum type, tone mapping, transfer curves, colour spaces of displays, colour names, a colour map and kinds of colour vision.

pub(crate) mod cie;
mod display_space;
mod heat;
mod names;
mod scale;
mod spectrum;
mod tonemap;
mod transfer;
mod vision;

pub use cie::black_body;
pub use display_space::{DisplaySpace, REFERENCE_WHITE, pq_encode};
pub use heat::heat;
pub(crate) use names::from_rgb24;
pub use names::{NAMES, named};
pub use scale::ColorScale;
pub use spectrum::Spectrum;
pub use tonemap::Tonemap;
pub use transfer::{Transfer, srgb_decode, srgb_encode};
pub use vision::Vision;
