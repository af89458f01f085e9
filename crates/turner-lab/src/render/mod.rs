//! `turner-lab render`: error over time of path tracing, compared with other renderers.
//!
//! ```text
//! mod ─┬─ references  converged images
//!      ├─ curve       seconds to an error
//!      └─ table       text, JSON, Markdown ── plot  SVG
//! ```

mod curve;
mod plot;
mod references;
mod table;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::Args;
use curve::{Point, Reach, seconds_to};
use references::Reference;
use turner::film::Antialias;
use turner::integrator::Prepared;
use turner::render::{PassOptions, Renderer};
use turner::schema::{ErrorCode, PrepareOptions, SceneError};
use turner_cli::bench::median;
use turner_cli::events::Events;
use turner_cli::failure::{FAILED, Failure, Labels, two_lines};
use turner_cli::instructions::instruction_set;
use turner_cli::report::Reporter;
use turner_cli::{limits, text};
use turner_io::image::OutputFile;
use turner_io::scene::{LoadOptions, load};

use crate::peers::{Peer, PeerKind, install};

/// Measure the error over time of path tracing; compare with Mitsuba and Cycles
#[derive(Debug, Args)]
#[command(
    after_help = "Seconds are the median over the runs, for rendering alone. `start` is the time before: loading, building BVHs, and\n\
                  in other renderers importing modules and compiling kernels. Each run has its own seed; all renderers alternate.\n\
                  relMSE is mean((x - r)^2 / (r^2 + 0.01)) against a converged image, minus that image's own noise (`own_noise` in\n\
                  the refs.json next to it), averaged over the runs. Times to an error are read off the curve; ~ marks extrapolation.\n\
                  Other renderers read SCENE.json next to SCENE.toml: scenes/peers has four scenes with both."
)]
pub(crate) struct RenderBenchArgs {
    /// Scene files [default: scenes/peers/s1.toml to s4.toml]
    scenes: Vec<PathBuf>,
    /// Converged images NAME.exr of the scene's size, or folders with them [default: next to the scenes]
    #[arg(long, value_name = "DIR|FILE", value_delimiter = ',')]
    references: Vec<PathBuf>,
    /// Sample counts per pixel
    #[arg(long, value_delimiter = ',', default_value = "1,2,4,8,16,32,64", value_parser = clap::value_parser!(u32).range(1..=1_048_576))]
    samples: Vec<u32>,
    /// Numbers of threads; 0 for all processors
    #[arg(long, value_delimiter = ',', default_value = "0", value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: Vec<u16>,
    /// Renderings per sample count
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: u32,
    /// Other renderers to compare with
    #[arg(long, value_delimiter = ',')]
    peers: Vec<PeerKind>,
    /// The Python that has them [default: the one that --install-peers created, else python3]
    #[arg(long, value_name = "PROGRAM")]
    python: Option<PathBuf>,
    /// First install them from PyPI into an environment in the user's cache, with --python or python3.11
    #[arg(long, requires = "peers")]
    install_peers: bool,
    /// Write one JSON object per line
    #[arg(long, conflicts_with = "markdown")]
    json: bool,
    /// Write the times to an error as a Markdown table
    #[arg(long)]
    markdown: bool,
    /// Plot error over time, with a panel for each scene
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

/// One renderer on one scene.
struct Series {
    scene: String,
    renderer: String,
    version: String,
    threads: usize,
    width: u32,
    height: u32,
    /// Seconds before rendering.
    start: f64,
    measured: Vec<Measured>,
}

/// The runs at one sample count.
struct Measured {
    samples: u32,
    /// Each run.
    seconds: Vec<f64>,
    /// Each run's error, if known.
    errors: Vec<Option<f64>>,
}

impl Measured {
    /// Median of the runs.
    fn seconds(&self) -> f64 {
        median(&self.seconds).unwrap_or(f64::NAN).max(1e-9)
    }

    /// Mean of the runs, if all are known.
    fn error(&self) -> Option<f64> {
        let errors: Option<Vec<f64>> = self.errors.iter().copied().collect();
        errors.filter(|e| !e.is_empty()).map(|e| e.iter().sum::<f64>() / e.len() as f64)
    }
}

impl Series {
    /// Error over time.
    fn points(&self) -> Vec<Point> {
        let point = |m: &Measured| Some(Point { seconds: m.seconds(), error: m.error()? });
        self.measured.iter().filter_map(point).collect()
    }

