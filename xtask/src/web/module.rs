//! The WebAssembly module: turner-web compiled with threads and SIMD.
//!
//! Threads need a standard library that is compiled with atomics, so it is compiled along (`-Zbuild-std`). Stable compilers
//! do that with the source of their library: `rustup component add rust-src`, or Debian's packages `rustc-web`,
//! `cargo-web`, `rust-web-src` and `rust-web-llvm`.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::target;
use crate::{root, run};

const TARGET: &str = "wasm32-unknown-unknown";

/// Memory is shared and imported: `page/core.js` makes it. 64 MiB at first, as `core.js` says.
const LINKER: [&str; 10] = [
    "--shared-memory",
    "--import-memory",
    "--initial-memory=67108864",
    "--max-memory=4294967296",
    "-zstack-size=4194304",
    "--export=__stack_pointer",
    "--export=__wasm_init_tls",
    "--export=__tls_size",
    "--export=__tls_align",
    "--export=__heap_base",
];

const FEATURES: &str = "+atomics,+bulk-memory,+mutable-globals,+simd128";

/// A compiler with the source of its library.
struct Compiler {
    cargo: PathBuf,
    /// Its folder, which comes first in `PATH`.
    folder: Option<PathBuf>,
}

fn has_source(rustc: &Path) -> bool {
    let output = Command::new(rustc).args(["--print", "sysroot"]).output();
    let Ok(output) = output else { return false };
    let root = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    Path::new(&root).join("lib/rustlib/src/rust/library/Cargo.lock").is_file()
}

fn compiler() -> Result<Compiler, String> {
    if has_source(Path::new("rustc")) {
        return Ok(Compiler { cargo: PathBuf::from(env!("CARGO")), folder: None });
    }
    let debian = Path::new("/usr/bin");
    if has_source(&debian.join("rustc")) && debian.join("cargo").is_file() {
        return Ok(Compiler { cargo: debian.join("cargo"), folder: Some(debian.to_owned()) });
    }
    Err("the source of the standard library is not installed: run `rustup component add rust-src`, or on \
         Debian `apt-get install rustc-web cargo-web rust-web-src rust-web-llvm lld-22`"
        .to_owned())
}

/// Builds the module; returns its path.
pub(super) fn build(quick: bool) -> Result<PathBuf, String> {
    let compiler = compiler()?;
    let folder = target().join("wasm");
    let linked = LINKER.iter().map(|argument| format!("-C link-arg={argument}"));
    let flags: Vec<String> = ["-C strip=symbols".to_owned(), format!("-C target-feature={FEATURES}")]
        .into_iter()
        .chain(linked)
        .collect();
    let mut cargo = Command::new(&compiler.cargo);
    cargo
        .current_dir(root())
        // Options of the host's build do not apply.
        .env_remove("CARGO")
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("RUSTFLAGS")
        .env("RUSTC_BOOTSTRAP", "1")
        .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", flags.join(" "))
        .args([
            "rustc",
            "--release",
            "--locked",
            "--quiet",
            "-p",
            "turner-web",
            "--lib",
            "--crate-type",
            "cdylib",
        ])
        .args(["--target", TARGET, "-Zbuild-std=std,panic_abort", "--target-dir"])
        .arg(&folder);
    if quick {
        for name in ["turner", "turner-bvh"] {
            cargo.arg("--config").arg(format!("profile.release.package.{name}.codegen-units=16"));
        }
    }
    if let Some(first) = &compiler.folder {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let all = std::iter::once(first.clone()).chain(std::env::split_paths(&path));
        cargo.env("PATH", std::env::join_paths(all).map_err(|e| e.to_string())?);
    }
    run(&mut cargo)?;
    Ok(folder.join(TARGET).join("release").join("turner_web.wasm"))
}
