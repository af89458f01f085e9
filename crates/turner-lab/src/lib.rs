//! `turner-lab`, for developers of Turner: benchmarks against other renderers and BVHs, and the complete statistical
//! suite. `turner bench` and `turner verify` have the parts that users need; this program builds on them.
//!
//! ```text
//! start ─┬─ rays       rays per second of Turner's BVHs, compared with Embree
//!        ├─ render     error over time of path tracing, compared with Mitsuba and Cycles
//!        ├─ scenes     time and error on scenes of Mitsuba, compared with Mitsuba
//!        ├─ denoise    error and time of denoisers, compared with Open Image Denoise
//!        ├─ preview    time and error of the pictures that a window shows
//!        ├─ povray     the classic scenes, compared with POV-Ray ─┬─ program  runs it
//!        ├─ antialias  anti-aliasing modes, compared with POV-Ray ┘
//!        └─ verify     statistical tests
//! ```
#![forbid(unsafe_code)]

mod denoise;
mod message;
mod peers;
mod picture;
mod povray;
mod preview;
mod rays;
mod render;
mod scenes;
mod statistics;
mod verify;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use turner_cli::color;

/// Compare Turner with other renderers, and verify its results statistically.
#[derive(Debug, Parser)]
#[command(
    name = "turner-lab",
    version,
    styles = color::STYLES,
    disable_help_subcommand = true,
    arg_required_else_help = true,
    after_help = "Run it in the root of Turner's sources. `turner bench` measures scenes without other renderers."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Rays(rays::RaysArgs),
    Render(render::RenderBenchArgs),
    Scenes(scenes::ScenesArgs),
    Denoise(denoise::DenoiseArgs),
    Preview(preview::PreviewArgs),
    Povray(povray::PovrayArgs),
    Antialias(povray::AntialiasArgs),
    Verify(verify::VerifyArgs),
}

/// As the first argument: the others are those of the program `turner`. So `scenes` runs the Turner that this program
/// was built with.
const TURNER: &str = "turner";

/// Runs the command line and returns the exit code: 0 for success, 1 for bad input, failures and failed checks, 2 for
/// bad usage.
pub fn start() -> ExitCode {
    let mut args: Vec<OsString> = std::env::args_os().collect();
    if args.get(1).is_some_and(|first| first == TURNER) {
        args.remove(0);
        return turner_cli::start_from(args);
    }
    turner_cli::start_with(|args, _| run(args))
}

fn run(args: Vec<OsString>) -> u8 {
    match Cli::try_parse_from(args).map(|cli| cli.command) {
        Ok(Command::Rays(args)) => rays::run(&args),
        Ok(Command::Render(args)) => render::run(&args),
        Ok(Command::Scenes(args)) => scenes::run(&args),
        Ok(Command::Denoise(args)) => denoise::run(&args),
        Ok(Command::Preview(args)) => preview::run(&args),
        Ok(Command::Povray(args)) => povray::run(&args),
        Ok(Command::Antialias(args)) => povray::run_antialias(&args),
        Ok(Command::Verify(args)) => verify::run(&args),
        Err(error) => {
            // Ignore a closed pipe.
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
