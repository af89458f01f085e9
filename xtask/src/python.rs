//! `cargo xtask python`: checks the Python code's format, builds the module's wheel, installs it in a fresh environment and
//! runs its tests there.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{root, run};

/// What the tests need besides the module.
const TESTED_WITH: [&str; 5] = ["numpy", "pytest", "pillow", "distributed", "ruff==0.17.6"];

/// The Python that builds, and the tools that it installs.
const MATURIN: &str = "maturin>=1.8,<2";

/// Builds the wheel into `target/wheels`. Returns its path.
pub(crate) fn wheel(python: &Path) -> Result<PathBuf, String> {
    let out = target().join("wheels");
    let _ = std::fs::remove_dir_all(&out);
    run(Command::new(python)
        .args(["-m", "maturin", "build", "--release", "--locked", "--quiet", "--manifest-path"])
        .arg(root().join("crates/turner-python/Cargo.toml"))
        .arg("--out")
        .arg(&out))?;
    let mut found = std::fs::read_dir(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let wheel = found.find_map(|entry| entry.ok().map(|entry| entry.path()));
    wheel.ok_or_else(|| "maturin wrote no wheel".to_owned())
}

/// Builds and tests; `more` are arguments of pytest.
pub(crate) fn test(more: &[&str]) -> Result<(), String> {
    let folder = target().join("python");
    let _ = std::fs::remove_dir_all(&folder);
    let base = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    run(Command::new(base).args(["-m", "venv"]).arg(&folder))?;
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let pip = |packages: &[&str]| {
        let quiet = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        run(Command::new(&python).args(quiet).args(packages))
    };
    pip(&[MATURIN])?;
    let wheel = wheel(&python)?;
    let size = wheel.metadata().map_or(0, |data| data.len());
    println!("{} ({:.1} MB)", wheel.display(), size as f64 / 1e6);
    if size > 20_000_000 {
        return Err("the wheel has more than 20 MB".to_owned());
    }
    let wheel = wheel.to_str().ok_or("the path of the wheel is not UTF-8")?;
    pip(&TESTED_WITH)?;
    let crate_folder = root().join("crates/turner-python");
    let code =
        [crate_folder.clone(), root().join("examples/python"), root().join("scripts/simulate_farm.py")];
    for check in [&["check"][..], &["format", "--check"]] {
        let mut ruff = Command::new(&python);
        ruff.args(["-m", "ruff"]).args(check).args(["--quiet", "--no-cache", "--config"]);
        run(ruff.arg(crate_folder.join("pyproject.toml")).args(&code))?;
    }
    pip(&[wheel])?;
    // From its own folder, where `turner` is the installed module.
    let tests = root().join("crates/turner-python/tests");
    run(Command::new(&python)
        .current_dir(&tests)
        .env("TURNER_ROOT", root())
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "."])
        .args(more))
}

fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}
