//! `cargo xtask web`: the page as one static folder, `target/web`.
//!
//! ```text
//! crates/turner-web ──wasm.rs──► turner.wasm ─┐
//! crates/turner-web/page ─────────────────────┼─► target/web ──test──► browsers under drivers
//! scenes that the gallery reads, pictures ────┘
//! ```

mod expected;
mod module;
mod pictures;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use turner_live::document::STARTS;

use crate::{root, run};

/// The largest download before the first picture, compressed: 4 MB.
const MOST_COMPRESSED: u64 = 4_000_000;

/// The driver of browsers for the tests: later versions ask for more than Firefox ESR answers.
const PLAYWRIGHT: &str = "playwright-core@1.59.0";

/// The folder for build outputs.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// Builds the folder. `more` may hold `--quick`, for a module that compiles faster and is larger, and `--test`.
pub(crate) fn build(more: &[&str]) -> Result<(), String> {
    if let Some(unknown) = more.iter().find(|word| !["--quick", "--test"].contains(word)) {
        return Err(format!("{unknown}: expected --quick or --test"));
    }
    let quick = more.contains(&"--quick");
    let out = target().join("web");
    let _ = std::fs::remove_dir_all(&out);
    copy(&root().join("crates/turner-web/page"), &out)?;
    let module = module::build(quick)?;
    let wasm = out.join("turner.wasm");
    std::fs::copy(&module, &wasm).map_err(|e| format!("{}: {e}", module.display()))?;
    for start in STARTS {
        for (name, _) in start.files {
            let from = root().join("scenes").join(start.folder).join(name);
            copy_file(&from, &out.join("scenes").join(start.folder).join(name))?;
        }
    }
    pictures::make(&out.join("images"))?;
    let files = files_below(&out, &out)?;
    let version = write_service_worker(&out, &files)?;
    let first: u64 = first_download(&out)?;
    println!("{}: {} files, version {version}", out.display(), files.len());
    println!("download before the first picture, gzip: {:.2} MB", first as f64 / 1e6);
    if first > MOST_COMPRESSED && !quick {
        return Err(format!("the first download has {first} bytes; expected at most {MOST_COMPRESSED}"));
    }
    if more.contains(&"--test") { test(&out) } else { Ok(()) }
}

/// Runs the tests of the npm package in Node.js, and those of the page in Chromium and in other browsers that are installed.
fn test(out: &Path) -> Result<(), String> {
    let package = root().join("crates/turner-web/npm/test/render.mjs");
    run(Command::new("node").env("TURNER_WASM", out.join("turner.wasm")).arg("--test").arg(package))?;
    let modules = target().join("web-tests");
    std::fs::create_dir_all(&modules).map_err(|e| format!("{}: {e}", modules.display()))?;
    if !modules.join("node_modules/playwright-core").is_dir() {
        let quiet = ["install", "--silent", "--no-save", "--no-audit", "--no-fund", "--prefix"];
        run(Command::new("npm").args(quiet).arg(&modules).arg(PLAYWRIGHT))?;
    }
    let expected = modules.join("expected");
    expected::write(&expected)?;
    let tests = root().join("crates/turner-web/tests/browser/run.mjs");
    let modules = modules.join("node_modules");
    run(Command::new("node").env("TURNER_EXPECTED", expected).arg(tests).arg(out).arg(modules))
}

/// Writes `sw.js` with the list of files and a version that changes with their contents.
fn write_service_worker(out: &Path, files: &[String]) -> Result<String, String> {
    // FNV-1a.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut listed = String::new();
    for name in files.iter().filter(|name| *name != "sw.js") {
        let bytes = std::fs::read(out.join(name)).map_err(|e| format!("{name}: {e}"))?;
        let all = name.bytes().chain(bytes);
        hash = all.fold(hash, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        let _ = writeln!(listed, "  \"{name}\",");
    }
    let version = format!("{hash:016x}");
    let path = out.join("sw.js");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let text = text.replace("const FILES = [];", &format!("const FILES = [\n{listed}];"));
    let text = text.replace("const VERSION = \"\";", &format!("const VERSION = \"{version}\";"));
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(version)
}

/// Bytes of what the first picture needs, compressed by gzip.
fn first_download(out: &Path) -> Result<u64, String> {
    let names = files_below(out, out)?;
    let needed = names.iter().filter(|name| !name.starts_with("images/") && !name.starts_with("scenes/"));
    let mut total = 0;
    for name in needed {
        let bytes = std::fs::read(out.join(name)).map_err(|e| format!("{name}: {e}"))?;
        total += miniz_oxide::deflate::compress_to_vec(&bytes, 9).len() as u64 + 18;
    }
    Ok(total)
}

/// The files below a folder, as paths from `top` with `/`, sorted.
fn files_below(folder: &Path, top: &Path) -> Result<Vec<String>, String> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))? {
        let path = entry.map_err(|e| e.to_string())?.path();
        if path.is_dir() {
            out.extend(files_below(&path, top)?);
        } else if let Ok(name) = path.strip_prefix(top) {
            out.push(name.to_string_lossy().replace('\\', "/"));
        }
    }
    out.sort();
    Ok(out)
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    for name in files_below(from, from)? {
        copy_file(&from.join(&name), &to.join(&name))?;
    }
    Ok(())
}

fn copy_file(from: &Path, to: &Path) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("{}: {e}", from.display());
    to.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(failed)?;
    std::fs::copy(from, to).map(drop).map_err(failed)
}
