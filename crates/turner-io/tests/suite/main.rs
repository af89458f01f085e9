//! Scenes and files from text to pictures: one program for all of these tests, which is linked once.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

mod classic;
mod convert;
mod files;
mod path;
