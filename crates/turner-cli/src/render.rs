//! `turner render`: renders a scene and writes the picture.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use clap::Args;
use serde_json::json;
use turner::film::{Antialias, Film};
use turner::render::{PassOptions, Renderer};
use turner::schema::{ErrorCode, SceneError, Warning, WarningKind};
use turner_io::scene::ModelOverrides;

use crate::control::Control;
use crate::events::Events;
use crate::failure::Failure;
use crate::output::{FormatArg, Output};
use crate::progress::Progress;
use crate::report::{Reporter, strict};
use crate::scene::{FilmArgs, Ready, SceneArgs};
use crate::sequence::{SequenceArgs, Step, Turntable};
use crate::text;
use crate::watch::{Changes, Watched};

/// Render a scene (the command `render` may be omitted)
#[derive(Debug, Args)]
#[command(
    after_help = "Ctrl-C saves what is rendered and exits with code 130 (SIGTERM: 143); a second Ctrl-C exits at once.\n\
                  Exit codes: 0 done, 1 bad scene or output, 2 bad usage. `turner help json` explains --json."
)]
pub(crate) struct RenderArgs {
    /// Picture file: .png, .exr, .jpg or .hdr, or `-` for standard output [default: SCENE.png in this folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Format of the picture, if the extension does not tell
    #[arg(long)]
    format: Option<FormatArg>,
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    sequence: SequenceArgs,
    /// Number of threads [default: all cores]; the picture does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Print errors only
    #[arg(long)]
    quiet: bool,
    /// Print events as JSON lines: `turner help json`
    #[arg(long)]
    json: bool,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

/// Samples per pixel of the next pass. Early passes are short, so that an interrupted picture covers all pixels. Later
/// ones are longer, because each pass starts its threads again.
fn pass_samples(done: u32) -> u32 {
    (done / 8).clamp(16, 256)
}

impl RenderArgs {
    /// The output file and the reporter.
    pub(crate) fn begin(&self) -> Result<(Output, Reporter), (Failure, Reporter)> {
        let mut reporter = Reporter { quiet: self.quiet, events: self.json.then_some(Events::Stdout) };
        match Output::new(self.output.as_deref(), self.format, &self.scene.scene) {
            Ok(output) => {
                if self.json && output.is_stdout() {
                    reporter.events = Some(Events::Stderr);
                }
                Ok((output, reporter))
            }
            Err(failure) => Err((failure, reporter)),
        }
    }

    /// The scene file.
    pub(crate) fn scene_path(&self) -> &Path {
        &self.scene.scene
    }

