//! Caustics: light that mirrors and glass gather, found by light paths.
//!
//! A path from the camera finds such light by chance alone: it must leave a diffuse surface in the one direction in which a mirror or a lens shows the light. From the
//! light it is easy: paths that begin there and are aimed at what gathers light ([`crate::scene::casters`]) are joined to the camera wherever they are scattered after that
//! (Dutré, Lafortune and Willems 1993). Both ways have weights that add to 1 for every path, so that the picture stays what it is, and becomes less noisy.

mod light_path;
mod light_path_batch;
mod photons;
mod probe;
mod reverse_pdf;
mod strategy;
mod surface_bsdf;

pub(super) use light_path_batch::LightPathBatch;
pub use photons::{Gathered, Photon, PhotonMap};
pub(super) use reverse_pdf::{NextVertex, ReversePdf};
pub use strategy::CausticsStrategy;

use crate::schema::choice;

choice! {
    /// How light is found that mirrors and glass gather.
    pub enum Caustics {
        /// As "full" or "light-tracing" where a short test finds that they pay, else as "off".
        Auto = "auto",
        /// By light paths as well as by camera paths, always.
        LightTracing = "light-tracing",
        /// By light paths, and beyond that, where caustics are seen in mirrors or through glass, by photons that arrive nearby: such places are a little blurred, the less the
        /// more samples there are.
        Full = "full",
        /// By camera paths alone.
        Off = "off",
    }
}

/// The weight of a way of finding a path by the power heuristic with exponent 2, where two others have these densities over its own.
fn power(a: f64, b: f64) -> f64 {
    1.0 / (1.0 + a * a + b * b)
}
