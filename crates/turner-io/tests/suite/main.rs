//! Tests of scenes and files, from text to pictures, linked into one program.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

mod animation;
mod classic;
mod convert;
mod edit;
mod files;
mod path;
