//! Why a picture is black, noisy, washed out or slow. A short probe of the scene measures facts; rules turn them into findings.
//!
//! ```text
//! examine ── grid (pixels) ─┬─ sights   first hits of camera rays, and their search cost    ┐
//!                           ├─ paths    replayed samples: light and variance of each kind   │
//!                           │           of path                                (kind)       ├─ Evidence ── black · camera · noisy ·
//!                           ├─ trees    the same for the classic integrator                 │    washed_out · slow · broken ── Finding
//!                           ├─ lights   irradiance from each light, and what blocks it      │
//!                           └─ trial    the same pixels with a setting changed              ┘
//! ```
//!
//! The probe traces a fixed number of samples. So an examination finds the same every time, on any machine and with any number of threads. A time limit stops it only where
//! it would take far longer than usual; a finding then says so.

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
pub use summary::{KindShare, LightShare, Summary};

use std::fmt;

use evidence::Evidence;
use subject::Subject;

use crate::description::SceneDesc;
use crate::integrator::{IntegratorDesc, Prepared};
use crate::schema::Remedy;

/// The size of the probe.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Pixels, approximately.
    pub pixels: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Threads; 0 uses all of them.
    pub threads: usize,
    /// Whether time is up. Called before each pixel, from any thread; when it returns true no more pixels are begun. Turner itself reads no clock.
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
    /// The findings, the worst first.
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

/// Where one finding causes another, the latter becomes a note.
fn settle(findings: &mut [Finding]) {
    let has = |findings: &[Finding], code: &str| {
        findings.iter().any(|f| f.code == code && f.severity != Severity::Note)
    };
    // Between surfaces that reflect all light a path never ends, whatever its depth.
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

/// Debug views show no light, so their light is not examined.
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

/// Examines a scene and lists what is wrong with it. `desc` is what it was prepared from.
pub fn examine(prepared: &Prepared, desc: &SceneDesc, options: &Options<'_>) -> Examination {
    let own = Subject { prepared: prepared.clone(), integrator: desc.integrator.clone() };
    let gathered = evidence::gather(&mut own.clone(), options);
    let scene = &own;
    let e = Evidence::new(scene, desc, gathered);
    let mut findings = Vec::new();
    camera::ask(&e, &mut findings);
    broken::ask(&e, &mut findings);
    if !scene.integrator.capabilities().debug {
        black::ask(&e, &mut findings);
        media::ask(&e, &mut findings);
        blocked::ask(&e, &mut findings);
        washed_out::ask(&e, &mut findings);
        noisy::ask(&e, &mut findings);
    }
    if scene.integrator.capabilities().debug {
        findings.push(debug_view(&scene.integrator));
    }
    slow::ask(&e, &mut findings);
    settle(&mut findings);
    finding::sort(&mut findings);
    Examination { findings, summary: summary::of(&e) }
}
