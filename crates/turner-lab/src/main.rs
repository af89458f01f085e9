//! The program `turner-lab`: see the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    turner_lab::start()
}
