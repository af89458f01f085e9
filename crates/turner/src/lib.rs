//! The Turner ray tracer: from a scene description to a picture.
//!
//! This crate opens no file, no window and no thread pool of its own choice: see ARCHITECTURE.md.
#![forbid(unsafe_code)]

pub mod bsdf;
pub mod camera;
pub mod color;
pub mod compare;
pub mod film;
pub mod filter;
pub mod image;
pub mod integrator;
pub mod light;
pub mod material;
pub mod math;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod shape;
pub mod testing;
pub mod texture;
