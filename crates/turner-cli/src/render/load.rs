//! Loads the scene of a render and reports what is ignored or doubtful in it.

use turner::film::Antialias;
use turner::schema::{Warning, WarningKind};
use turner_io::scene::ModelOverrides;

use super::RenderArgs;
use crate::control::Control;
use crate::failure::Failure;
use crate::output::Output;
use crate::report::{Reporter, strict};
use crate::scene::Ready;
use crate::sequence::Step;

/// Loads and prepares the scene. `first` holds the steps of the sequence for its first picture: only then are warnings
/// reported.
pub(super) fn load(
    args: &RenderArgs,
    models: ModelOverrides,
    output: &Output,
    (reporter, control): (&Reporter, &Control),
    first: Option<&[Step]>,
) -> Result<Ready, Failure> {
    let mut ready = args.scene.ready(&args.film, models, args.run.threads, control)?;
    args.budget.open(&mut ready.prepared, args.film.has_samples());
    if args.film.has_samples()
        && !matches!(ready.prepared.view.film.antialias, Antialias::Grid | Antialias::MonteCarlo)
        && !ready.prepared.view.labels
    {
        let word = ready.prepared.view.film.antialias.word();
        let message =
            format!("--samples is ignored with antialias = \"{word}\": add --antialias monte-carlo");
        ready.prepared.warnings.push(Warning::new(WarningKind::Ignored, message));
    }
    if let Some(steps) = first
        && !moves(args, steps, &ready, control)?
    {
        let message = "nothing in this scene moves: all frames are the same picture; omit --frames, or use a glTF model with an animation";
        ready.prepared.warnings.push(Warning::new(WarningKind::Ignored, message));
    }
    let warnings = &ready.prepared.warnings;
    if args.strict && warnings.iter().any(|w| w.kind == WarningKind::Ignored) {
        return Err(strict(warnings, &ready.sources, &ready.labels));
    }
    // In text, warnings about models follow the closing line.
    if first.is_some() && (ready.desc.imports.is_empty() || reporter.events.is_some()) {
        reporter.imports(&ready.desc.imports);
        reporter.warnings(warnings, &ready.sources, &ready.labels);
    }
    output.check_against(&args.scene.scene, &ready.desc)?;
    output.check_film(&ready.prepared.view.film)?;
    // Rendering does not need the description of the objects.
    (ready.desc.objects, ready.desc.groups) = (Vec::new(), Vec::new());
    Ok(ready)
}

/// Whether the scene changes over the frames `steps`; true if no frames are rendered. Only glTF models have animations.
/// The first frame is compared with the second and the middle one: in a loop the last frame equals the first.
fn moves(args: &RenderArgs, steps: &[Step], ready: &Ready, control: &Control) -> Result<bool, Failure> {
    let (Some(Step::Frame(_)), [_, second, ..]) = (steps.first(), steps) else { return Ok(true) };
    if !ready.desc.imports.iter().any(|i| i.format.starts_with("glTF")) {
        return Ok(false);
    }
    let limits = args.scene.watched_limits(control);
    for step in [second, &steps[steps.len() / 2]] {
        let Step::Frame(frame) = step else { continue };
        let models = args.scene.studio.at_frame(*frame);
        let other = args.scene.described(&args.film, models, args.run.threads, None, &limits)?;
        if other.desc.same_scene(&ready.desc).is_err() {
            return Ok(true);
        }
    }
    Ok(false)
}
