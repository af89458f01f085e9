//! `turner render`: renders a scene and writes the picture.
//!
//! ```text
//! render_all ── for each picture ─┬─ load      the scene, its warnings
//!                                 ├─ finished  with --resume: whether the picture is complete
//!                                 └─ one ─┬─ trace    passes and checkpoints
//!                                         └─ report   how it ended
//! ```

mod budget;
mod denoiser;
mod finished;
mod load;
mod one;
mod report;
mod saving;
mod tev;
mod trace;
mod viewers;

use std::path::{Path, PathBuf};

use clap::Args;
use turner::film::Film;
use turner::schema::{ErrorCode, SceneError};
use turner_io::checkpoint::{Checkpoint, Header};

use crate::animation::Animation;
use crate::checkpoint::{self, CheckpointArgs};
use crate::control::Control;
use crate::encoding::EncodingArgs;
use crate::events::Events;
use crate::failure::Failure;
use crate::output::{FormatArg, Output};
use crate::recipe::{Expected, Recipe};
use crate::report::Reporter;
use crate::run_args::RunArgs;
use crate::scene::{FilmArgs, Ready, SceneArgs};
use crate::sequence::{SequenceArgs, Step, Turntable};
use crate::watch::{Changes, Watched};
use budget::BudgetArgs;
pub(crate) use budget::{Budget, UNLIMITED, percent};
use finished::is_finished;
use load::load;
use one::One;
pub(crate) use one::{FINISHED, SAMPLE_RANGE};
use viewers::ViewerArgs;

/// Render a scene (the command `render` may be omitted)
#[derive(Debug, Args)]
#[command(
    after_help = "Ctrl-C saves what is rendered and exits with code 130 (SIGTERM: 143). A second Ctrl-C, half a\n\
                  second later, exits at once.\n\
                  An interrupted render can be continued: `turner resume .PICTURE.turner-checkpoint`.\n\
                  Exit codes: 0 done, 1 bad scene or output, 2 bad usage. `turner help json` explains --json."
)]
pub(crate) struct RenderArgs {
    /// Picture file: .png, .exr, .jpg, .webp or .hdr, or `-` for standard output [default: SCENE.png in this folder]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Format of the picture, if the extension does not tell
    #[arg(long)]
    pub(crate) format: Option<FormatArg>,
    #[command(flatten)]
    pub(crate) encoding: EncodingArgs,
    #[command(flatten)]
    pub(crate) film: FilmArgs,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) sequence: SequenceArgs,
    #[command(flatten)]
    pub(crate) budget: BudgetArgs,
    #[command(flatten)]
    pub(crate) viewers: ViewerArgs,
    #[command(flatten)]
    pub(crate) checkpoints: CheckpointArgs,
    /// The options that a checkpoint records; `None` if one is not UTF-8.
    #[arg(skip)]
    pub(crate) recorded: Option<Vec<String>>,
    /// The scene file as it was given, if a checkpoint or a picture records it.
    #[arg(skip)]
    pub(crate) named: Option<String>,
    /// What the scene must be, to render a picture again.
    #[arg(skip)]
    pub(crate) expected: Option<Expected>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
    /// Treat warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
}

impl RenderArgs {
    /// The output file and the reporter.
    pub(crate) fn begin(&self) -> Result<(Output, Reporter), (Failure, Reporter)> {
        let mut reporter = self.run.reporter(Events::Stdout);
        let output = self.output().and_then(|output| {
            let refusal = checkpoint::refusal(self, &output);
            refusal.map_or(Ok(output), Err)
        });
        match output {
            Ok(output) => {
                if self.run.json && output.is_stdout() {
                    reporter.events = Some(Events::Stderr);
                }
                Ok((output, reporter))
            }
            Err(failure) => Err((failure, reporter)),
        }
    }