    /// Seconds of rendering until the error is `target`.
    fn reach(&self, target: f64) -> Option<Reach> {
        seconds_to(&self.points(), target)
    }

    /// Camera paths per second at the highest sample count.
    fn paths_per_second(&self) -> Option<f64> {
        self.measured.last().map(|m| self.paths(m) / m.seconds())
    }

    /// Camera paths of one rendering.
    fn paths(&self, m: &Measured) -> f64 {
        f64::from(self.width) * f64::from(self.height) * f64::from(m.samples)
    }
}

/// Runs the command.
pub(crate) fn run(args: &RenderBenchArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    match bench(args, &reporter) {
        Ok(true) => 0,
        // The failure was reported.
        Ok(false) => FAILED,
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

/// False if another renderer failed; the others were still measured.
fn bench(args: &RenderBenchArgs, reporter: &Reporter) -> Result<bool, Failure> {
    let peers = PeerKind::expand(&args.peers);
    let installed =
        if args.install_peers { Some(install::install(args.python.as_deref(), &peers)?) } else { None };
    let python = installed.as_deref().or(args.python.as_deref());
    let scenes = scenes(&args.scenes)?;
    let mut samples = args.samples.clone();
    samples.sort_unstable();
    samples.dedup();
    let (mut all, mut complete) = (Vec::new(), true);
    for scene in &scenes {
        for &threads in &args.threads {
            let threads = turner_cli::threads(usize::from(threads));
            let (series, measured) = measure(args, &samples, scene, threads, (&peers, python), reporter)?;
            complete &= measured;
            let text = if args.json { table::lines(&series) } else { table::rows(&series) };
            if !args.markdown {
                text::print(&text);
            }
            all.extend(series);
        }
    }
    if args.markdown {
        text::print(&table::markdown(&all));
    } else if !args.json {
        text::print(&table::summary(&all));
    }
    if let Some(path) = &args.plot {
        OutputFile::create(path)
            .and_then(|file| file.commit(plot::svg(&all).as_bytes()))
            .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
    }
    Ok(complete)
}

/// The given scenes, or those that the other renderers can read.
fn scenes(given: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    if !given.is_empty() {
        return Ok(given.to_vec());
    }
    let folder = Path::new("scenes/peers");
    if !folder.is_dir() {
        let error = SceneError::new(ErrorCode::File, "the folder scenes/peers cannot be read");
        return Err(Failure::usage(
            error.help("run turner-lab in the root of Turner's sources, or name scenes"),
        ));
    }
    Ok((1..=4).map(|i| folder.join(format!("s{i}.toml"))).collect())
}

/// Measures all renderers in turn on one scene. Returns false if one failed: it is reported and omitted from then on.
fn measure(
    args: &RenderBenchArgs,
    samples: &[u32],
    path: &Path,
    threads: usize,
    (peers, python): (&[PeerKind], Option<&Path>),
    reporter: &Reporter,
) -> Result<(Vec<Series>, bool), Failure> {
    let (mut turner, start) = Turner::prepare(path, threads)?;
    let size = turner.size;
    let reference = references::find(&args.references, path, size)?;
    if let Err(remark) = &reference {
        reporter.line(remark);
    }
    let reference = reference.ok();
    let (mut others, mut complete) = start_peers(path, threads, peers, python, reporter);
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let new = |renderer: &str, version: &str, start: f64| Series {
        scene: name.clone(),
        renderer: renderer.into(),
        version: version.into(),
        threads,
        width: size.0,
        height: size.1,
        start,
        measured: Vec::new(),
    };
    let mut series = vec![new("turner", env!("CARGO_PKG_VERSION"), start)];
    series.extend(others.iter().flatten().map(|p| new(p.kind.name(), &p.version, p.start)));
    // Warm up, as the other renderers have done.
    turner.render(1, 0)?;
    for &samples in samples {
        for (i, s) in series.iter_mut().enumerate() {
            if i == 0 || others.get(i - 1).is_some_and(Option::is_some) {
                s.measured.push(Measured { samples, seconds: Vec::new(), errors: Vec::new() });
            }
        }
        for run in 0..args.runs {
            // The order rotates, so that no renderer always runs after the same one.
            for i in 0..series.len() {
                let i = (i + run as usize) % series.len();
                let (seconds, taken, picture) = match i.checked_sub(1).and_then(|i| others.get_mut(i)) {
                    Some(slot) => {
                        let Some(peer) = slot else { continue };
                        match peer.render(samples, run + 2, size) {
                            Ok(picture) => (picture.seconds, picture.samples, picture.pixels),
                            Err(failure) => {
                                reporter.failure(&failure);
                                (*slot, complete) = (None, false);
                                series.get_mut(i).map(|s| s.measured.pop());
                                continue;
                            }
                        }
                    }
                    None => turner.render(samples, run + 2)?,
                };
                let error = reference.as_ref().and_then(|r: &Reference| r.error(&picture));
                if let Some(measured) = series.get_mut(i).and_then(|s| s.measured.last_mut()) {
                    measured.samples = taken;
                    measured.seconds.push(seconds);
                    measured.errors.push(error);
                }
            }
        }
    }
    Ok((series, complete))
}

/// Starts the other renderers if the scene has a description for them. Returns false if one could not be started.
fn start_peers(
    scene: &Path,
    threads: usize,
    peers: &[PeerKind],
    python: Option<&Path>,
    reporter: &Reporter,
) -> (Vec<Option<Peer>>, bool) {
    let description = scene.with_extension("json");
    if !peers.is_empty() && !description.is_file() {
        reporter.line(&format!("{}: no such file; only Turner is measured", description.display()));
        return (Vec::new(), true);
    }
    let mut started = Vec::new();
    for &kind in peers {
        match Peer::start(kind, python, &description, threads) {
            Ok(peer) => started.push(Some(peer)),
            Err(failure) => reporter.failure(&failure),
        }
    }
    let all = started.len() == peers.len();
    (started, all)
}

/// Turner and its scene.
struct Turner {
    prepared: Prepared,
    threads: usize,
    size: (u32, u32),
}

impl Turner {
    /// Returns the seconds for loading and preparing, too.
    fn prepare(path: &Path, threads: usize) -> Result<(Turner, f64), Failure> {
        let labels = Labels::new();
        let start = Instant::now();
        let options = LoadOptions { threads, limits: limits::of_machine(), ..LoadOptions::default() };
        let loaded = load(path, &options).map_err(|e| Failure::load(e, &labels))?;
        let options =
            PrepareOptions { threads, instruction_set: instruction_set(), ..PrepareOptions::default() };
        let prepared = loaded.desc.prepare(&options);
        let mut prepared = prepared.map_err(|e| Failure::in_scene(e, &loaded.sources, &labels))?;
        let seconds = start.elapsed().as_secs_f64();
        prepared.view.film.antialias = Antialias::MonteCarlo;
        let crop = Renderer::new(prepared.clone()).map_err(Failure::new)?.film.crop;
        Ok((Turner { prepared, threads, size: (crop.width, crop.height) }, seconds))
    }

    /// Returns seconds, samples and pixels.
    fn render(&mut self, samples: u32, seed: u32) -> Result<(f64, u32, Vec<[f64; 3]>), Failure> {
        let film = &mut self.prepared.view.film;
        (film.samples, film.seed) = (samples, seed);
        let never = AtomicBool::new(false);
        let start = Instant::now();
        let mut renderer = Renderer::new(self.prepared.clone()).map_err(Failure::new)?;
        let options = PassOptions { threads: self.threads, cancel: &never, progress: None };
        renderer.pass(u32::MAX, &options).map_err(Failure::new)?;
        let seconds = start.elapsed().as_secs_f64();
        let picture = renderer.film.develop(&self.prepared.view.film, 0);
        let pixels = picture.linear.iter().map(|[r, g, b, _]| [*r, *g, *b].map(f64::from)).collect();
        Ok((seconds, samples, pixels))
    }
}
