//! Path tracing from text to pixels: closed forms first, then one estimator against another.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

mod bad_input;
mod caustics;
mod closed_forms;
#[path = "../classic/common.rs"]
mod common;
mod dispersion;
mod distant;
mod emitters;
mod estimators;
mod glass;
mod light_tree;
mod mix;
mod motion;
mod panes;
mod pixels;
mod replay;
mod reuse;
mod sameness;
mod statistics;
mod subsurface;
mod textures;
mod volumes;
