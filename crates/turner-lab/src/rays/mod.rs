//! `turner-lab rays`: rays per second of the BVHs, compared with Embree.
//!
//! ```text
//! mod ─┬─ kinds    the rays of a rendering      tracer   Turner's BVHs ── instances  two levels
//!      ├─ builds   seconds and bytes            embree   Embree, if the feature is enabled
//!      ├─ measure  alternating runs, threads, results
//!      └─ table    text, JSON, means
//! ```

mod builds;
#[cfg_attr(not(feature = "embree"), path = "no_embree.rs")]
mod embree;
mod instances;
mod kinds;
mod measure;
mod table;
#[cfg(test)]
mod tests;
mod tracer;

use std::path::PathBuf;

use builds::Trees;
use clap::{Args, ValueEnum};
use embree::Embree;
use kinds::{Kind, Picture};
use measure::{Contender, Plan, Query};
use table::{Column, RayRow, Table};
use tracer::Quality;
use turner::schema::{ErrorCode, SceneError};
use turner_bvh::generate::SceneKind;
use turner_cli::bench::median;
use turner_cli::events::Events;
use turner_cli::failure::Failure;
use turner_cli::report::Reporter;
use turner_cli::text;

/// Measure rays per second of the BVHs in generated scenes
#[derive(Debug, Args)]
#[command(
    after_help = "Rates are million rays per second: the median over the repetitions, in which all contenders alternate. Threads\n\
                  are pinned. In sets of rays that take long, evenly spaced chunks are omitted.\n\
                  `differ` counts the rays with different results in Turner and Embree: hit or miss, or t by more than 1e-4."
)]
pub(crate) struct RaysArgs {
    /// Scenes: cornell, architecture, scan, sticks, terrain, instances-1k, instances-1m [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = scene_parser(), hide_possible_values = true)]
    scene: Vec<SceneKind>,
    /// Kinds of rays [default: all]
    #[arg(long, value_name = "KINDS", value_delimiter = ',')]
    kind: Vec<Kind>,
    /// Build qualities of Turner's BVHs; the last is compared with Embree
    #[arg(long, value_delimiter = ',', default_value = "balanced")]
    quality: Vec<Quality>,
    /// Numbers of threads for building and tracing; 0 for all processors
    #[arg(long, value_delimiter = ',', default_value = "1", value_parser = threads)]
    threads: Vec<usize>,
    /// Repetitions of each measurement
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repeat: u32,
    /// Embree 4's shared library: a path, or a name for the system to find
    #[arg(long, value_name = "PATH")]
    embree: Option<PathBuf>,
    /// Embree's BVHs to trace
    #[arg(long, value_name = "TREES", value_delimiter = ',', default_value = "medium,high,robust")]
    embree_quality: Vec<Rival>,
    /// Width and height in pixels of the rendering whose rays are traced
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=8192))]
    resolution: u32,
    /// Triangles (or instances), as a fraction of each scene's default
    #[arg(long, default_value_t = 1.0, value_parser = part)]
    scale: f64,
    /// Write one JSON object per line
    #[arg(long)]
    json: bool,
}

/// Embree's build settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Rival {
    /// Morton codes; only the build is measured unless named
    Low,
    /// Binned SAH
    Medium,
    /// SAH with spatial splits
    High,
    /// Like medium, watertight
    Robust,
}

impl Rival {
    fn name(self) -> &'static str {
        match self {
            Rival::Low => "low",
            Rival::Medium => "medium",
            Rival::High => "high",
            Rival::Robust => "robust",
        }
    }
}

fn scene_parser() -> impl clap::builder::TypedValueParser<Value = SceneKind> {
    use clap::builder::{PossibleValuesParser, TypedValueParser};
    let names = PossibleValuesParser::new(SceneKind::ALL.map(SceneKind::name));
    // The parser only lets valid names through.
    names.try_map(|name| SceneKind::ALL.into_iter().find(|k| k.name() == name).ok_or("no such scene"))
}

fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Ok(turner_cli::threads(0)),
        Ok(n @ 1..=1024) => Ok(n),
        Ok(_) | Err(_) => Err("a number from 1 to 1024, or 0 for all processors".into()),
    }
}

