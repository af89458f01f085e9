//! `turner bench studio`: the interactive renderer, measured by the program `turner-studio`, which has it.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use crate::window;

/// Measure Turner Studio: from input to picture, frames per second, quality over time
#[derive(Debug, Args)]
#[command(
    after_help = "A scripted session without a window. Times are percentiles; the 95th is compared with the target."
)]
pub(crate) struct StudioBenchArgs {
    /// Scenes to measure [default: scenes of the gallery and two large ones]
    scenes: Vec<PathBuf>,
    /// Folder that keeps the converged pictures, so that the next run needs not render them
    #[arg(long, value_name = "FOLDER")]
    references: Option<PathBuf>,
    /// Print one JSON object per line
    #[arg(long)]
    json: bool,
}

/// Runs the measurement.
pub(crate) fn run(args: &StudioBenchArgs) -> u8 {
    let mut words: Vec<OsString> = vec!["bench".into()];
    if args.json {
        words.push("--json".into());
    }
    if let Some(folder) = &args.references {
        words.extend(["--references".into(), window::argument(folder)]);
    }
    words.extend(args.scenes.iter().map(|scene| window::argument(scene)));
    window::start(&words)
}
