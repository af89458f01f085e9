//! The laboratory: Turner measured beside other renderers and trees, and the whole statistical suite. For those who work on
//! Turner; what users need of it is in `turner bench` and `turner verify`, whose parts this uses.
//!
//! ```text
//! start ─┬─ rays       rays per second of the trees, beside Embree
//!        ├─ render     error over time of path tracing, beside Mitsuba and Cycles
//!        ├─ povray     the classic scenes, beside POV-Ray ─┬─ program  runs it
//!        ├─ antialias  modes of anti-aliasing, beside its  ┘
//!        └─ verify     statistics
//! ```
#![forbid(unsafe_code)]

mod povray;
mod rays;
mod render;
mod verify;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use turner_cli::color;

/// Measures Turner beside other renderers, and checks by statistics that what it renders is true.
#[derive(Debug, Parser)]
#[command(
    name = "turner-lab",
    version,
    styles = color::STYLES,
    disable_help_subcommand = true,
    arg_required_else_help = true,
    after_help = "Run it in the root of Turner's sources. `turner bench` measures scenes on this machine alone."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Rays(rays::RaysArgs),
    Render(render::RenderBenchArgs),
    Povray(povray::PovrayArgs),
    Antialias(povray::AntialiasArgs),
    Verify(verify::VerifyArgs),
}

/// Runs the command of the process' arguments and returns its exit code: 0, 1 for bad input, failures and checks that fail, 2 for
/// bad usage.
pub fn start() -> ExitCode {
    turner_cli::start_with(|args, _| run(args))
}

fn run(args: Vec<OsString>) -> u8 {
    match Cli::try_parse_from(args).map(|cli| cli.command) {
        Ok(Command::Rays(args)) => rays::run(&args),
        Ok(Command::Render(args)) => render::run(&args),
        Ok(Command::Povray(args)) => povray::run(&args),
        Ok(Command::Antialias(args)) => povray::run_antialias(&args),
        Ok(Command::Verify(args)) => verify::run(&args),
        Err(error) => {
            // A closed pipe is no reason to complain.
            let _ = error.print();
            u8::try_from(error.exit_code()).unwrap_or(turner_cli::failure::USAGE)
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        super::Cli::command().debug_assert();
    }
}