    /// Whether several pictures are rendered.
    pub(crate) fn is_sequence(&self) -> bool {
        self.sequence.steps().len() > 1
    }
}

/// Runs the command.
pub(crate) fn run(args: &RenderArgs, control: &Control) -> u8 {
    let (result, reporter) = match args.begin() {
        Ok((output, reporter)) => {
            control.hear(&reporter);
            (render_all(args, &output, &reporter, control), reporter)
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
    render(args, &ready?, output, reporter, control, Some(&Changes::new(watched)))
}

/// Renders one picture, or several in order.
fn render_all(
    args: &RenderArgs,
    output: &Output,
    reporter: &Reporter,
    control: &Control,
) -> Result<u8, Failure> {
    let steps = args.sequence.steps();
    if steps.len() > 1 && output.is_stdout() {
        let error = SceneError::new(ErrorCode::Output, "cannot write several pictures to standard output");
        return Err(Failure::usage(error.help("name a file with `-o FILE`: the pictures are numbered")));
    }
    let studio = &args.scene.studio;
    let (mut ready, mut turntable) = (None, None);
    for (i, step) in steps.iter().enumerate() {
        let models = match step {
            Step::Frame(frame) => studio.at_frame(*frame),
            _ => studio.models(),
        };
        // A turntable moves only the camera.
        if ready.is_none() || matches!(step, Step::Frame(_)) {
            drop(ready.take());
            let steps = (i == 0).then_some(steps.as_slice());
            ready = Some(load(args, models, output, (reporter, control), steps)?);
        }
        let Some(ready) = &mut ready else { continue };
        let turntable =
            turntable.get_or_insert_with(|| Turntable::new(&ready.desc, &ready.prepared, studio.orbit()));
        step.turn(&mut ready.prepared, ready.desc.integrator.integrator(), turntable)
            .map_err(|e| Failure::in_scene(e, &ready.sources, &ready.labels))?;
        let output = output.numbered(step)?;
        let Some(code) = render(args, ready, &output, reporter, control, None)? else { continue };
        if code != 0 || i + 1 == steps.len() {
            if reporter.events.is_none() && !ready.desc.imports.is_empty() {
                reporter.imports(&ready.desc.imports);
                reporter.warnings(&ready.prepared.warnings, &ready.sources, &ready.labels);
            }
            return Ok(code);
        }
    }
    Ok(0)
}

/// Loads and prepares the scene. `first` holds the steps of the sequence for its first picture: only then are warnings
/// reported.
fn load(
    args: &RenderArgs,
    models: ModelOverrides,
    output: &Output,
    (reporter, control): (&Reporter, &Control),
    first: Option<&[Step]>,
) -> Result<Ready, Failure> {
    let mut ready = args.scene.ready(&args.film, models, args.threads, control)?;
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
        let other = args.scene.described(&args.film, models, args.threads, None, &limits)?;
        if other.desc.same_scene(&ready.desc).is_err() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Renders and writes a picture. Returns the exit code, or `None` if it stopped because a file changed.
fn render(
    args: &RenderArgs,
    ready: &Ready,
    output: &Output,
    reporter: &Reporter,
    control: &Control,
    changes: Option<&Changes<'_>>,
) -> Result<Option<u8>, Failure> {
    let Ready { desc, prepared, sources, labels, hash, seconds: load_seconds } = ready;
    let renderer = Renderer::new(prepared.clone()).map_err(|e| Failure::in_scene(e, sources, labels))?;
    let samples_per_pixel = renderer.samples_per_pixel();
    let crop = &renderer.film.crop;
    output.check_space(crop.width, crop.height)?;
    if let Some(events) = reporter.events {
        events.send(json!({
            "event": "start",
            "scene": args.scene.scene.to_string_lossy(),
            "output": output.name(),
            "width": renderer.film.crop.width,
            "height": renderer.film.crop.height,
            "samples_per_pixel": samples_per_pixel,
            "threads": threads(args.threads),
        }));
    }
    let traced = trace(renderer, args.threads, reporter, control, changes);
    if traced.interrupted && !control.is_interrupted() {
        reporter.line("a file of the scene changed: rendering again");
        return Ok(None);
    }

    control.begin_saving();
    let start = Instant::now();
    let written = traced.finished > 0.0;
    if written {
        let picture = traced.renderer.develop();
        let metadata = output.metadata(prepared, &desc.integrator, hash, samples_per_pixel, picture.exposure);
        output.write(&picture, &prepared.view, &metadata, args.threads)?;
    }
    let save_seconds = start.elapsed().as_secs_f64();
    let late = late_warnings(&traced, &desc.integrator);
    if !args.strict {
        reporter.warnings(&late, sources, labels);
    }
    let report = Report { traced: &traced, written, load_seconds: *load_seconds, save_seconds, hash };
    report.send(output, reporter);
    if let Some(error) = control.starved() {
        return Err(Failure::new(error));
    }
    match traced.fault {
        Some(fault) => Err(Failure::new(fault)),
        None if traced.interrupted => Ok(Some(control.exit_code())),
        None if args.strict && !late.is_empty() => Err(strict(&late, sources, labels)),
        None => Ok(Some(0)),
    }
}

/// The number of threads: as given, or with 0 the number of cores.
pub fn threads(asked: usize) -> usize {
    if asked > 0 { asked } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

/// The result of tracing.
struct Traced {
    renderer: Renderer,
    seconds: f64,
    /// Fraction of the work that is done.
    finished: f64,
    interrupted: bool,
    fault: Option<SceneError>,
}

/// Renders pass after pass until the picture is complete, the user interrupts, or a worker fails.
fn trace(
    mut renderer: Renderer,
    threads: usize,
    reporter: &Reporter,
    control: &Control,
    changes: Option<&Changes<'_>>,
) -> Traced {
    let total = renderer.samples_per_pixel();
    let progress = Progress::new(reporter, total);
    let start = Instant::now();
    control.begin_rendering();
    let mut fault = None;
    let mut left = total;
    let changed = AtomicBool::new(false);
    let fault_after = fault_after();
    let cancel = if changes.is_some() { &changed } else { &control.cancel };
    while !renderer.is_complete() && !control.is_interrupted() && !is_set(&changed) && fault.is_none() {
        let samples = left.min(pass_samples(total - left));
        left -= samples;
        progress.begin_pass(samples);
        let tile = |done, tiles| {
            progress.tile(done, tiles);
            assert!(Some(done) != fault_after, "injected by {FAULT_AFTER}");
            if changes.is_some_and(|c| control.is_interrupted() || c.any()) {
                changed.store(true, Ordering::SeqCst);
            }
        };
        let options = PassOptions { threads, cancel, progress: Some(&tile) };
        fault = renderer.pass(samples, &options).err();
    }
    let seconds = start.elapsed().as_secs_f64();
    let finished = progress.finish();
    let interrupted = !renderer.is_complete() && fault.is_none();
    Traced { renderer, seconds, finished, interrupted, fault }
}

/// For tests: environment variable with the number of tiles, or batches of light paths, of a pass after which a worker
/// panics.
const FAULT_AFTER: &str = "TURNER_FAULT_AFTER";

fn fault_after() -> Option<usize> {
    std::env::var(FAULT_AFTER).ok()?.parse().ok()
}

fn is_set(flag: &AtomicBool) -> bool {
    flag.load(Ordering::SeqCst)
}

/// Warnings that are known only after rendering.
fn late_warnings(traced: &Traced, integrator: &turner::integrator::IntegratorDesc) -> Vec<Warning> {
    let mut out = Vec::new();
    let mut warn = |message: String| out.push(Warning::new(WarningKind::Ignored, message));
    let bad = traced.renderer.film.non_finite;
    if let Some((y, x, sample)) = bad.first {
        let n = text::plural(bad.count, "non-finite sample");
        warn(format!(
            "{n} (NaN or infinite) omitted; the first is sample {sample} of the pixel in column {x}, row {y}"
        ));
    }
    let dropped = traced.renderer.stats.dropped;
    if dropped > 0 {
        let n = text::plural(dropped, "sample");
        let remedy = match integrator {
            turner::integrator::IntegratorDesc::Classic(_) => {
                ": raise `integrator.max_rays` or lower `max_depth`"
            }
            _ => "",
        };
        warn(format!("the ray tree was truncated in {n}{remedy}"));
    }
    out
}

/// The closing line or event.
struct Report<'a> {
    traced: &'a Traced,
    written: bool,
    load_seconds: f64,
    save_seconds: f64,
    hash: &'a str,
}

impl Report<'_> {
    fn send(&self, output: &Output, reporter: &Reporter) {
        match reporter.events {
            Some(events) => events.send(self.event(output)),
            None => reporter.line(&self.line(output)),
        }
    }

    fn rays_per_second(&self) -> f64 {
        self.traced.renderer.stats.total() as f64 / self.traced.seconds.max(1e-9)
    }

    fn event(&self, output: &Output) -> serde_json::Value {
        let Traced { renderer, seconds, finished, interrupted, fault } = self.traced;
        let Renderer { film: Film { crop, non_finite, .. }, stats, .. } = renderer;
        json!({
            "event": "done",
            "output": self.written.then(|| output.name()),
            "width": crop.width,
            "height": crop.height,
            "complete": !interrupted && fault.is_none(),
            "finished": finished,
            "seconds": { "load": self.load_seconds, "render": seconds, "save": self.save_seconds },
            "rays": {
                "camera": stats.camera,
                "shadow": stats.shadow,
                "reflected": stats.reflected,
                "refracted": stats.refracted,
                "light": stats.light,
                "total": stats.total(),
            },
            "rays_per_second": self.rays_per_second(),
            "samples": renderer.film.samples(),
            "non_finite": {
                "count": non_finite.count,
                "first": non_finite.first.map(|(y, x, sample)| json!({ "x": x, "y": y, "sample": sample })),
            },
            "scene_hash": self.hash,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// `scene.png: 640x480, 64 samples per pixel, 12.3 s`.
    fn line(&self, output: &Output) -> String {
        let Traced { renderer, seconds, finished, interrupted, fault } = self.traced;
        let film = &renderer.film;
        let name = if output.is_stdout() { "standard output".to_owned() } else { output.name() };
        let mut line = format!("{name}: {}x{}, ", film.crop.width, film.crop.height);
        if *interrupted || fault.is_some() {
            // Rounded down: an unfinished picture is never at 100 %.
            let percent = (finished * 100.0).floor();
            let why = if *interrupted { "interrupted" } else { "stopped by an error" };
            let kept = if self.written { "" } else { ", nothing written" };
            line += &format!("{why} at {percent} %{kept}, ");
        }
        let pixels = f64::from(film.crop.width) * f64::from(film.crop.height);
        let mean = film.samples() as f64 / pixels.max(1.0);
        let samples = if mean.fract() == 0.0 { format!("{mean}") } else { format!("{mean:.1}") };
        let plural = if samples == "1" { "" } else { "s" };
        line += &format!("{samples} sample{plural} per pixel, {}", text::seconds(*seconds));
        if film.non_finite.count > 0 {
            line += &format!(", {}", text::plural(film.non_finite.count, "non-finite sample"));
        }
        line
    }
}
