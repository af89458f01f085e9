//! Why a picture is black, noisy, washed out or slow: judged by facts that a short probing render measures.
//!
//! ```text
//! examine ── grid (pixels) ─┬─ sights   what camera rays meet first, and at what cost       ┐
//!                           ├─ paths    samples replayed: what each sort of path brings,    │
//!                           │           and the variance it carries            (kind)       ├─ Evidence ── black · camera · noisy ·
//!                           ├─ trees    the same for the classic integrator                 │    washed_out · slow · broken ── Finding
//!                           ├─ lights   what each light brings where, and what keeps it off │
//!                           └─ trial    the same pixels with a setting changed              ┘
//! ```
//!
//! What is looked at is a fixed number of samples, so that an examination finds the same every time, on any machine and with any
//! number of threads; a limit of time cuts it short only where it would take far longer than usual, and it then says so.

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

/// How much is looked at.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// About how many pixels.
    pub pixels: u32,
    /// Samples of each.
    pub samples: u32,
    /// Threads; 0 is all there are.
    pub threads: usize,
    /// Whether time is up: asked before each pixel, from any thread; no more are begun then. Turner itself asks no clock.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Default for Options<'_> {
    /// Takes the time it needs.
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

/// What was found.
#[derive(Clone, Debug)]
pub struct Examination {
    /// The worst first.
    pub findings: Vec<Finding>,
    /// What was measured, in short.
    pub summary: Summary,
}

impl Examination {
    /// Whether anything is an error.
    pub fn has_errors(&self) -> bool {
        self.findings.iter().any(|f| f.severity == Severity::Error)
    }
}

/// Where one finding is the cause of another, the latter is a note.
fn settle(findings: &mut [Finding]) {
    let has = |findings: &[Finding], code: &str| {
        findings.iter().any(|f| f.code == code && f.severity != Severity::Note)
    };
    // Between surfaces that return all light it ends nowhere, however deep it is followed.
    let pairs = [
        ("albedo-too-high", "depth-too-low"),
        ("light-enclosed", "light-too-weak"),
        ("exposure-too-low", "light-too-weak"),
        ("medium-too-dense", "light-too-weak"),
        ("medium-too-dense", "depth-too-low"),
        ("glass-too-dark", "light-too-weak"),
        ("objects-invisible", "objects-not-met"),
        ("seen-from-behind", "objects-not-met"),
        ("crop-misses", "objects-not-met"),
    ];
    for (cause, effect) in pairs {
        if has(findings, cause) {
            for f in findings.iter_mut().filter(|f| f.code == effect) {
                f.severity = Severity::Note;
            }
        }
    }
}

/// Light is not looked at where none is shown.
fn looking(integrator: &IntegratorDesc) -> Finding {
    let what = format!(
        "the integrator \"{}\" shows what is at the first hit of each ray, not light",
        integrator.type_name()
    );
    Finding::new(Question::Broken, Severity::Note, "not-light", 0.5, what)
        .why("lights, materials and noise play no part in the picture")
        .remedy("choose an integrator that follows light")
        .or(Remedy::set("integrator.type", "path")
            .and("film.antialias", "monte-carlo")
            .and("film.samples", 64))
}

/// Looks at a scene and says what is wrong with it. `desc` is what it was prepared from.
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
        findings.push(looking(&scene.integrator));
    }
    slow::ask(&e, &mut findings);
    settle(&mut findings);
    finding::sort(&mut findings);
    Examination { findings, summary: summary::of(&e) }
}
