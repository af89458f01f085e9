//! `turner merge`: puts parts of a picture together.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use turner::film::{Film, PixelRect};
use turner::schema::{ErrorCode, Limits, SceneError};
use turner_io::checkpoint::{Header, to_bytes, write};

use crate::checkpoint;
use crate::control::Control;
use crate::encoding::EncodingArgs;
use crate::events::Events;
use crate::failure::{Failure, two_lines};
use crate::limits::LimitArgs;
use crate::output::{FormatArg, Output};
use crate::recipe;
use crate::render::RenderArgs;
use crate::report::Reporter;
use crate::resume;
use crate::run_args::RunArgs;
use crate::text;

/// Merge checkpoints of parts of a picture: sample ranges and crops
///
/// The parts come from renders of the same scene with the same options, except --part, --sample-range and --crop, on any
/// machine. Parts of one crop must hold different samples; crops must cover a rectangle without overlap. The result
/// has the same bytes as a single render. For a picture the scene must be there; for a checkpoint it is not needed.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Checkpoints of the parts
    #[arg(value_name = "CHECKPOINT", required = true)]
    files: Vec<PathBuf>,
    /// Picture, by its extension, or checkpoint: .turner-checkpoint
    #[arg(short, long, value_name = "FILE", required = true)]
    output: PathBuf,
    /// Format of the picture, if the extension does not tell
    #[arg(long)]
    format: Option<FormatArg>,
    #[command(flatten)]
    encoding: EncodingArgs,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Runs the command.
pub(crate) fn run(args: &MergeArgs, control: &Control) -> u8 {
    let to_stdout = args.output == Path::new("-");
    let stream = if to_stdout { Events::Stderr } else { Events::Stdout };
    let reporter = args.run.reporter(stream);
    control.hear(&reporter);
    match merge(args, &reporter, control) {
        Ok(()) => 0,
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

/// The films of one crop, merged.
struct Part {
    film: Film,
    file: PathBuf,
}

fn merge(args: &MergeArgs, reporter: &Reporter, control: &Control) -> Result<(), Failure> {
    let limits = args.limits.limits();
    control.watch_memory(&limits.memory);
    let output = match checkpoint::has_extension(&args.output) {
        true => Output::part(&args.output)?,
        false => Output::new(Some(&args.output), args.format, &args.encoding, Path::new(""))?,
    };
    let (film, mut header) = film(&args.files, &limits)?;
    let crop = film.crop;
    let is_whole = [crop.width, crop.height] == header.size;
    header.crop = [crop.x, crop.y, crop.width, crop.height];
    header.held = film.samples() as f64 / (film.region.area() as f64).max(1.0);
    header
        .arguments
        .retain(|word| !["--crop=", "--sample-range=", "--part="].iter().any(|o| word.starts_with(o)));
    if !is_whole {
        let [x, y, width, height] = header.crop;
        header.arguments.push(format!("--crop={x},{y},{width},{height}"));
    }
    let held = film.finished(&(0..header.samples));
    if output.is_part() {
        (header.keep, header.output) = (true, None);
        let bytes = to_bytes(&header, &film).map_err(Failure::new)?;
        write(&args.output, &bytes)
            .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
    } else {
        // The parts say nothing about the file of the whole.
        header.arguments.retain(|word| !recipe::ENCODING.contains(&recipe::option(word)));
        header.arguments.extend(args.encoding.words());
        picture(args, &header, film, &output, control)?;
    }
    say(args, &header, crop, held, &output, reporter);
    Ok(())
}

/// The film of all files, and the header of the first.
fn film(files: &[PathBuf], limits: &Limits) -> Result<(Film, Header), Failure> {
    let mut first: Option<(Header, &Path)> = None;
    let mut parts: Vec<Part> = Vec::new();
    let mut seconds = 0.0;
    for file in files {
        let read = checkpoint::read(file, limits)?;
        seconds += read.header.seconds;
        match &first {
            None => first = Some((read.header, file)),
            Some((header, other)) => same_scene((header, other), (&read.header, file))?,
        }
        match parts.iter_mut().find(|part| part.film.crop == read.film.crop) {
            None => parts.push(Part { film: read.film, file: file.clone() }),
            Some(part) => part.film.merge(&read.film).map_err(|mut error| {
                error.message = format!("{} and {}: {}", part.file.display(), file.display(), error.message);
                Failure::new(error)
            })?,
        }
    }
    let Some((mut header, _)) = first else {
        return Err(Failure::usage(SceneError::new(ErrorCode::Usage, "there are no checkpoints to merge")));
    };
    header.seconds = seconds;
    if let [_] = parts.as_slice()
        && let Some(part) = parts.pop()
    {
        return Ok((part.film, header));
    }
    let films: Vec<Film> = parts.into_iter().map(|part| part.film).collect();
    let bytes: u64 = films.iter().map(|film| film.memory() as u64).sum();
    limits.memory.need(bytes, || "the merged film".to_owned()).map_err(Failure::new)?;
    Ok((Film::stitch(&films).map_err(Failure::new)?, header))
}

fn same_scene(a: (&Header, &Path), b: (&Header, &Path)) -> Result<(), Failure> {
    if a.0.scene_hash == b.0.scene_hash && a.0.step == b.0.step {
        return Ok(());
    }
    let message = format!(
        "{} and {}: the scenes, or options other than --sample-range, --part, --crop and --samples, differ",
        a.1.display(),
        b.1.display()
    );
    let help =
        "render all parts from the same files with the same options; `head FILE` shows those of a checkpoint";
    Err(Failure::new(SceneError::new(ErrorCode::Conflict, message).help(help)))
}

/// Develops the film as its scene says, and writes the picture.
fn picture(
    args: &MergeArgs,
    header: &Header,
    film: Film,
    output: &Output,
    control: &Control,
) -> Result<(), Failure> {
    let file = args.files.first().map_or(Path::new(""), PathBuf::as_path);
    let mut render: RenderArgs = resume::render_args(header, file)?;
    render.scene.limits = args.limits.with_textures_of(&render.scene.limits);
    render.run.threads = args.run.threads;
    if let Some(step) = header.step {
        render.sequence.restrict(step);
    }
    crate::render::develop(&render, header, film, output, control)
}

fn say(args: &MergeArgs, header: &Header, crop: PixelRect, held: f64, output: &Output, reporter: &Reporter) {
    let n = text::plural(args.files.len() as u64, "file");
    if let Some(events) = reporter.events {
        events.send(json!({
            "event": "merged",
            "output": output.name(),
            "width": crop.width,
            "height": crop.height,
            "files": args.files.len(),
            "samples_per_pixel": header.samples,
            "finished": held,
        }));
    } else {
        let rest = if held < 1.0 {
            format!("; {:.1} % of the {} samples per pixel", (held * 1000.0).floor() / 10.0, header.samples)
        } else {
            format!(", {}", text::plural(u64::from(header.samples), "sample") + " per pixel")
        };
        reporter.line(&format!("{}: {}x{} from {n}{rest}", output.name(), crop.width, crop.height));
    }
}
