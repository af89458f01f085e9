//! `cargo xtask python`: builds the module's wheel, checks its metadata and the Python code's format, installs it in a fresh
//! environment and runs its tests there. `--also PYTHON` runs them in an environment of that interpreter, too.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{root, run};

/// What the tests need besides the module.
const TESTED_WITH: [&str; 7] =
    ["numpy", "pytest", "pillow", "distributed", "nbclient", "ipykernel", "ipywidgets"];

/// What checks the code and the wheel.
const CHECKED_WITH: [&str; 2] = ["ruff==0.17.6", "twine"];

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

/// Builds the wheel and tests it. `more`: `--also PYTHON` tests it with a further interpreter, as often as given; all other
/// arguments are those of pytest.
pub(crate) fn test(more: &[&str]) -> Result<(), String> {
    let (also, more) = interpreters(more)?;
    let base = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let python = Environment::new(Path::new(&base), "python")?;
    python.install(&[MATURIN])?;
    let wheel = wheel(&python.0)?;
    let size = wheel.metadata().map_or(0, |data| data.len());
    println!("{} ({:.1} MB)", wheel.display(), size as f64 / 1e6);
    if size > 20_000_000 {
        return Err("the wheel has more than 20 MB".to_owned());
    }
    let wheel = wheel.to_str().ok_or("the path of the wheel is not UTF-8")?;
    python.install(&CHECKED_WITH)?;
    python.check(wheel)?;
    python.test(wheel, &more)?;
    for (i, other) in also.into_iter().enumerate() {
        println!("{other}");
        Environment::new(Path::new(other), &format!("python-{i}"))?.test(wheel, &more)?;
    }
    Ok(())
}

/// The interpreters after `--also`, and the other arguments.
fn interpreters<'a>(words: &[&'a str]) -> Result<(Vec<&'a str>, Vec<&'a str>), String> {
    let (mut also, mut more) = (Vec::new(), Vec::new());
    let mut words = words.iter();
    while let Some(&word) = words.next() {
        if word == "--also" {
            also.push(*words.next().ok_or("--also needs an interpreter, such as python3.13")?);
        } else {
            more.push(word);
        }
    }
    Ok((also, more))
}

/// A fresh environment, by its interpreter.
struct Environment(PathBuf);

impl Environment {
    /// An environment of the interpreter `base`, in a folder of the target folder.
    fn new(base: &Path, folder: &str) -> Result<Environment, String> {
        let folder = target().join(folder);
        let _ = std::fs::remove_dir_all(&folder);
        run(Command::new(base).args(["-m", "venv"]).arg(&folder))?;
        Ok(Environment(folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })))
    }

    fn install(&self, packages: &[&str]) -> Result<(), String> {
        let quiet = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        run(Command::new(&self.0).args(quiet).args(packages))
    }

    /// Checks the format of the code and the wheel's metadata.
    fn check(&self, wheel: &str) -> Result<(), String> {
        let crate_folder = root().join("crates/turner-python");
        let code =
            [crate_folder.clone(), root().join("examples/python"), root().join("scripts/simulate_farm.py")];
        for check in [&["check"][..], &["format", "--check"]] {
            let mut ruff = Command::new(&self.0);
            ruff.args(["-m", "ruff"]).args(check).args(["--quiet", "--no-cache", "--config"]);
            run(ruff.arg(crate_folder.join("pyproject.toml")).args(&code))?;
        }
        run(Command::new(&self.0).args(["-m", "twine", "check", "--strict", wheel]))
    }

    /// Installs the wheel and runs its tests from their own folder, where `turner` is the installed module.
    fn test(&self, wheel: &str, more: &[&str]) -> Result<(), String> {
        self.install(&TESTED_WITH)?;
        self.install(&[wheel])?;
        run(Command::new(&self.0)
            .current_dir(root().join("crates/turner-python/tests"))
            .env("TURNER_ROOT", root())
            .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "."])
            .args(more))
    }
}

fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

#[cfg(test)]
mod tests {
    #[test]
    fn further_interpreters_are_told_from_arguments_of_pytest() {
        let words = ["-k", "render", "--also", "python3.13", "-x", "--also", "python3.10"];
        let (also, more) = super::interpreters(&words).unwrap();
        assert_eq!((also, more), (vec!["python3.13", "python3.10"], vec!["-k", "render", "-x"]));
        assert!(super::interpreters(&["--also"]).is_err());
    }
}
