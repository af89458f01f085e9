//! Intervals of the error estimate cover the truth in 95 % of the pixels.

use std::sync::atomic::AtomicBool;

use turner::film::ErrorEstimate;
use turner::render::{PassOptions, Renderer};
use turner::schema::SceneError;

use super::check::{Check, Context, Effort, Finding, Verdict};
use super::estimators::ROOM;

/// Renders of each case: their mean is the truth.
const SEEDS: u32 = 200;

const SIZE: [u32; 2] = [26, 20];

/// The fraction that should be covered, and how far from it the measured one may be.
const COVERED: [f64; 2] = [0.95, 0.015];

/// A name, samples per pixel, the filter, and whether pixels share paths.
const CASES: [(&str, u32, &str, &str); 4] = [
    ("box-filter", 16, "box", "off"),
    ("gaussian-filter", 20, "gaussian", "off"),
    ("shared-paths", 32, "box", "always"),
    ("shared-paths-tent", 16, "tent", "always"),
];

pub(super) fn checks() -> Vec<Check> {
    let check = |(name, samples, filter, shared): (&'static str, u32, &'static str, &'static str)| {
        Check::limit(format!("intervals/{name}"), move |cx| covered(cx, samples, filter, shared))
    };
    CASES.into_iter().map(check).collect()
}

fn covered(cx: &Context, samples: u32, filter: &str, shared_paths: &str) -> Result<Finding, SceneError> {
    let text = format!(
        "film.filter = \"{filter}\"\nintegrator = {{ type = \"path\", max_depth = 4, shared_paths = \"{shared_paths}\" }}\n{ROOM}"
    );
    let mut scene = cx.scene(SIZE, samples, &text)?;
    let first = cx.seed_for("intervals") as u32;
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: cx.threads, cancel: &never, progress: None };
    let seeds = if cx.effort == Effort::Long { 4 * SEEDS } else { SEEDS };
    let mut estimates: Vec<ErrorEstimate> = Vec::new();
    for i in 0..seeds {
        scene.view.film.seed = first.wrapping_add(i);
        let mut renderer = Renderer::new(scene.clone())?;
        renderer.pass(u32::MAX, &options)?;
        cx.count(&renderer.film.non_finite, renderer.film.samples());
        estimates.extend(renderer.film.error(cx.threads));
    }
    let fraction = coverage(&estimates);
    let [expected, slack] = COVERED;
    let found =
        format!("{:.2} % of the intervals of {} renders cover their mean", 100.0 * fraction, estimates.len());
    Ok(Finding { verdict: Verdict::Limit((fraction - expected).abs(), slack), found })
}

/// The fraction of intervals that cover the mean of all renders, among pixels that are not exact.
fn coverage(estimates: &[ErrorEstimate]) -> f64 {
    let n = estimates.len() as f64;
    // The mean contains each render, so that renders are closer to it than to the truth.
    let scale = ((n - 1.0) / n).sqrt();
    let (mut covered, mut all) = (0u64, 0u64);
    for i in 0..estimates.first().map_or(0, |e| e.luminance.len()) {
        let values = || estimates.iter().map(|e| f64::from(e.luminance[i]));
        let truth = values().sum::<f64>() / n;
        if values().all(|v| (v - truth).abs() <= 1e-5 * truth) {
            continue;
        }
        all += estimates.len() as u64;
        let within = |e: &&ErrorEstimate| {
            (f64::from(e.luminance[i]) - truth).abs() <= scale * f64::from(e.half_width[i])
        };
        covered += estimates.iter().filter(within).count() as u64;
    }
    covered as f64 / all.max(1) as f64
}
