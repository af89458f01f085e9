//! `turner bench`: how fast scenes render, also beside POV-Ray; `render` measures path tracing, `antialias` its modes.

mod antialias;
mod curve;
mod install;
mod peer;
mod plot;
mod references;
mod render;
mod table;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::{Args, Subcommand};
use serde_json::json;
use turner::render::{PassOptions, Renderer};
use turner::scene::error::{ErrorCode, SceneError, escape, suggestion};
use turner::scene::{PrepareOptions, Scene};
use turner_io::scene::{LoadOptions, load};

use crate::events::Events;
use crate::failure::{Failure, Labels, USAGE};
use crate::povray::PovRay;
use crate::report::Reporter;
use crate::{rays, text};

/// Measure how fast the scenes of a folder render
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true,
    subcommand_help_heading = "Others",
    after_help = "Seconds are the median over the repetitions of tracing alone: neither loading nor saving.\n\
                        POV-Ray's are its own `Trace Time`; its runs alternate with Turner's."
)]
pub(crate) struct BenchArgs {
    #[command(subcommand)]
    other: Option<OtherBench>,
    /// Names of scenes, without .toml [default: all of the folder]
    names: Vec<String>,
    /// The folder of the scenes
    #[arg(long, default_value = "scenes/bench")]
    dir: PathBuf,
    /// Numbers of threads; 0 is all there are
    #[arg(long, value_delimiter = ',', default_value = "0")]
    threads: Vec<usize>,
    /// How often each is rendered
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repeat: u32,
    /// One JSON object per line
    #[arg(long)]
    json: bool,
    /// Run POV-Ray on a .pov file beside the scene, where there is one
    #[arg(long, value_name = "PROGRAM", num_args = 0..=1, default_missing_value = "povray", require_equals = true)]
    povray: Option<PathBuf>,
}

/// What else is measured than the scenes of a folder.
#[derive(Debug, Subcommand)]
enum OtherBench {
    Rays(rays::RaysArgs),
    Render(render::RenderBenchArgs),
    Antialias(antialias::AntialiasBenchArgs),
}

/// Runs the command.
pub(crate) fn run(args: &BenchArgs) -> u8 {
    match &args.other {
        Some(OtherBench::Rays(args)) => return rays::run(args),
        Some(OtherBench::Render(args)) => return render::run(args),
        Some(OtherBench::Antialias(args)) => return antialias::run(args),
        None => {}
    }
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    match bench(args) {
        Ok(()) => 0,
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

fn bench(args: &BenchArgs) -> Result<(), Failure> {
    let scenes = find(args)?;
    let width = scenes.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max(5);
    if !args.json {
        let povray = if args.povray.is_some() { "      POV-Ray   ratio" } else { "" };
        text::print(&format!("{:width$}  threads      median         rays     rays/s{povray}\n", "scene"));
    }
    for (name, path) in &scenes {
        let scene = prepare(path)?;
        for &threads in &args.threads {
            let threads = crate::render::threads(threads);
            let povray = args.povray.as_deref().and_then(|program| PovRay::beside(program, path));
            let row = measure(args, name, &scene, threads, povray)?;
            text::print(&if args.json { format!("{}\n", row.json()) } else { row.text(width) });
        }
    }
    Ok(())
}

/// The scenes asked for, by name; an explanation if there are none.
fn find(args: &BenchArgs) -> Result<Vec<(String, PathBuf)>, Failure> {
    let folder = args.dir.display().to_string();
    let missing = |message: String, help: String| Failure {
        exit: USAGE,
        ..Failure::new(SceneError::new(ErrorCode::File, message).help(help))
    };
    let entries = std::fs::read_dir(&args.dir).map_err(|e| {
        let help = "run it in the root of Turner's sources, or name a folder of scenes with --dir";
        missing(format!("the folder {folder} cannot be read: {e}"), help.into())
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
            "name another folder with --dir".into(),
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

fn prepare(path: &Path) -> Result<Scene, Failure> {
    let labels = Labels::new();
    let loaded = load(path, &LoadOptions::default()).map_err(|e| Failure::load(e, &labels))?;
    let prepared = loaded.desc.prepare(&PrepareOptions::default());
    prepared.map_err(|e| Failure::in_scene(e, &loaded.sources, &labels))
}

/// What one scene took with one number of threads.
struct Row<'a> {
    name: &'a str,
    scene: &'a Scene,
    threads: usize,
    /// Each run, in order.
    seconds: Vec<f64>,
    rays: u64,
    /// Each run of POV-Ray, if there was one.
    povray: Vec<f64>,
}

fn measure<'a>(
    args: &BenchArgs,
    name: &'a str,
    scene: &'a Scene,
    threads: usize,
    povray: Option<PovRay>,
) -> Result<Row<'a>, Failure> {
    let mut row = Row { name, scene, threads, seconds: Vec::new(), rays: 0, povray: Vec::new() };
    let never = AtomicBool::new(false);
    for _ in 0..args.repeat {
        let mut renderer = Renderer::new(scene).map_err(Failure::new)?;
        let options = PassOptions { threads, cancel: &never, progress: None };
        let start = Instant::now();
        renderer.pass(u32::MAX, &options).map_err(Failure::new)?;
        row.seconds.push(start.elapsed().as_secs_f64());
        row.rays = renderer.stats.total();
        if let Some(povray) = &povray {
            row.povray.push(povray.trace(scene.film.width, scene.film.height, threads)?);
        }
    }
    Ok(row)
}

/// The middle value, or the mean of the two middle ones.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some(0.5 * (sorted[middle - 1] + sorted[middle])),
    }
}

impl Row<'_> {
    fn median(&self) -> f64 {
        median(&self.seconds).unwrap_or(f64::NAN).max(1e-9)
    }

    fn json(&self) -> serde_json::Value {
        let povray = median(&self.povray);
        json!({
            "scene": self.name,
            "width": self.scene.film.width,
            "height": self.scene.film.height,
            "threads": self.threads,
            "seconds": self.seconds,
            "median_seconds": self.median(),
            "rays": self.rays,
            "rays_per_second": self.rays as f64 / self.median(),
            "povray_seconds": self.povray,
            "povray_median_seconds": povray,
            "povray_ratio": povray.map(|p| p / self.median()),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self, width: usize) -> String {
        let seconds = self.median();
        let povray = median(&self.povray).map_or(String::new(), |p| {
            format!("  {:>11}  {:>6}", text::seconds(p), format!("{:.2}x", p / seconds))
        });
        format!(
            "{:width$}  {:>7}  {:>10}  {:>11}  {:>9}{povray}\n",
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
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }
}
