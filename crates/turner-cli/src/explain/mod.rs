//! `turner explain`: why a pixel has its colour, ray by ray.
//!
//! ```text
//! run ── scene ── turner_explain::written ── output
//! ```

mod every_pixel;
mod path_of;

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use turner::explain::Names;
use turner::schema::{ErrorCode, SceneError};
pub use turner_explain::Wanted;
use turner_io::image::OutputFile;

use crate::control::Control;
use crate::events::Events;
use crate::failure::{FAILED, Failure, two_lines};
use crate::report::Reporter;
use crate::scene::{FilmArgs, SceneArgs};
use crate::text::print;

/// Explain the colour of a pixel: every ray, what it hit and what it contributed
#[derive(Debug, Args)]
#[command(
    after_help = "Give the options that the picture was rendered with: samples depend on them. With --samples N and \"path\" the sample \
                  with the largest contribution among the N is shown."
)]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Column and row of the pixel, from 0 at the top left
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = parse_pixel,
        allow_hyphen_values = true,
        required_unless_present = "page"
    )]
    pixel: Option<(u32, u32)>,
    /// Sample index, from 0 [default: the sample with the largest contribution]
    #[arg(long, value_name = "N")]
    sample: Option<usize>,
    #[command(flatten)]
    film: FilmArgs,
    /// Show only paths that hit the object or material of this name
    #[arg(long, value_name = "NAME")]
    path_of: Option<String>,
    /// Output format [default: by the extension of the output file, otherwise text]
    #[arg(long)]
    format: Option<Format>,
    /// Short for --format json
    #[arg(long, conflicts_with = "format")]
    json: bool,
    /// Output file; `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Show all rays and samples, not only those with the largest contributions
    #[arg(long)]
    all: bool,
    /// Write one HTML file in which every pixel can be clicked: with the picture, the scene and Turner itself inside
    #[arg(long, conflicts_with_all = ["sample", "path_of", "format", "json", "all"])]
    page: bool,
    /// Turner's WebAssembly module for --page [default: `turner.wasm` beside the program]
    #[arg(long, value_name = "FILE", requires = "page")]
    module: Option<PathBuf>,
}

/// How an explanation is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// A tree for terminals
    Text,
    /// All values, for programs
    Json,
    /// A drawing of the tree and of the rays in the scene
    Svg,
    /// The drawing as an interactive page
    Html,
}

fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    let numbers =
        text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    numbers.ok_or_else(|| "expected two integers X,Y; write `--pixel 320,240`".to_owned())
}

impl ExplainArgs {
    /// The format, and the file if there is one.
    fn target(&self) -> Result<(Format, Option<PathBuf>), Failure> {
        let path = self.output.clone().filter(|path| path.as_os_str() != "-");
        let extension = path.as_ref().and_then(|p| p.extension()).and_then(OsStr::to_str);
        let by_name = match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("json") => Some(Format::Json),
            Some("svg") => Some(Format::Svg),
            Some("html" | "htm") => Some(Format::Html),
            Some("txt" | "text") => Some(Format::Text),
            _ => None,
        };
        let asked = if self.json { Some(Format::Json) } else { self.format };
        match (asked.or(by_name), &path) {
            (Some(format), _) => Ok((format, path)),
            (None, None) => Ok((Format::Text, None)),
            (None, Some(shown)) => {
                let shown = turner::schema::error::escape(&shown.to_string_lossy());
                let message = format!("{shown}: the extension names no format of explanations");
                let help = "use .txt, .json, .svg or .html, or add `--format`";
                Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)))
            }
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &ExplainArgs, control: &Control) -> u8 {
    let json = args.json || args.format == Some(Format::Json);
    let events = (json && args.output.is_none()).then_some(Events::Stdout);
    let reporter = Reporter { quiet: false, events };
    control.hear(&reporter);
    explain(args, &reporter, control).unwrap_or_else(|failure| {
        reporter.failure(&failure);
        failure.exit
    })
}

fn explain(args: &ExplainArgs, reporter: &Reporter, control: &Control) -> Result<u8, Failure> {
    if args.page {
        return every_pixel::run(args, reporter, control);
    }
    let (format, path) = args.target()?;
    let output =
        |e: turner_io::image::OutputError| Failure::new(two_lines(ErrorCode::Output, &e.to_string()));
    // Checks that the file can be written before any work is done.
    let file = path.map(OutputFile::create).transpose().map_err(output)?;
    let ready = args.scene.ready(&args.film, args.scene.studio.models(), 0, control)?;
    let prepared = &ready.prepared;
    let bad = |e| Failure::in_scene(e, &ready.sources, &ready.labels);
    let names = Names { prepared, desc: &ready.desc, path_of: args.path_of.as_deref() };
    if let Some(wanted) = &args.path_of {
        path_of::check(&names, wanted).map_err(bad)?;
    }
    let name = args.scene.scene.to_string_lossy().into_owned();
    let wanted = Wanted { pixel: args.pixel.unwrap_or_default(), sample: args.sample, all: args.all };
    let to_file = file.is_some();
    let (text, exact) =
        written(&names, (name, ready.hash.whole.clone()), &wanted, format, to_file).map_err(bad)?;
    match file {
        Some(file) => file.commit(text.as_bytes()).map_err(output)?,
        None => print(&text),
    }
    if format != Format::Json || args.output.is_some() {
        reporter.warnings(&prepared.warnings, &ready.sources, &ready.labels);
    }
    if exact {
        return Ok(0);
    }
    let error = SceneError::new(ErrorCode::Internal, "the contributions do not sum to the sample");
    reporter.failure(&Failure::new(error.help("this is a bug in Turner: please report it")));
    Ok(FAILED)
}

/// The explanation of a pixel as text, and whether its contributions add up to the pixel. `scene` is the scene's name and
/// hash; `to_file` says that the text is for a file, without colours for a terminal.
///
/// Errors: a pixel outside the picture, a sample that it does not have.
pub fn written(
    names: &Names<'_>,
    scene: (String, String),
    wanted: &Wanted,
    format: Format,
    to_file: bool,
) -> Result<(String, bool), SceneError> {
    let format = match format {
        Format::Text => turner_explain::Format::Text { colors: !to_file && shows_colors() },
        Format::Json => turner_explain::Format::Json,
        Format::Svg => turner_explain::Format::Svg,
        Format::Html => turner_explain::Format::Html,
    };
    turner_explain::written(names, scene, wanted, format)
}

/// Whether standard output is a terminal with 24-bit colours and `NO_COLOR` is not set.
fn shows_colors() -> bool {
    let has = |name: &str, words: &[&str]| {
        std::env::var(name).is_ok_and(|value| words.iter().any(|word| value.contains(word)))
    };
    let able = has("COLORTERM", &["truecolor", "24bit"])
        || has("TERM", &["direct", "kitty", "alacritty", "wezterm", "ghostty"])
        || std::env::var_os("WT_SESSION").is_some();
    able && crate::color::are_wanted(&std::io::stdout())
}