    /// The output file: a picture, or a checkpoint.
    fn output(&self) -> Result<Output, Failure> {
        match (&self.output, &self.checkpoints.checkpoint) {
            (Some(path), _) if checkpoint::has_extension(path) => Output::part(path),
            (None, Some(path)) if self.checkpoints.is_part() => Output::part(path),
            (None, None) if self.checkpoints.part.is_some() => {
                let file = self.checkpoints.part.map(|part| part.file(&self.scene.scene));
                Output::part(&file.unwrap_or_default())
            }
            (path, _) => {
                let frames = self.animation()?.map(|animation| animation.frames()).transpose()?;
                let path = frames.as_deref().or(path.as_deref());
                Output::new(path, self.format, &self.encoding, &self.scene.scene)
            }
        }
    }

    /// The animation that the pictures become.
    fn animation(&self) -> Result<Option<Animation>, Failure> {
        let path = self.output.as_deref().filter(|_| self.format.is_none() && !self.sequence.is_restricted());
        Animation::of(path, self.is_sequence(), self.scene.studio.rate())
    }

    /// The scene file.
    pub(crate) fn scene_path(&self) -> &Path {
        &self.scene.scene
    }

    /// Whether time or noise limits the samples instead of their number.
    pub(crate) fn is_open(&self) -> bool {
        self.budget.is_open(self.film.has_samples())
    }

    /// Whether several pictures are rendered.
    pub(crate) fn is_sequence(&self) -> bool {
        self.sequence.steps().len() > 1
    }
}

/// A checkpoint that a render continues, and its file.
pub(crate) struct Resumed {
    /// The file.
    pub(crate) path: PathBuf,
    /// Its contents.
    pub(crate) checkpoint: Checkpoint,
}

/// Runs the command.
pub(crate) fn run(args: &RenderArgs, control: &Control) -> u8 {
    let (result, reporter) = match args.begin() {
        Ok((output, reporter)) => {
            control.hear(&reporter);
            (render_all(args, &output, &reporter, control, None), reporter)
        }
        Err((failure, reporter)) => (Err(failure), reporter),
    };
    control.end();
    result.unwrap_or_else(|failure| {
        reporter.failure(&failure);
        failure.exit
    })
}

/// Renders one picture and adds the files of the scene to `watched`. Stops when one of them changes; the existing
/// picture is kept then.
pub(crate) fn again(
    args: &RenderArgs,
    output: &Output,
    reporter: &Reporter,
    control: &Control,
    watched: &mut Watched,
) -> Result<Option<u8>, Failure> {
    let studio = &args.scene.studio;
    let ready = load(args, studio.models(), output, (reporter, control), Some(&[]));
    match &ready {
        Ok(ready) => watched.add(&args.scene.scene, &ready.sources, Some(&ready.desc)),
        Err(failure) => watched.add(&args.scene.scene, &failure.sources, None),
    }
    let ready = ready?;
    let hashes = ready.hash.clone();
    let recipe = Recipe::new(args, &Step::Only);
    let changes = Changes::new(watched);
    let one = One {
        args,
        ready: &ready,
        hashes,
        recipe,
        step: None,
        output,
        reporter,
        control,
        changes: Some(&changes),
    };
    one.render(None)
}

