//! `turner remake`: renders a picture again from what its header says, and compares the two.
//!
//! ```text
//! FILE ── source ──> scene, options, settings ── render ──> OUT or a temporary file
//!   └────────────────────────── same ──────────────────────┘
//! ```

mod same;
mod source;

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::ImageFormat;

use crate::control::Control;
use crate::events::Events;
use crate::failure::{FAILED, Failure, two_lines};
use crate::limits::LimitArgs;
use crate::output::Output;
use crate::picture_file::PictureFile;
use crate::render::{self, RenderArgs};
use crate::report::Reporter;
use crate::run_args::RunArgs;
use crate::text::plural;
use same::Sameness;
use source::Source;

/// Render a picture again from its header, and say whether it is the same
///
/// Turner's PNG and EXR files hold the name of the scene, its hash, and the options of the render. The scene is searched
/// in the current folder, then in that of the picture. Permissions and limits are not recorded: give --allow-path,
/// --allow-outside and --max-memory again.
#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 the same bytes, or the same pixels with other metadata; 1 different, or an error; 2 bad usage."
)]
pub(crate) struct RemakeArgs {
    /// Picture to render again: .png or .exr
    #[arg(value_name = "PICTURE")]
    file: PathBuf,
    /// Keep the new picture in this file [default: a temporary file, which is removed]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Scene file [default: as the picture says, in this folder or in that of the picture]
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Render even if the scene or the version of Turner has changed
    #[arg(long)]
    anyway: bool,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Runs the command.
pub(crate) fn run(args: &RemakeArgs, control: &Control) -> u8 {
    let reporter = args.run.reporter(Events::Stdout);
    control.hear(&reporter);
    let result = remake(args, &reporter, control);
    control.end();
    result.unwrap_or_else(|failure| {
        reporter.failure(&failure);
        failure.exit
    })
}

fn remake(args: &RemakeArgs, reporter: &Reporter, control: &Control) -> Result<u8, Failure> {
    control.watch_memory(&args.limits.limits().memory);
    let old = PictureFile::read(&args.file)?;
    let source = Source::read(&old)?;
    if !args.anyway {
        source.check_version(&old.name)?;
    }
    let mut render = source.render_args(&args.file, args.scene.as_deref())?;
    render.scene.limits = args.limits.with_textures_of(&render.scene.limits);
    render.run.threads = args.run.threads;
    if !args.anyway {
        render.expected = Some(source.expected(&old.name));
    }
    // Removed when it goes out of scope.
    let folder = tempfile::tempdir().map_err(|e| output_failed(&e.to_string()))?;
    let (path, output) = target(args, &old, &render, folder.path())?;
    let code = render::render_all(&render, &output, reporter, control, None).map_err(|mut failure| {
        // The options are those of the file, not of the user.
        failure.exit = FAILED;
        failure
    })?;
    if code != 0 {
        return Ok(code);
    }
    let new = PictureFile::read(&path)?;
    let found = same::compare(&old, &new)?;
    say(args, &old, &found, reporter);
    Ok(if found.is_same() { 0 } else { FAILED })
}

fn output_failed(message: &str) -> Failure {
    Failure::new(two_lines(ErrorCode::Output, message))
}

/// The new picture: its path, checked. The header does not decide where it goes.
fn target(
    args: &RemakeArgs,
    old: &PictureFile,
    render: &RenderArgs,
    folder: &Path,
) -> Result<(PathBuf, Output), Failure> {
    let scene = &render.scene.scene;
    let extension = old.format.extensions()[0];
    let Some(path) = &args.output else {
        let path = folder.join(format!("remade.{extension}"));
        let output = Output::new(Some(&path), None, &render.encoding, scene)?;
        return Ok((path, output.temporary()));
    };
    let usage = |message: String, help: String| {
        Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)))
    };
    let name = escape(&path.to_string_lossy());
    if !ImageFormat::of_path(path).is_ok_and(|format| format == old.format) {
        let message = format!("{name}: {} is {}", escape(&old.name), old.format.name());
        return usage(message, format!("name a file with the extension .{extension}, to compare the two"));
    }
    if path.canonicalize().is_ok_and(|own| args.file.canonicalize().is_ok_and(|file| file == own)) {
        return usage(format!("{name}: is the picture to render again"), "name another file".to_owned());
    }
    Ok((path.clone(), Output::new(Some(path), None, &render.encoding, scene)?))
}

/// The closing line or event.
fn say(args: &RemakeArgs, old: &PictureFile, found: &Sameness, reporter: &Reporter) {
    if let Some(events) = reporter.events {
        let different = match found {
            Sameness::Pixels { .. } | Sameness::Bytes => json!(0),
            Sameness::Different { pixels, .. } => json!(pixels),
            Sameness::OtherSize(_) => json!(null),
        };
        let metadata = if let Sameness::Pixels { metadata } = found { metadata.clone() } else { Vec::new() };
        events.send(json!({
            "event": "remade",
            "picture": old.name,
            "output": args.output.as_ref().map(|path| path.to_string_lossy()),
            "same_bytes": matches!(found, Sameness::Bytes),
            "same_pixels": found.is_same(),
            "different_pixels": different,
            "different_metadata": metadata,
        }));
        return;
    }
    let name = escape(&old.name);
    reporter.line(&match found {
        Sameness::Bytes => format!("{name}: the same bytes"),
        Sameness::Pixels { metadata } if metadata.is_empty() => {
            format!("{name}: the same pixels and metadata, in other bytes")
        }
        Sameness::Pixels { metadata } => {
            let names: Vec<String> = metadata.iter().map(|key| escape(key)).collect();
            format!("{name}: the same pixels; other metadata: {}", names.join(", "))
        }
        Sameness::Different { pixels, total, first: (x, y) } => {
            let different = plural(*pixels, "pixel");
            format!("{name}: different: {different} of {total}, the first in column {x}, row {y}")
        }
        Sameness::OtherSize(what) => format!("{name}: different: {what}"),
    });
}
