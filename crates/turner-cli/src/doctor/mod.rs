//! `turner doctor`: finds out why a picture is black, noisy, washed out or slow.
//!
//! ```text
//! run ── scene ── turner::doctor::examine ─┬─ text
//!                                          ├─ json
//!                                          └─ maps (turner::doctor::maps ── PNG)
//! ```

mod json;
mod maps;
mod text;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde_json::Value;
use turner::doctor::{Examination, Options, examine};
use turner_io::scene::Sources;

use crate::control::Control;
use crate::events::Events;
use crate::failure::{FAILED, Failure};
use crate::report::Reporter;
use crate::scene::{FilmArgs, SceneArgs};
use crate::text::print;

/// Find out why a picture is black, noisy, washed out or slow, and what to do
#[derive(Debug, Args)]
#[command(
    after_help = "Traces a few thousand samples and examines them; no picture is rendered. Give the same options as for the render.\n\
                  Each finding says what is wrong, where, why it has this effect, and how to fix it, with the option that does so. Its code stays the same from version to version."
)]
pub(crate) struct DoctorArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    film: FilmArgs,
    /// As JSON
    #[arg(long)]
    json: bool,
    /// Write maps of cost, variance and kind of path: to a folder, or side by side to one PNG
    #[arg(short, long, value_name = "DIR|FILE.png")]
    output: Option<PathBuf>,
    /// Exit with code 1 if any finding is an error
    #[arg(long)]
    strict: bool,
    /// Show notes, too
    #[arg(long)]
    all: bool,
    /// Stop probing after this many seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = parse_seconds)]
    seconds: f64,
    /// Threads; 0 uses all of them. The findings do not depend on it
    #[arg(long, default_value_t = 0)]
    threads: usize,
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 && v <= 86_400.0 => Ok(v),
        _ => Err("expected seconds, more than 0 and at most 86400".to_owned()),
    }
}

/// An examination as JSON, as `turner doctor --json` prints it: docs/reference/doctor.md. Without the keys `scene`,
/// `scene_hash`, `maps` and `seconds`.
pub fn json_of(examination: &Examination, sources: &Sources) -> Value {
    json::examination(examination, sources)
}

/// Runs the command.
pub(crate) fn run(args: &DoctorArgs, control: &Control) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    control.hear(&reporter);
    doctor(args, control).unwrap_or_else(|failure| {
        reporter.failure(&failure);
        failure.exit
    })
}

fn doctor(args: &DoctorArgs, control: &Control) -> Result<u8, Failure> {
    let target = args.output.as_deref().map(maps::Target::new).transpose()?;
    let ready = args.scene.ready(&args.film, args.scene.studio.models(), args.threads, control)?;
    ready.prepared.choose(args.threads);
    if let Some(target) = &target {
        target.check_against(&args.scene.scene, &ready.desc)?;
    }
    let start = Instant::now();
    let stop = || start.elapsed().as_secs_f64() > args.seconds;
    let options = Options { threads: args.threads, stop: &stop, ..Options::default() };
    let examination = examine(&ready.prepared, &ready.desc, &options);
    let seconds = start.elapsed().as_secs_f64();
    let written = match &target {
        Some(target) => target.write(&turner::doctor::maps::maps(&ready.prepared, &ready.desc, &options))?,
        None => Vec::new(),
    };
    let report = Report { examination: &examination, written: &written, ready: &ready, seconds };
    if args.json {
        print(&format!("{}\n", json::of(&report, &args.scene.scene.to_string_lossy())));
    } else {
        print(&text::of(&report, args.all));
    }
    Ok(if args.strict && examination.has_errors() { FAILED } else { 0 })
}

/// The examination and further data for the output.
struct Report<'a> {
    examination: &'a turner::doctor::Examination,
    written: &'a [maps::Written],
    ready: &'a crate::scene::Ready,
    /// Seconds that the examination took.
    seconds: f64,
}