/// Renders one picture, or several in order. `resumed` is the checkpoint of the only one.
pub(crate) fn render_all(
    args: &RenderArgs,
    output: &Output,
    reporter: &Reporter,
    control: &Control,
    mut resumed: Option<Resumed>,
) -> Result<u8, Failure> {
    let steps = args.sequence.steps();
    if steps.len() > 1 && output.is_stdout() {
        let error = SceneError::new(ErrorCode::Output, "cannot write several pictures to standard output");
        return Err(Failure::usage(error.help("name a file with `-o FILE`: the pictures are numbered")));
    }
    let studio = &args.scene.studio;
    let (mut ready, mut turntable): (Option<Ready>, _) = (None, None);
    for (i, step) in steps.iter().enumerate() {
        if control.is_interrupted() {
            return Ok(control.exit_code());
        }
        let output = if args.sequence.is_restricted() { output.clone() } else { output.numbered(step)? };
        let skips = |ready: &Ready| {
            let hashes = step.hashes(ready, studio);
            let recipe = Recipe::new(args, step);
            args.checkpoints.resume && is_finished(&output, ready, &hashes, &recipe, reporter)
        };
        if ready.as_ref().is_some_and(skips) {
            continue;
        }
        let models = match step {
            Step::Frame(frame) => studio.at_frame(*frame),
            _ => studio.models(),
        };
        // A turntable moves only the camera.
        let is_first = ready.is_none();
        if is_first || matches!(step, Step::Frame(_)) {
            drop(ready.take());
            let steps = (i == 0).then_some(steps.as_slice());
            ready = Some(load(args, models, &output, (reporter, control), steps)?);
        }
        if is_first && ready.as_ref().is_some_and(skips) {
            continue;
        }
        let Some(ready) = &mut ready else { continue };
        let turntable =
            turntable.get_or_insert_with(|| Turntable::new(&ready.desc, &ready.prepared, studio.orbit()));
        step.turn(&mut ready.prepared, ready.desc.integrator.integrator(), turntable)
            .map_err(|e| Failure::in_scene(e, &ready.sources, &ready.labels))?;
        let index = match (step, &resumed) {
            (_, Some(resumed)) => resumed.checkpoint.header.step,
            (Step::Only, None) => None,
            _ => Some(args.sequence.index(i as u32)),
        };
        let hashes = step.hashes(ready, studio);
        let recipe = Recipe::new(args, step);
        let one = One {
            args,
            ready,
            hashes,
            recipe,
            step: index,
            output: &output,
            reporter,
            control,
            changes: None,
        };
        let Some(code) = one.render(resumed.take())? else { continue };
        // While the next scene is loaded, nothing is there to save.
        control.end();
        if code != 0 || i + 1 == steps.len() {
            if code == 0 {
                assemble(args, &steps, reporter)?;
            }
            if reporter.events.is_none() && !ready.desc.imports.is_empty() {
                reporter.imports(&ready.desc.imports);
                reporter.warnings(&ready.prepared.warnings, &ready.sources, &ready.labels);
            }
            return Ok(code);
        }
    }
    // The last pictures were complete.
    assemble(args, &steps, reporter)?;
    Ok(0)
}

/// Makes an animation of the pictures, if they are frames of one.
fn assemble(args: &RenderArgs, steps: &[Step], reporter: &Reporter) -> Result<(), Failure> {
    args.animation()?.map_or(Ok(()), |animation| animation.assemble(steps, reporter))
}

/// Writes the picture of a film that holds samples of the scene of `args`.
pub(crate) fn develop(
    args: &RenderArgs,
    header: &Header,
    film: Film,
    output: &Output,
    control: &Control,
) -> Result<(), Failure> {
    let reporter = Reporter { quiet: true, events: None };
    let studio = &args.scene.studio;
    let step = args.sequence.steps().first().copied().unwrap_or(Step::Only);
    let models = match step {
        Step::Frame(frame) => studio.at_frame(frame),
        _ => studio.models(),
    };
    let mut ready = load(args, models, output, (&reporter, control), Some(&[]))?;
    let turntable = Turntable::new(&ready.desc, &ready.prepared, studio.orbit());
    step.turn(&mut ready.prepared, ready.desc.integrator.integrator(), &turntable)
        .map_err(|e| Failure::in_scene(e, &ready.sources, &ready.labels))?;
    let hashes = step.hashes(&ready, studio);
    let recipe = Recipe::new(args, &step);
    let one = One {
        args,
        ready: &ready,
        hashes,
        recipe,
        step: None,
        output,
        reporter: &reporter,
        control,
        changes: None,
    };
    one.develop(header, film)
}

/// The number of threads: as given, or with 0 the number of cores.
pub fn threads(asked: usize) -> usize {
    if asked > 0 { asked } else { std::thread::available_parallelism().map_or(1, usize::from) }
}
