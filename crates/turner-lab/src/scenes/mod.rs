//! `turner-lab scenes`: Mitsuba's scenes in Turner and in Mitsuba, at equal samples.
//!
//! ```text
//! mod ─┬─ files      scenes and their names
//!      ├─ turner     runs Turner as a program
//!      ├─ reference  pictures of many samples by Mitsuba; errors
//!      └─ table      text, JSON, Markdown, means
//! ```

mod files;
mod reference;
mod table;
mod turner;

use std::path::{Path, PathBuf};

use ::turner::schema::{ErrorCode, SceneError};
use clap::{Args, ValueEnum};
use files::SceneFile;
use reference::{Difference, Reference};
use tempfile::TempDir;
use turner::{Order, Turner};
use turner_cli::bench::median;
use turner_cli::events::Events;
use turner_cli::failure::{FAILED, Failure};
use turner_cli::report::Reporter;
use turner_cli::text;

use crate::peers::{Peer, PeerKind, install};

/// Compare with Mitsuba on scenes of Mitsuba: time and error at equal samples
#[derive(Debug, Args)]
#[command(
    after_help = "Seconds are the median over the seeds, for rendering alone; all renderers alternate.\n\
                  relMSE is the mean of (x - a)(x - b) / (r^2 + 0.01), without the thousandth of the pixels with the\n\
                  largest errors, averaged over the seeds; a and b are the halves of a reference by Mitsuba and r is\n\
                  their mean. So the noise of the reference does not count. `mean` is the mean brightness over that of\n\
                  the reference. time x error, each over Mitsuba's, is the time to equal error.\n\
                  \n\
                  Scenes keep their integrator and sampler. Those that a renderer cannot load are listed with the\n\
                  reason and are not in the means; the exit code is 1 if no scene is left. A reference belongs to the\n\
                  place and the text of its XML file: remove it after a change of a mesh or a picture."
)]
pub(crate) struct ScenesArgs {
    /// Scenes of Mitsuba, or folders with XML files or with folders of a scene.xml
    #[arg(required = true, value_name = "DIR|FILE")]
    scenes: Vec<PathBuf>,
    /// Samples per pixel; where the sampler of Mitsuba rounds up, both renderers take its number
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    samples: u32,
    /// Pixels of a picture, about, in the proportions of the scene's film
    #[arg(long, value_name = "PIXELS", default_value_t = 57_600, value_parser = clap::value_parser!(u32).range(256..=67_108_864))]
    size: u32,
    /// Renderings, each with its own seed
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    seeds: u32,
    /// Samples per pixel of the reference
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(2..=1 << 20))]
    reference: u32,
    /// Keep references in this folder, and use those that are there [default: a folder in the user's cache]
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    /// Number of threads; 0 for all processors
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    /// The Turner to measure [default: the one that turner-lab was built with]
    #[arg(long, value_name = "PROGRAM")]
    turner: Option<PathBuf>,
    /// Another Turner, measured in turn with the first
    #[arg(long, value_name = "PROGRAM")]
    before: Option<PathBuf>,
    /// Mitsuba's variant [default: mitsuba-llvm, or mitsuba-scalar where it does not run]
    #[arg(long, value_name = "VARIANT", value_parser = ["mitsuba-llvm", "mitsuba-scalar"])]
    peer: Option<String>,
    /// The Python that has Mitsuba [default: the one that --install-peers created, else python3]
    #[arg(long, value_name = "PROGRAM")]
    python: Option<PathBuf>,
    /// First install Mitsuba from PyPI into an environment in the user's cache, with --python or python3.11
    #[arg(long)]
    install_peers: bool,
    /// Write one JSON object per line
    #[arg(long, conflicts_with = "markdown")]
    json: bool,
    /// Write a Markdown table
    #[arg(long)]
    markdown: bool,
}

/// A scene in all renderers.
struct SceneResult {
    scene: String,
    /// Columns and rows.
    size: (u32, u32),
    /// Per pixel.
    samples: u32,
    /// Mitsuba, then each Turner.
    renderers: Vec<Measured>,
}

