//! The Turner ray tracer: from a scene description to a picture.
//!
//! This crate opens no file, no window and no thread pool of its own choice: see ARCHITECTURE.md.
#![forbid(unsafe_code)]

pub mod image;
