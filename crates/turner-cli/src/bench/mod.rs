//! `turner bench`: render speed of scenes on this machine. `antialias` measures the anti-aliasing modes, `clock`
//! whether renders keep their time, `edits` the preparation after edits, `studio` the interactive renderer.

pub mod antialias;
mod clock;
mod edits;
mod studio;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::{Args, Subcommand};
use serde_json::json;
use turner::film::FilmDesc;
use turner::integrator::Prepared;
use turner::render::{PassOptions, Renderer};
use turner::schema::error::{escape, suggestion};
use turner::schema::{ErrorCode, PrepareOptions, SceneError};
use turner_io::scene::{LoadOptions, load};

use crate::events::Events;
use crate::failure::{Failure, Labels, USAGE};
use crate::instructions::instruction_set;
use crate::report::Reporter;
use crate::text;

/// Measure the render speed of the scenes in a folder
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true,
    subcommand_help_heading = "Other measurements",
    after_help = "Seconds are the median over the repetitions of the render time, without loading and saving."
)]
pub(crate) struct BenchArgs {
    #[command(subcommand)]
    other: Option<OtherBench>,
    #[command(flatten)]
    scenes: ScenesArgs,
}

/// Which scenes to measure, and how.
#[derive(Debug, Args)]
pub struct ScenesArgs {
    /// Scene names without .toml [default: all scenes in the folder]
    names: Vec<String>,
    /// Folder with the scenes
    #[arg(long, default_value = "scenes/bench")]
    dir: PathBuf,
    /// Numbers of threads to measure; 0 means all cores
    #[arg(long, value_delimiter = ',', default_value = "0")]
    threads: Vec<usize>,
    /// How often each scene is rendered
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repeat: u32,
    /// Print one JSON object per line
    #[arg(long)]
    json: bool,
}

/// Other measurements.
#[derive(Debug, Subcommand)]
enum OtherBench {
    Antialias(antialias::AntialiasBenchArgs),
    Clock(clock::ClockBenchArgs),
    Edits(edits::EditsBenchArgs),
    Studio(studio::StudioBenchArgs),
}

/// Runs the command.
pub(crate) fn run(args: &BenchArgs) -> u8 {
    match &args.other {
        Some(OtherBench::Antialias(args)) => antialias::run(args),
        Some(OtherBench::Clock(args)) => clock::run(args),
        Some(OtherBench::Edits(args)) => edits::run(args),
        Some(OtherBench::Studio(args)) => studio::run(args),
        None => reported(args.scenes.json, measure_scenes(&args.scenes, None)),
    }
}

/// The exit code; prints the error of a failed measurement.
pub fn reported(json: bool, result: Result<(), Failure>) -> u8 {
    let Err(failure) = result else { return 0 };
    Reporter { quiet: false, events: json.then_some(Events::Stdout) }.failure(&failure);
    failure.exit
}

impl ScenesArgs {
    /// Whether JSON is written instead of text.
    pub fn json(&self) -> bool {
        self.json
    }
}

/// Another renderer, measured alternately with Turner.
pub trait Rival {
    /// Its name in tables.
    fn name(&self) -> &'static str;
    /// Prefix of its keys in JSON.
    fn key(&self) -> &'static str;
    /// Render time of the scene in this file, seconds; `None` if the renderer has no such scene.
    fn trace(&self, path: &Path, film: &FilmDesc, threads: usize) -> Result<Option<f64>, Failure>;
}

/// Measures the scenes and prints the times. Runs alternate with those of the rival, if there is one.
pub fn measure_scenes(args: &ScenesArgs, rival: Option<&dyn Rival>) -> Result<(), Failure> {
    let scenes = find(args)?;
    let width = scenes.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max(5);
    if !args.json {
        let rival = rival.map_or(String::new(), |r| format!("  {:>11}   ratio", r.name()));
        text::print(&format!("{:width$}  threads      median         rays     rays/s{rival}\n", "scene"));
    }
    for (name, path) in &scenes {
        let scene = prepare(path)?;
        for &threads in &args.threads {
            let threads = crate::render::threads(threads);
            let row = measure(args, (name, path), &scene, threads, rival)?;
            text::print(&if args.json { format!("{}\n", row.json(rival)) } else { row.text(width) });
        }
    }
    Ok(())
}

