//! The program `turner`. The library `turner_cli` documents it.

use std::process::ExitCode;

fn main() -> ExitCode {
    turner_cli::start()
}