fn part(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(part) if part > 0.0 && part <= 4.0 => Ok(part),
        Ok(_) | Err(_) => Err("a number greater than 0 and at most 4".into()),
    }
}

/// Runs the command.
pub(crate) fn run(args: &RaysArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    match bench(args) {
        Ok(()) => 0,
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

fn bench(args: &RaysArgs) -> Result<(), Failure> {
    let embree = match &args.embree {
        Some(path) => Some(Embree::load(path).map_err(|reason| {
            let help = "pass Embree 4's shared library, such as libembree4.so.4, with --embree";
            Failure::usage(SceneError::new(ErrorCode::File, reason).help(help))
        })?),
        None => None,
    };
    let mut table = Table::new(args, embree.as_ref());
    let scenes: &[SceneKind] = if args.scene.is_empty() { &SceneKind::ALL } else { &args.scene };
    for &kind in scenes {
        let scene = kind.generate((kind.default_size() as f64 * args.scale) as usize);
        let mut picture = None;
        for &threads in &args.threads {
            let failed = |reason: String| {
                let message = format!("{}: {reason}", kind.name());
                Failure::new(SceneError::new(ErrorCode::Internal, message))
            };
            let (trees, rows) = Trees::build(args, embree.as_ref(), &scene, threads).map_err(failed)?;
            table.builds(kind, threads, &rows);
            let turner = Contender { tracer: trees.best(), query: Query::Batch };
            let picture = picture.get_or_insert_with(|| Picture::new(&scene, args.resolution, turner));
            let kinds: &[Kind] = if args.kind.is_empty() { &Kind::ALL } else { &args.kind };
            for &rays in kinds {
                let row = measure_row(args, &trees, picture, rays, threads);
                table.rays(kind, threads, scene.triangles(), rays, row);
            }
        }
    }
    table.means(&args.threads);
    Ok(())
}

/// Measures all contenders in turn on one kind of rays.
fn measure_row(args: &RaysArgs, trees: &Trees, picture: &Picture, kind: Kind, threads: usize) -> RayRow {
    let set = picture.rays(kind);
    let contenders = contenders(trees, kind);
    let turner = Contender { tracer: trees.best(), query: kind.query() };
    let mut row = RayRow { rays: 0, rates: Vec::new(), compared: None };
    if set.rays.is_empty() {
        return row;
    }
    let plan = Plan::new(set, turner, threads);
    row.rays = plan.rays;
    if let Some(embree) = trees.reference() {
        let query = if kind.query() == Query::Coherent { Query::Coherent } else { Query::One };
        let ours = measure::answers(set, turner, &plan);
        let theirs = measure::answers(set, Contender { tracer: embree, query }, &plan);
        row.compared = Some((measure::differences(&ours, &theirs), ours.len()));
    }
    let mut runs = vec![Vec::new(); contenders.len()];
    for turn in 0..args.repeat as usize {
        // The order rotates, so that no contender always runs after the same one.
        for i in 0..contenders.len() {
            let i = (i + turn) % contenders.len();
            let seconds = measure::run(set, contenders[i].1, &plan, threads).as_secs_f64();
            runs[i].push(plan.rays as f64 / 1e6 / seconds.max(1e-9));
        }
    }
    let columns = contenders.iter().map(|c| c.0);
    row.rates = columns.zip(runs).filter_map(|(c, runs)| Some((c, median(&runs)?, runs))).collect();
    row
}

/// The contenders of a row, by table column.
fn contenders<'a>(trees: &'a Trees, kind: Kind) -> Vec<(Column, Contender<'a>)> {
    let query = kind.query();
    let mut all = Vec::new();
    for (quality, tree) in &trees.turner {
        all.push((Column::Turner(*quality), Contender { tracer: tree, query }));
    }
    if query != Query::Coherent {
        all.push((Column::One, Contender { tracer: trees.best(), query: Query::One }));
    }
    for (rival, tree) in &trees.embree {
        let query = if query == Query::Coherent { query } else { Query::One };
        all.push((Column::Embree(*rival), Contender { tracer: tree, query }));
    }
    all
}

/// Prints output immediately.
fn show(text: &str) {
    text::print(text);
}
