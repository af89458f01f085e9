//! Diagnoses why a picture is black, noisy, washed out or slow. A short probe measures the scene; rules turn the
//! measurements into findings.
//!
//! ```text
//!           pixels
//! examine ── grid ─┬─ first_hits  what camera rays hit, and what the search costs ─┐
//!                  ├─ paths       light and variance by kind of path (kind)        │             rules: black, blocked,
//!                  ├─ trees       ray trees of the classic integrator              ├─ Evidence ── media, camera, noisy,
//!                  ├─ lights      irradiance from each light, and what blocks it   │             washed_out, slow, broken
//!                  └─ trial       the same pixels with a setting changed           ┘              └── Finding
//! ```
//!
//! - **Light and variance.** Each sample of the probe is replayed with a record of its path. The sample X is the sum of
//!   contributions X_k, each with a kind of path, a light and a material. As var(X) = Σ cov(X_k, X), every contribution
//!   has a well-defined part of the variance, and the parts sum to it. This shows which light or material causes the
//!   noise. The expected error of the picture is the relative variance of one sample divided by the number of samples.
//! - **Lights.** Each light is sampled from visible surface points, and a shadow ray finds the object that blocks it.
//! - **Trials.** If a setting may remove light, the same samples are traced again with the setting changed.
//!
//! Each rule compares measurements with thresholds and attaches them to its finding. A finding that is the effect of
//! another one becomes a note.
//!
//! The probe traces a fixed number of samples, so the findings do not depend on the machine or the number of threads.
//! Only a scene that takes far longer than usual runs into the time limit, and a finding then reports that.

mod black;
mod blocked;
mod broken;
mod camera;
mod evidence;
mod finding;
mod first_hits;
mod grid;
mod kind;
mod lights;
pub mod maps;
mod materials;
mod media;
mod noisy;
mod paths;
mod picture;
mod slow;
mod subject;
mod summary;
#[cfg(test)]
mod tests;
mod threads;
mod trees;
mod trial;
mod washed_out;

pub use finding::{Finding, Measure, Question, Severity};
pub use grid::Pixel;
pub use kind::{PathKind, Source};
pub use summary::{KindSummary, LightSummary, Summary};

use std::fmt;

use evidence::Evidence;
use subject::Subject;

use crate::description::SceneDesc;
use crate::integrator::{IntegratorDesc, Prepared};
use crate::schema::Remedy;

/// The size of the probe.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Number of pixels, approximately.
    pub pixels: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Threads; 0 uses all of them.
    pub threads: usize,
    /// Whether the time limit is reached. Called before each pixel, from any thread; once it returns true, no more
    /// pixels are started. Turner itself reads no clock.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Default for Options<'_> {
    /// No time limit.
    fn default() -> Self {
        Options { pixels: 640, samples: 32, threads: 0, stop: &|| false }
    }
}

impl fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Options { pixels, samples, threads, stop: _ } = self;
        f.debug_struct("Options")
            .field("pixels", pixels)
            .field("samples", samples)
            .field("threads", threads)
            .finish_non_exhaustive()
    }
}

/// The result of an examination.
#[derive(Clone, Debug)]
pub struct Examination {
    /// The findings, most severe first.
    pub findings: Vec<Finding>,
    /// A summary of the measurements.
    pub summary: Summary,
}

impl Examination {
    /// Whether any finding is an error.
    pub fn has_errors(&self) -> bool {
        self.findings.iter().any(|f| f.severity == Severity::Error)
    }
}

/// Makes a finding a note if another finding is its cause.
fn demote_effects(findings: &mut [Finding]) {
    let has = |findings: &[Finding], code: &str| {
        findings.iter().any(|f| f.code == code && f.severity != Severity::Note)
    };
    // Pairs of (cause, effect). Between surfaces that reflect all light, paths reach any depth limit.
    let pairs = [
        ("albedo-too-high", "depth-too-low"),
        ("light-enclosed", "light-too-weak"),
        ("exposure-too-low", "light-too-weak"),
        ("medium-too-dense", "light-too-weak"),
        ("medium-too-dense", "depth-too-low"),
        ("glass-too-dark", "light-too-weak"),
        ("objects-invisible", "objects-not-hit"),
        ("back-faces-culled", "objects-not-hit"),
        ("crop-misses", "objects-not-hit"),
    ];
    for (cause, effect) in pairs {
        if has(findings, cause) {
            for f in findings.iter_mut().filter(|f| f.code == effect) {
                f.severity = Severity::Note;
            }
        }
    }
}

/// The finding for debug views, which do not compute light.
fn debug_view(integrator: &IntegratorDesc) -> Finding {
    let what = format!(
        "the integrator \"{}\" shows a property of the first hit of each camera ray, not light",
        integrator.type_name()
    );
    Finding::new(Question::Broken, Severity::Note, "debug-view", 0.5, what)
        .why("lights and noise do not affect the picture")
        .remedy("use an integrator that computes light, such as \"path\"")
        .or(Remedy::set("integrator.type", "path")
            .and("film.antialias", "monte-carlo")
            .and("film.samples", 64))
}

/// Examines a scene. `desc` is the description that it was prepared from.
pub fn examine(prepared: &Prepared, desc: &SceneDesc, options: &Options<'_>) -> Examination {
    let own = Subject { prepared: prepared.clone(), integrator: desc.integrator.clone() };
    let gathered = evidence::gather(&mut own.clone(), options);
    let scene = &own;
    let e = Evidence::new(scene, desc, gathered);
    let mut findings = Vec::new();
    camera::check(&e, &mut findings);
    broken::check(&e, &mut findings);
    if !scene.integrator.capabilities().debug {
        black::check(&e, &mut findings);
        media::check(&e, &mut findings);
        blocked::check(&e, &mut findings);
        washed_out::check(&e, &mut findings);
        noisy::check(&e, &mut findings);
    }
    if scene.integrator.capabilities().debug {
        findings.push(debug_view(&scene.integrator));
    }
    slow::check(&e, &mut findings);
    demote_effects(&mut findings);
    finding::sort(&mut findings);
    Examination { findings, summary: summary::of(&e) }
}
