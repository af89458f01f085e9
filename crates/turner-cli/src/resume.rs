//! `turner resume`: continues a render from its checkpoint.

use std::path::{Path, PathBuf};

use clap::Args;
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::checkpoint::Header;
use turner_io::image::ImageFormat;

use crate::checkpoint;
use crate::control::Control;
use crate::encoding::EncodingArgs;
use crate::events::Events;
use crate::failure::Failure;
use crate::limits::LimitArgs;
use crate::output::{FormatArg, Output};
use crate::render::{self, RenderArgs, Resumed};
use crate::report::Reporter;
use crate::run_args::RunArgs;

/// Continue an interrupted render from its checkpoint, or a finished one with more samples
///
/// The checkpoint records the scene, the options that the picture depends on, and the output file. Permissions and
/// limits are not recorded: give --allow-path, --allow-outside and --max-memory again. The finished picture has the
/// same bytes as that of a render without interruption.
#[derive(Debug, Args)]
pub(crate) struct ResumeArgs {
    /// Checkpoint: .PICTURE.turner-checkpoint beside the picture, or the file of --checkpoint
    #[arg(value_name = "CHECKPOINT")]
    file: PathBuf,
    /// Picture file, or `-` for standard output [default: that of the interrupted render]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Format of the picture, if the extension does not tell
    #[arg(long)]
    format: Option<FormatArg>,
    /// Samples per pixel of the finished picture: at least as many as before
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
    /// Write further checkpoints to this file, which stays when the picture is done [default: CHECKPOINT]
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Write the checkpoint every SECONDS [default: 30]
    #[arg(long, value_name = "SECONDS", value_parser = checkpoint::parse_seconds)]
    checkpoint_interval: Option<f64>,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    run: RunArgs,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

/// Runs the command.
pub(crate) fn run(args: &ResumeArgs, control: &Control) -> u8 {
    let to_stdout = args.output.as_deref() == Some(Path::new("-"));
    let stream = if to_stdout { Events::Stderr } else { Events::Stdout };
    let reporter = args.run.reporter(stream);
    control.hear(&reporter);
    let result = resume(args, &reporter, control);
    control.end();
    result.unwrap_or_else(|failure| {
        reporter.failure(&failure);
        failure.exit
    })
}

fn resume(args: &ResumeArgs, reporter: &Reporter, control: &Control) -> Result<u8, Failure> {
    let limits = args.limits.limits();
    control.watch_memory(&limits.memory);
    let checkpoint = checkpoint::read(&args.file, &limits)?;
    let header = &checkpoint.header;
    let mut render = render_args(header, &args.file)?;
    render.scene.limits = args.limits.with_textures_of(&render.scene.limits);
    (render.run.threads, render.strict) = (args.run.threads, args.strict);
    (render.output, render.format) = (args.output.clone(), args.format);
    render.checkpoints.checkpoint = args.checkpoint.clone();
    render.checkpoints.checkpoint_interval = args.checkpoint_interval;
    if let Some(samples) = args.samples {
        more_samples(&mut render, header, samples)?;
    }
    if let Some(step) = header.step {
        render.sequence.restrict(step);
    }
    let output = output(args, &render.encoding, header)?;
    if header.keep && args.checkpoint.is_none() && !output.is_part() {
        render.checkpoints.checkpoint = Some(args.file.clone());
    }
    if let Some(failure) = checkpoint::refusal(&render, &output) {
        return Err(failure);
    }
    let resumed = Resumed { path: args.file.clone(), checkpoint };
    render::render_all(&render, &output, reporter, control, Some(resumed))
}

/// The arguments of the render that a checkpoint records. Its scene is searched in the recorded folder, the current
/// one, and that of the checkpoint.
pub(crate) fn render_args(header: &Header, file: &Path) -> Result<RenderArgs, Failure> {
    let scene = Path::new(&header.scene);
    let folder = Path::new(&header.folder);
    let own = file.parent().unwrap_or(Path::new(""));
    let is_here = std::env::current_dir().is_ok_and(|here| here == folder);
    let places = [folder.join(scene), scene.to_owned(), own.join(scene)];
    let found = if is_here { Some(scene.to_owned()) } else { places.into_iter().find(|path| path.is_file()) };
    let Some(found) = found else {
        let message = format!("{}: its scene {} does not exist", file.display(), escape(&header.scene));
        let help =
            format!("run the command in the folder of the scene: it was in {}", escape(&header.folder));
        return Err(Failure::new(SceneError::new(ErrorCode::File, message).help(help)));
    };
    let mut render = crate::cli::render_args(&header.arguments, &found)?;
    render.named = Some(header.scene.clone());
    if let Some(environment) = render.scene.studio.environment.as_mut().filter(|path| !path.is_file()) {
        *environment = folder.join(&environment);
    }
    Ok(render)
}

/// Replaces the number of samples, also in what the next checkpoint records.
fn more_samples(render: &mut RenderArgs, header: &Header, samples: u32) -> Result<(), Failure> {
    if samples < header.samples {
        let message = format!(
            "the checkpoint is of a picture with {} samples per pixel; expected at least as many, found {samples}",
            header.samples
        );
        return Err(Failure::usage(SceneError::new(ErrorCode::OutOfRange, message)));
    }
    render.film.set_samples(samples);
    render.scene.set.retain(|o| o.path != "film.samples");
    // A part stays a part, unless it was the whole.
    (render.checkpoints.sample_range, render.checkpoints.part) = (None, None);
    if let Some(recorded) = &mut render.recorded {
        let replaced = ["--samples=", "--set=film.samples=", "--sample-range=", "--part="];
        recorded.retain(|word| !replaced.iter().any(|option| word.starts_with(option)));
        recorded.push(format!("--samples={samples}"));
    }
    Ok(())
}

/// The output file: as given, or as recorded. A file must not decide that any other file is overwritten, so the
/// recorded one must lie in the current folder or in that of the checkpoint.
fn output(args: &ResumeArgs, encoding: &EncodingArgs, header: &Header) -> Result<Output, Failure> {
    let scene = Path::new(&header.scene);
    if let Some(path) = &args.output {
        return match checkpoint::has_extension(path) {
            true => Output::part(path),
            false => Output::new(Some(path), args.format, encoding, scene),
        };
    }
    let Some(recorded) = &header.output else { return Output::part(&args.file) };
    let path = Path::new(&header.folder).join(&recorded.path);
    let folder_of = |path: &Path| {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize().ok()
    };
    let target = folder_of(&path);
    let mut allowed = [std::env::current_dir().ok(), folder_of(&args.file)].into_iter().flatten();
    let is_near = target.as_ref().is_some_and(|target| allowed.any(|folder| target.starts_with(folder)));
    let has_format = ImageFormat::of_path(&path).is_ok_and(|f| f.extensions()[0] == recorded.format);
    if !is_near || !has_format && args.format.is_none() {
        let message =
            format!("{}: records the output {}", args.file.display(), escape(&path.to_string_lossy()));
        let help = "it does not lie in this folder or in that of the checkpoint, or has an unusual extension: name the picture with `-o FILE`";
        return Err(Failure::new(SceneError::new(ErrorCode::Output, message).help(help)));
    }
    // As short as it was given, where that is the same file.
    let short = Path::new(&recorded.path);
    let same = folder_of(short).is_some_and(|folder| Some(folder) == target);
    Output::new(Some(if same { short } else { &path }), args.format, encoding, scene)
}
