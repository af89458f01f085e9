//! Installs other renderers from PyPI in a Python environment of their own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use turner::schema::{ErrorCode, SceneError};
use turner_cli::failure::Failure;

use super::PeerKind;

const MITSUBA: &[&str] = &["mitsuba==3.9.1", "numpy"];
/// Each Blender package supports one version of Python.
const CYCLES: &[&str] = &["bpy==5.0.1", "numpy"];

/// Turner's folder of this name in the user's cache.
pub(crate) fn cache(name: &str) -> PathBuf {
    let of = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let cache = of("XDG_CACHE_HOME").or_else(|| of("LOCALAPPDATA"));
    let cache = cache.or_else(|| Some(of("HOME")?.join(".cache")));
    cache.unwrap_or_else(std::env::temp_dir).join("turner").join(name)
}

/// The environment's folder.
fn folder() -> PathBuf {
    cache("peers")
}

fn python_in(folder: &Path) -> PathBuf {
    if cfg!(windows) { folder.join("Scripts").join("python.exe") } else { folder.join("bin").join("python") }
}

/// The environment's Python if it exists, else the system's.
pub(crate) fn python() -> PathBuf {
    let own = python_in(&folder());
    if own.is_file() { own } else { PathBuf::from("python3") }
}

/// Creates the environment with the packages that `peers` need. `base` is the Python to create it with, 3.11 by
/// default. Returns the environment's Python.
pub(crate) fn install(base: Option<&Path>, peers: &[PeerKind]) -> Result<PathBuf, Failure> {
    let folder = folder();
    let python = python_in(&folder);
    if !python.is_file() {
        let base = base.unwrap_or(Path::new("python3.11"));
        run(
            Command::new(base).args(["-m", "venv"]).arg(&folder),
            "pass a Python with --python: Cycles needs version 3.11",
        )?;
    }
    let cycles = peers.contains(&PeerKind::Cycles);
    let mitsuba = peers.iter().any(|p| *p != PeerKind::Cycles);
    // In one call, so that pip finds versions that suit all packages.
    let packages: Vec<&str> = [mitsuba.then_some(MITSUBA), cycles.then_some(CYCLES)]
        .into_iter()
        .flatten()
        .flatten()
        .copied()
        .collect();
    let help = if cycles {
        "Cycles (bpy 5.0.1) needs Python 3.11; omit it with --peers mitsuba-llvm,mitsuba-scalar"
    } else {
        "pass another Python with --python: Mitsuba 3.9.1 has no package for each version"
    };
    let pip = ["-m", "pip", "install", "--disable-pip-version-check"];
    run(Command::new(&python).args(pip).args(packages), help)?;
    Ok(python)
}

/// Runs a command; its output goes to standard error.
fn run(command: &mut Command, help: &str) -> Result<(), Failure> {
    let shown = format!("{command:?}");
    let what = match command.stdin(Stdio::null()).stdout(std::io::stderr()).status() {
        Ok(status) if status.success() => return Ok(()),
        Ok(status) => format!("{shown} failed: {status}"),
        Err(error) => format!("{shown} cannot be run: {error}"),
    };
    Err(Failure::new(SceneError::new(ErrorCode::File, what).help(help.to_owned())))
}
