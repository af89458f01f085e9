#![forbid(unsafe_code)]
//! File formats: bytes for a URI ([`assets`]), pictures ([`image`]).

pub mod assets;
pub mod image;
