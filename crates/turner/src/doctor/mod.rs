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
mod grid;
mod kind;
mod lights;
pub mod maps;
mod materials;
mod media;
mod noisy;
mod paths;
mod picture;
mod sights;
mod slow;
mod summary;
mod threads;
mod trees;
mod trial;
mod washed_out;

pub use finding::{Finding, Measure, Question, Severity};
pub use grid::Pixel;
pub use kind::{PathKind, Source};
pub use summary::{KindShare, LightShare, Summary};

use crate::integrator::IntegratorDesc;
use crate::scene::{Scene, SceneDesc};
use evidence::Evidence;

/// How much is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// About how many pixels.
    pub pixels: u32,
    /// Samples of each.
    pub samples: u32,
    /// Threads; 0 is all there are.
    pub threads: usize,
    /// Seconds after which no more pixels are begun.
    pub seconds: f64,
}

impl Default for Options {
    fn default() -> Options {
        Options { pixels: 640, samples: 32, threads: 0, seconds: 10.0 }
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
        .flag("--integrator path --antialias monte-carlo --samples 64")
}

/// Looks at a scene and says what is wrong with it. `desc` is what it was prepared from; film and integrator of `scene` are changed while it looks,
/// and are as before afterwards.
pub fn examine(scene: &mut Scene, desc: &SceneDesc, options: &Options) -> Examination {
    let (film, integrator) = (scene.film.clone(), scene.integrator.clone());
    let gathered = evidence::gather(scene, options);
    (scene.film, scene.integrator) = (film, integrator);
    let e = Evidence::new(scene, desc, gathered);
    let mut findings = Vec::new();
    camera::ask(&e, &mut findings);
    broken::ask(&e, &mut findings);
    if !scene.integrator.is_for_looking() {
        black::ask(&e, &mut findings);
        media::ask(&e, &mut findings);
        blocked::ask(&e, &mut findings);
        washed_out::ask(&e, &mut findings);
        noisy::ask(&e, &mut findings);
    }
    if scene.integrator.is_for_looking() {
        findings.push(looking(&scene.integrator));
    }
    slow::ask(&e, &mut findings);
    settle(&mut findings);
    finding::sort(&mut findings);
    Examination { findings, summary: summary::of(&e) }
}
