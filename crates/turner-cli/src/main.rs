//! The program `turner`: see the library for what it does.

use std::process::ExitCode;

fn main() -> ExitCode {
    turner_cli::start()
}
