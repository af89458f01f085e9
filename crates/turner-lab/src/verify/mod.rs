//! `turner-lab verify`: the complete statistical suite. `turner verify` has its shorter checks and the criteria.

mod materials;
mod references;

use std::path::PathBuf;

use clap::Args;
use turner_cli::verify::check::Effort;
use turner_cli::verify::{RunArgs, VERIFY_HELP, checks, run_checks};

/// Verify statistically that renderings are correct: the complete suite
#[derive(Debug, Args)]
#[command(after_help = VERIFY_HELP)]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    run: RunArgs,
    /// Use sixteen times the samples
    #[arg(long)]
    long: bool,
    /// A folder with S1.exr to S4.exr, 512x512 pixels, rendered by another renderer
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(args: &VerifyArgs) -> u8 {
    let mut all = checks();
    all.extend(references::checks(args.references.as_deref()));
    all.extend(materials::checks());
    run_checks(all, &args.run, if args.long { Effort::Long } else { Effort::Whole })
}
