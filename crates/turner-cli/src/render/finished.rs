//! Whether a picture of a sequence is complete, so that `--resume` skips it.

use serde_json::json;
use turner::color::DisplaySpace;
use turner::film::DisplayTransform;

use super::budget::UNLIMITED;
use super::one::{FINISHED, SAMPLE_RANGE};
use crate::output::Output;
use crate::recipe::{self, Recipe};
use crate::report::Reporter;
use crate::scene::{Hashes, Ready};

/// Metadata that is known only after rendering, that the hash of the scene covers, or that name the same scene.
const LATE: [&str; 8] = [
    recipe::CAMERA,
    recipe::COMMAND,
    recipe::SCENE,
    recipe::STEP,
    "turner:exposure",
    "turner:caustics",
    "turner:sharedPaths",
    "turner:lightSamples",
];

/// Whether the file is the complete picture of this scene with these settings: its metadata say so. JPEG and HDR files
/// have none and are rendered again.
pub(super) fn is_finished(
    output: &Output,
    ready: &Ready,
    hashes: &Hashes,
    recipe: &Recipe,
    reporter: &Reporter,
) -> bool {
    let Some(found) = output.existing_metadata() else { return false };
    let samples = ready.prepared.view.film.samples_per_pixel();
    let film = &ready.prepared.view.film;
    let shown = DisplayTransform {
        exposure: film.exposure,
        tonemap: film.tonemap,
        transfer: film.transfer,
        space: DisplaySpace::Srgb,
    };
    let expected =
        output.metadata(&ready.prepared, &ready.desc.integrator, &hashes.whole, samples, &shown, recipe);
    let is_same = expected
        .iter()
        .filter(|(name, _)| !LATE.contains(&name.as_str()))
        // Time or noise decides their number.
        .filter(|(name, _)| samples < UNLIMITED || *name != "turner:samples")
        .all(|(name, value)| found.get(name).is_some_and(|v| v.to_string() == value.to_string()));
    let is_same = is_same && recipe::encoding(&found) == recipe::encoding(&expected);
    let is_finished = is_same && !found.contains_key(FINISHED) && !found.contains_key(SAMPLE_RANGE);
    if is_finished {
        match reporter.events {
            Some(events) => events.send(json!({ "event": "skipped", "output": output.name() })),
            None => reporter.line(&format!("{}: complete, skipped", output.name())),
        }
    }
    is_finished
}
