//! `turner compare`: error metrics of two pictures.
//!
//! ```text
//! files ── read ──> turner::compare::Pair ── Metric::measure ──> text or JSON, difference picture, exit code
//! ```

mod json;
mod picture;
mod read;
mod text;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use turner::compare::{Measured, Metric, Mismatch, Pair};
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};

use crate::events::Events;
use crate::failure::{FAILED, Failure, USAGE};
use crate::report::Reporter;

/// Compare two pictures: error metrics and perceived differences
#[derive(Debug, Args)]
#[command(
    after_help = "Both must hold the same kind of values: linear light (EXR, HDR) or display values (PNG, JPEG, …).\n\
                  max, mean, rmse and relmse compare the values in the files; psnr, ssim and flip compare display\n\
                  values. A tolerance is the largest accepted value, for psnr and ssim the smallest.\n\
                  Exit codes: 0 within the tolerance or no tolerance, 1 beyond it or bad input, 2 bad usage."
)]
pub(crate) struct CompareArgs {
    /// The reference picture
    reference: PathBuf,
    /// The picture to compare with it
    picture: PathBuf,
    /// Metric to compute, also for --tolerance and --diff [default: all; flip for --tolerance and --diff]
    #[arg(long, value_name = "NAME")]
    metric: Option<MetricArg>,
    /// Exit with code 1 if the metric is worse than this
    #[arg(long, value_name = "NUMBER", value_parser = parse_tolerance, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Write the difference per pixel as a PNG, from black (none) to pale yellow
    #[arg(long, value_name = "OUT.png")]
    diff: Option<PathBuf>,
    /// Layer of the EXR files to compare, such as `albedo` [default: the picture]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Scale the picture to the size of the reference if their sizes differ
    #[arg(long)]
    resize: bool,
    /// Print JSON: see docs/reference/compare.md
    #[arg(long)]
    json: bool,
    /// Number of threads [default: all cores]; the result does not depend on it
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    threads: usize,
}

/// Metrics by their option.
#[derive(Clone, Copy, Debug)]
struct MetricArg(Metric);

impl ValueEnum for MetricArg {
    fn value_variants<'a>() -> &'a [MetricArg] {
        const ALL: [MetricArg; Metric::ALL.len()] = {
            let mut all = [MetricArg(Metric::Max); Metric::ALL.len()];
            let mut i = 0;
            while i < all.len() {
                all[i] = MetricArg(Metric::ALL[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(self.0.word()))
    }
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v >= 0.0 => Ok(v),
        _ => Err("expected a number, 0 or more".to_owned()),
    }
}

/// A tolerance and whether the metric is within it.
struct Verdict {
    metric: Metric,
    value: f64,
    tolerance: f64,
    within: bool,
}

/// The result.
struct Compared {
    /// The names of the pictures, escaped for a terminal.
    names: [String; 2],
    pair: Pair,
    /// The size of the picture before it was scaled to that of the reference.
    resized: Option<(u32, u32)>,
    measured: Vec<(Metric, Measured)>,
    verdict: Option<Verdict>,
    /// The difference picture.
    diff: Option<Diff>,
}

/// The difference picture that was written.
struct Diff {
    path: String,
    metric: Metric,
    /// The value shown as pale yellow.
    white: f32,
}

/// Runs the command.
pub(crate) fn run(args: &CompareArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    compare(args).unwrap_or_else(|failure| {
        reporter.failure(&failure);
        failure.exit
    })
}

fn compare(args: &CompareArgs) -> Result<u8, Failure> {
    // Before anything is read, so that a path that cannot be written is an error at once.
    let output = args.diff.as_deref().map(|path| picture::target(path, [&args.reference, &args.picture]));
    let output = output.transpose()?;
    let layer = args.layer.as_deref();
    let a = read::canvas(&args.reference, layer)?;
    let mut b = read::canvas(&args.picture, layer)?;
    let names = [&args.reference, &args.picture].map(|p| escape(&p.to_string_lossy()));
    let resized = Some((b.width, b.height)).filter(|size| args.resize && *size != (a.width, a.height));
    if resized.is_some() {
        b = b.resized(a.width, a.height);
    }
    let pair = Pair::new(a, b).map_err(|e| mismatch(&names, e))?;
    let threads = crate::render::threads(args.threads);
    let metrics = match args.metric {
        Some(MetricArg(metric)) => vec![metric],
        None => Metric::ALL.to_vec(),
    };
    let mut measured: Vec<(Metric, Measured)> =
        metrics.into_iter().map(|metric| (metric, metric.measure(&pair, threads))).collect();
    let wanted = args.metric.map_or(Metric::Flip, |m| m.0);
    let found = measured.iter().find(|(metric, _)| *metric == wanted).map(|(_, m)| m);
    let verdict = args.tolerance.zip(found).map(|(tolerance, found)| {
        let within = wanted.is_within(found.value, tolerance) && pair.unlike.count == 0;
        Verdict { metric: wanted, value: found.value, tolerance, within }
    });
    let diff = match (output, found) {
        (Some(output), Some(found)) => Some(output.write(&pair, wanted, found, threads)?),
        _ => None,
    };
    // The maps are large and no longer needed.
    measured.iter_mut().for_each(|(_, m)| m.map = Vec::new());
    let compared = Compared { names, pair, resized, measured, verdict, diff };
    if args.json {
        crate::text::print(&format!("{}\n", json::of(&compared)));
    } else {
        crate::text::print(&text::of(&compared));
    }
    let fails = compared.verdict.is_some_and(|v| !v.within);
    Ok(if fails { FAILED } else { 0 })
}

/// Why two pictures cannot be compared, with a remedy.
fn mismatch([a, b]: &[String; 2], error: Mismatch) -> Failure {
    let name = |first: bool| if first { a } else { b };
    let (message, help) = match error {
        Mismatch::Size((w, h), (v, u)) => (
            format!("{b}: {v}x{u} pixels, expected {w}x{h} as in {a}"),
            "render both with the same --width, --height and --crop, or add --resize",
        ),
        Mismatch::Alpha { first } => (
            format!("{}: partly transparent, but {} is opaque", name(first), name(!first)),
            "render both with the same background, or both with a transparent one",
        ),
        Mismatch::Encoding { first } => (
            format!("{}: linear light, but {} holds display values", name(first), name(!first)),
            "compare two EXR or HDR files, or two PNG files: display values include exposure and tone mapping",
        ),
    };
    Failure::new(SceneError::new(ErrorCode::Image, message).help(help))
}

/// A usage error about the difference picture.
fn refused(path: &Path, what: &str, help: &str) -> Failure {
    let message = format!("{}: {what}", escape(&path.to_string_lossy()));
    Failure { exit: USAGE, ..Failure::new(SceneError::new(ErrorCode::Output, message).help(help)) }
}