/// The runs of one renderer.
struct Measured {
    name: String,
    version: String,
    seconds: Vec<f64>,
    errors: Vec<f64>,
    brightnesses: Vec<f64>,
}

impl Measured {
    fn new(name: &str, version: &str) -> Measured {
        let [seconds, errors, brightnesses] = [const { Vec::new() }; 3];
        Measured { name: name.into(), version: version.into(), seconds, errors, brightnesses }
    }

    fn add(&mut self, seconds: f64, difference: Difference) {
        self.seconds.push(seconds);
        self.errors.push(difference.error);
        self.brightnesses.push(difference.brightness);
    }

    /// Median of the runs.
    fn seconds(&self) -> f64 {
        median(&self.seconds).unwrap_or(f64::NAN).max(1e-9)
    }

    /// Mean of the runs.
    fn error(&self) -> f64 {
        mean(&self.errors)
    }

    /// Mean brightness over that of the reference.
    fn brightness(&self) -> f64 {
        mean(&self.brightnesses)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Runs the command.
pub(crate) fn run(args: &ScenesArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    match compare(args, &reporter) {
        Ok(true) => 0,
        // The reasons were reported.
        Ok(false) => FAILED,
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

/// False if no scene was measured.
fn compare(args: &ScenesArgs, reporter: &Reporter) -> Result<bool, Failure> {
    let files = files::find(&args.scenes)?;
    let bench = Bench::new(args, reporter)?;
    let (mut results, mut left_out) = (Vec::new(), Vec::new());
    if !args.json && !args.markdown {
        text::print(&table::header(bench.kind.name()));
    }
    for file in &files {
        match bench.measure(file) {
            Ok(result) => {
                if !args.markdown {
                    text::print(&if args.json { table::lines(&result) } else { table::rows(&result) });
                }
                results.push(result);
            }
            Err(failure) => {
                let reason = reason(&failure);
                if args.json {
                    text::print(&table::left_out_line(&file.name, &reason));
                } else if !args.markdown {
                    text::print(&table::left_out(&file.name, &reason));
                }
                left_out.push((file.name.clone(), reason));
            }
        }
    }
    let summaries = table::summaries(&results);
    text::print(&if args.json {
        table::summary_lines(&summaries)
    } else {
        let table = if args.markdown { table::markdown(&results) } else { String::new() };
        let out = table::all_left_out(&left_out, args.markdown);
        format!("{table}\n{}{out}", table::summary_text(&summaries))
    });
    Ok(!results.is_empty())
}

/// A failure in one line.
fn reason(failure: &Failure) -> String {
    failure.errors.first().map_or("no message".into(), |error| error.message.clone())
}

/// What all scenes are measured with.
struct Bench<'a> {
    args: &'a ScenesArgs,
    /// The variant of Mitsuba.
    kind: PeerKind,
    python: Option<PathBuf>,
    threads: usize,
    turners: Vec<Turner>,
    references: PathBuf,
    /// For Turner's pictures.
    folder: TempDir,
}

impl<'a> Bench<'a> {
    /// Fails if a program cannot be run.
    fn new(args: &'a ScenesArgs, reporter: &Reporter) -> Result<Bench<'a>, Failure> {
        let mut turners = vec![Turner::new("turner", args.turner.as_deref())?];
        if let Some(before) = &args.before {
            turners.push(Turner::new("before", Some(before))?);
        }
        let asked: Vec<PeerKind> =
            args.peer.iter().filter_map(|name| PeerKind::from_str(name, false).ok()).collect();
        let python = if args.install_peers {
            Some(install::install(args.python.as_deref(), &[PeerKind::MitsubaLlvm])?)
        } else {
            args.python.clone()
        };
        let threads = turner_cli::threads(usize::from(args.threads));
        let folder = tempfile::tempdir().map_err(|e| {
            Failure::new(SceneError::new(ErrorCode::File, format!("cannot create a temporary folder: {e}")))
        })?;
        let references = args.references.clone().unwrap_or_else(|| install::cache("references"));
        std::fs::create_dir_all(&references).map_err(|e| {
            let message = format!("the folder {} cannot be made: {e}", references.display());
            Failure::new(
                SceneError::new(ErrorCode::Output, message).help("name another one with --references"),
            )
        })?;
        let kind = variant(&asked, python.as_deref(), folder.path(), threads, reporter)?;
        Ok(Bench { args, kind, python, threads, turners, references, folder })
    }

    /// Measures all renderers in turn on one scene.
    fn measure(&self, file: &SceneFile) -> Result<SceneResult, Failure> {
        let Bench { args, kind, threads, .. } = self;
        let (mut peer, size) =
            Peer::start_scaled(*kind, self.python.as_deref(), &file.path, *threads, args.size)?;
        // Compile the kernels for this number of samples. Both renderers take the number that Mitsuba takes.
        let samples = peer.render(args.samples, 1, size)?.samples;
        let order =
            |samples: u32, seed: u32| Order { scene: &file.path, size, samples, seed, threads: *threads };
        // Read the files once, and learn whether Turner can, before the reference takes its time.
        for turner in &self.turners {
            turner.render(order(1, 1), self.folder.path())?;
        }
        let reference = Reference::of(&mut peer, file, args.reference, size, &self.references)?;
        let mut renderers = vec![Measured::new(kind.name(), &peer.version)];
        renderers.extend(self.turners.iter().map(|t| Measured::new(t.name, &t.version)));
        for run in 0..args.seeds {
            let count = renderers.len();
            // The order rotates, so that no renderer always runs after the same one.
            for i in (0..count).map(|i| (i + run as usize) % count) {
                let Some(measured) = renderers.get_mut(i) else { continue };
                let (seconds, pixels) = match i.checked_sub(1).and_then(|i| self.turners.get(i)) {
                    Some(turner) => turner.render(order(samples, run + 2), self.folder.path())?,
                    None => {
                        let picture = peer.render(samples, run + 2, size)?;
                        (picture.seconds, picture.pixels)
                    }
                };
                let difference = reference.difference(&pixels).map_err(|why| {
                    Failure::new(SceneError::new(ErrorCode::Image, format!("{}: {why}", measured.name)))
                })?;
                measured.add(seconds, difference);
            }
        }
        Ok(SceneResult { scene: file.name.clone(), size, samples, renderers })
    }
}

/// A scene that every variant of Mitsuba renders.
const SMALL: &str = r#"<scene version="3.0.0">
    <integrator type="direct"/>
    <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film></sensor>
    <emitter type="constant"/>
</scene>"#;

/// The first variant that renders a picture: of those asked for, or else of both. Fails with the reason of the first.
fn variant(
    asked: &[PeerKind],
    python: Option<&Path>,
    folder: &Path,
    threads: usize,
    reporter: &Reporter,
) -> Result<PeerKind, Failure> {
    let kinds = if asked.is_empty() { &[PeerKind::MitsubaLlvm, PeerKind::MitsubaScalar] } else { asked };
    let scene = folder.join("small.xml");
    std::fs::write(&scene, SMALL)
        .map_err(|e| Failure::new(SceneError::new(ErrorCode::File, format!("{}: {e}", scene.display()))))?;
    let mut first = None;
    for kind in kinds {
        match Peer::start_scaled(*kind, python, &scene, threads, 64) {
            Ok(_) => {
                if let Some(failure) = &first {
                    reporter.line(&format!("{}; {} is measured instead", reason(failure), kind.name()));
                }
                return Ok(*kind);
            }
            Err(failure) => first = first.or(Some(failure)),
        }
    }
    let none = || Failure::new(SceneError::new(ErrorCode::File, "no variant of Mitsuba is asked for"));
    Err(first.unwrap_or_else(none))
}
