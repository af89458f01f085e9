//! The program that `cargo xtask wasm` runs: succeeds if the images of `in_memory` are byte-identical to those of the
//! host.
//!
//! `TURNER_CHECKSUM` is read at compile time, because there are no arguments and no output where it runs.
#![forbid(unsafe_code)]

#[path = "../in_memory.rs"]
mod in_memory;

use std::process::ExitCode;

fn main() -> ExitCode {
    let expected = option_env!("TURNER_CHECKSUM").and_then(|text| text.parse().ok());
    // With the calling thread, and with all threads: some platforms have only one.
    let same = [1, 0].into_iter().all(|threads| {
        let found = in_memory::checksum(threads);
        println!("{found:?}");
        found.ok().is_some_and(|found| expected.is_none_or(|expected: u64| found == expected))
    });
    if same { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
