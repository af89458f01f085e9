//! Path tracing from a scene to pixels: closed forms first, then one estimator against another.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

mod bad_input;
mod caustics;
mod dispersion;
mod estimators;
mod glass;
mod hair;
mod hidden_from_camera;
mod light_samples;
mod panes;
mod replay;
mod replay_scenes;
mod sameness;
mod shadow_catcher;
mod shared_paths;
mod solids;
mod subsurface;
mod volumes;
