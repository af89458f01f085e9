//! `cargo xtask wasm`: compiles turner and turner-io for WebAssembly and runs them there.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{in_memory, root, run};

const TARGET: &str = "wasm32-unknown-unknown";

/// Runs the program in the module and exits with its exit code; a panic is an uncaught error.
const SCRIPT: &str = "const bytes = require('fs').readFileSync(process.argv[1]); \
    WebAssembly.instantiate(bytes, {}).then(({ instance }) => process.exit(instance.exports.main(0, 0)));";

/// Compiles the program `in_memory` and runs it with Node.js if available: its images must be byte-identical to those
/// of the host. `more` goes to cargo.
pub(crate) fn check(more: &[&str]) -> Result<(), String> {
    if more.is_empty() && !is_installed() {
        return Err(format!("the target {TARGET} is not installed: run `rustup target add {TARGET}`"));
    }
    let checksum = in_memory::checksum(1)?;
    run(Command::new(env!("CARGO"))
        .current_dir(root())
        .env("TURNER_CHECKSUM", checksum.to_string())
        .args(["build", "--locked", "--quiet", "-p", "xtask", "--bin", "in_memory", "--target", TARGET])
        .args(more))?;
    println!("turner and turner-io compile for {TARGET}");
    let node = Command::new("node").arg("--version").output();
    if !node.is_ok_and(|node| node.status.success()) {
        println!("Node.js was not found, so they were not run");
        return Ok(());
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let module = target.join(TARGET).join("debug").join("in_memory.wasm");
    run(Command::new("node").args(["-e", SCRIPT]).arg(&module))?;
    println!("images rendered in WebAssembly are byte-identical: {checksum:016x}");
    Ok(())
}

/// Whether the compiler has the target's standard library.
fn is_installed() -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).args(["--print", "target-libdir", "--target", TARGET]).output();
    output.is_ok_and(|output| {
        output.status.success() && Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir()
    })
}