/// The scenes by name; an error if there are none.
fn find(args: &ScenesArgs) -> Result<Vec<(String, PathBuf)>, Failure> {
    let folder = args.dir.display().to_string();
    let missing = |message: String, help: String| Failure {
        exit: USAGE,
        ..Failure::new(SceneError::new(ErrorCode::File, message).help(help))
    };
    let entries = std::fs::read_dir(&args.dir).map_err(|e| {
        let help = "run it in the root folder of Turner's sources, or name a folder with scenes: `--dir DIR`";
        missing(format!("cannot read the folder {folder}: {e}"), help.into())
    })?;
    let mut all: Vec<(String, PathBuf)> = entries
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.extension().is_some_and(|e| e == "toml"))
        .filter_map(|p| Some((p.file_stem()?.to_str()?.to_owned(), p)))
        .collect();
    all.sort();
    if all.is_empty() {
        return Err(missing(
            format!("there is no .toml file in {folder}"),
            "name another folder: `--dir DIR`".into(),
        ));
    }
    if args.names.is_empty() {
        return Ok(all);
    }
    let valid: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    args.names
        .iter()
        .map(|name| {
            all.iter().find(|(n, _)| n == name).cloned().ok_or_else(|| {
                let help = suggestion(name, &valid).unwrap_or_default();
                missing(format!("there is no scene \"{}\" in {folder}", escape(name)), help)
            })
        })
        .collect()
}

fn prepare(path: &Path) -> Result<Prepared, Failure> {
    let labels = Labels::new();
    let loaded = load(path, &LoadOptions::default()).map_err(|e| Failure::load(e, &labels))?;
    let prepared = loaded
        .desc
        .prepare(&PrepareOptions { instruction_set: instruction_set(), ..PrepareOptions::default() });
    prepared.map_err(|e| Failure::in_scene(e, &loaded.sources, &labels))
}

/// Times of one scene with one number of threads.
struct Row<'a> {
    name: &'a str,
    prepared: &'a Prepared,
    threads: usize,
    /// Render time of each run, in order.
    seconds: Vec<f64>,
    rays: u64,
    /// Render time of each run of the rival.
    rival: Vec<f64>,
}

fn measure<'a>(
    args: &ScenesArgs,
    (name, path): (&'a str, &Path),
    prepared: &'a Prepared,
    threads: usize,
    rival: Option<&dyn Rival>,
) -> Result<Row<'a>, Failure> {
    let mut row = Row { name, prepared, threads, seconds: Vec::new(), rays: 0, rival: Vec::new() };
    let never = AtomicBool::new(false);
    for _ in 0..args.repeat {
        let mut renderer = Renderer::new(prepared.clone()).map_err(Failure::new)?;
        let options = PassOptions { threads, cancel: &never, progress: None };
        let start = Instant::now();
        renderer.pass(u32::MAX, &options).map_err(Failure::new)?;
        row.seconds.push(start.elapsed().as_secs_f64());
        row.rays = renderer.stats.total();
        if let Some(rival) = rival {
            row.rival.extend(rival.trace(path, &prepared.view.film, threads)?);
        }
    }
    Ok(row)
}

/// The median.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[half]),
        _ => Some(0.5 * (sorted[half - 1] + sorted[half])),
    }
}

impl Row<'_> {
    fn median(&self) -> f64 {
        median(&self.seconds).unwrap_or(f64::NAN).max(1e-9)
    }

    fn json(&self, rival: Option<&dyn Rival>) -> serde_json::Value {
        let mut line = json!({
            "scene": self.name,
            "width": self.prepared.view.film.width,
            "height": self.prepared.view.film.height,
            "threads": self.threads,
            "seconds": self.seconds,
            "median_seconds": self.median(),
            "rays": self.rays,
            "rays_per_second": self.rays as f64 / self.median(),
            "version": env!("CARGO_PKG_VERSION"),
        });
        if let Some(key) = rival.map(Rival::key) {
            let other = median(&self.rival);
            line[format!("{key}_seconds")] = json!(self.rival);
            line[format!("{key}_median_seconds")] = json!(other);
            line[format!("{key}_ratio")] = json!(other.map(|s| s / self.median()));
        }
        line
    }

    fn text(&self, width: usize) -> String {
        let seconds = self.median();
        let rival = median(&self.rival).map_or(String::new(), |other| {
            format!("  {:>11}  {:>6}", text::seconds(other), format!("{:.2}x", other / seconds))
        });
        format!(
            "{:width$}  {:>7}  {:>10}  {:>11}  {:>9}{rival}\n",
            self.name,
            self.threads,
            text::seconds(seconds),
            text::count(self.rays as f64),
            text::count(self.rays as f64 / seconds)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }
}
