//! Caustics: light focused by mirrors and glass, found by light paths.
//!
//! A camera path finds a caustic only if a BSDF-sampled ray leaves a diffuse surface in exactly the direction in which
//! a mirror or lens shows the light. For a small light that is rare, so the caustic is noisy; for a point light it
//! never happens. Paths from the light find caustics easily, so up to three strategies are combined:
//!
//! ```text
//!                                       * light
//!    camera                            /
//!      o                              x_k     caustic target: glass or metal
//!       \                            /
//!        \                          /
//!         x1 ----------------------'          x1: diffuse surface with the caustic
//! ```
//!
//! 1. Path tracing, from the camera: o, x1, … until a ray hits the light or the light is sampled (BSDF sampling and
//!    NEE).
//! 2. Light tracing, from the light: *, x_k, …, x1. Light paths are aimed at the caustic targets
//!    ([`crate::scene::caustic_targets`]) and are joined to the camera at every later vertex (Dutré, Lafortune and
//!    Willems 1993, "Monte Carlo light tracing with direct computation of pixel intensities"; `light_path_batch`).
//! 3. Photons (vertex merging): a caustic that is seen in a mirror or through glass cannot be joined to the camera.
//!    There the camera path gathers the vertices of light paths within a small radius (Jensen 1996), which shrinks from
//!    sample to sample (Knaus and Zwicker 2011; `photons`).
//!
//! Strategies 1 and 2 are weighted by the power heuristic, from the densities with which each generates the same path,
//! as in VCM (Georgiev et al. 2012, "Light transport simulation with vertex connection and merging"), but without
//! connections between inner vertices. Both sides update the ratio of densities vertex by vertex (`reverse_pdf`,
//! `light_path`). The weights sum to 1, so the sum of both is unbiased. Strategy 3 is not weighted against them: 1 and
//! 2 omit the paths that photons count. Strategy 3 is biased (blurred) for a finite radius but consistent: the mean
//! over samples converges as the radius shrinks.
//!
//! A pilot run (`probe`) tells `strategy` whether light paths reduce noise, how many to trace, and whether photons are
//! needed.

mod arrivals;
mod light_path;
mod light_path_batch;
mod photons;
mod pilot;
mod pilot_light;
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
    /// How caustics are found: light focused by mirrors and glass.
    pub enum Caustics {
        /// As "full" or "light-tracing" where a short test finds a gain, else as "off".
        Auto = "auto",
        /// By light paths in addition to camera paths, always.
        LightTracing = "light-tracing",
        /// By light paths, and where caustics are seen in mirrors or through glass also by photons. Such caustics are
        /// slightly blurred; the blur shrinks as the number of samples grows.
        Full = "full",
        /// By camera paths only.
        Off = "off",
    }
}

/// Power heuristic with exponent 2 for one of three strategies: `a` and `b` are the densities of the other two divided
/// by its own.
fn power(a: f64, b: f64) -> f64 {
    1.0 / (1.0 + a * a + b * b)
}
