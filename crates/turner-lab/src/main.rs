//! The program `turner-lab`: see the library for what it does.

use std::process::ExitCode;

fn main() -> ExitCode {
    turner_lab::start()
}
