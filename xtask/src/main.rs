//! Maintenance tasks: `cargo xtask docs` makes the images of the documentation from scenes in the repository.
//!
//! ```text
//! cargo xtask docs              all images
//! cargo xtask docs tutorial     the images whose name begins with "tutorial"
//! cargo xtask list              their names and commands
//! cargo xtask words             finds phrases that documents, comments and messages do not use
//! cargo xtask python            builds the Python module's wheel and runs its tests; --also PYTHON runs them with a further
//!                               interpreter; other arguments go to pytest
//! cargo xtask web               the page as a static folder; --test runs its tests in browsers
//! cargo xtask wasm              compiles for WebAssembly and renders there; further arguments go to cargo
//! ```
#![forbid(unsafe_code)]

mod in_memory;
mod layers;
mod pictures;
mod python;
mod sheet;
mod wasm;
mod web;
mod words;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use pictures::{PICTURES, Picture};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let result = match words.as_slice() {
        ["docs", names @ ..] => docs(names),
        ["list"] => {
            for picture in PICTURES {
                println!("{}: {}", picture.file, picture.about());
            }
            Ok(())
        }
        ["words"] => words::check(root()).map(|files| println!("{files} files use the words of the field")),
        ["python", more @ ..] => python::test(more),
        ["wasm", more @ ..] => wasm::check(more),
        ["web", more @ ..] => web::build(more),
        _ => Err("usage: cargo xtask docs [NAME…] | cargo xtask list | cargo xtask words | cargo xtask python [--also PYTHON]… [PYTEST-OPTION…] | cargo xtask web [--quick] [--test] | cargo xtask wasm [CARGO-OPTION…]"
            .to_owned()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The root of the sources.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

fn docs(names: &[&str]) -> Result<(), String> {
    let chosen: Vec<&Picture> =
        PICTURES.iter().filter(|p| names.is_empty() || names.iter().any(|n| p.file.starts_with(n))).collect();
    if chosen.is_empty() {
        return Err(format!("no image's name begins with {}: see cargo xtask list", names.join(" or ")));
    }
    run(Command::new(env!("CARGO")).current_dir(root()).args([
        "build",
        "--release",
        "--quiet",
        "--locked",
        "-p",
        "turner-cli",
    ]))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let turner = target.join("release").join(format!("turner{}", std::env::consts::EXE_SUFFIX));
    for picture in chosen {
        println!("{}", picture.file);
        picture.make(&turner, &root().join("docs/images").join(picture.file))?;
    }
    Ok(())
}

/// Runs a program to its end.
fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("{:?} cannot be run: {e}", command.get_program()))?;
    status.success().then_some(()).ok_or_else(|| format!("{command:?} failed: {status}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_in_memory_are_the_same_with_any_number_of_threads() {
        assert_eq!(in_memory::checksum(1).unwrap(), in_memory::checksum(3).unwrap());
    }

    /// Images that this program does not make. They need other renderers or models that are not in the repository. Those of
    /// Turner Studio are screenshots by `scripts/studio-end-to-end.sh`; that of the page is one of Chromium's.
    const MADE_ELSEWHERE: [&str; 13] = [
        "error-over-time.svg",
        "gltf-test-models.jpg",
        "bunny.jpg",
        "models-compared.jpg",
        "blender.jpg",
        "python-room.jpg",
        "python-dataset.jpg",
        "python-cluster.jpg",
        "web-page.jpg",
        "studio-window.jpg",
        "studio-rays.jpg",
        "studio-002.jpg",
        "studio-effects.jpg",
    ];

    fn markdown_below(folder: &Path) -> Vec<PathBuf> {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                files.extend(markdown_below(&path));
            } else if path.extension().is_some_and(|e| e == "md") {
                files.push(path);
            }
        }
        files
    }

    fn images() -> Vec<(String, u64)> {
        let entries = std::fs::read_dir(root().join("docs/images")).unwrap();
        let of = |e: std::fs::DirEntry| (e.file_name().into_string().unwrap(), e.metadata().unwrap().len());
        entries.map(|e| of(e.unwrap())).collect()
    }

    #[test]
    fn every_picture_has_its_command_and_every_command_its_picture() {
        let images = images();
        for (name, _) in &images {
            let made = PICTURES.iter().any(|p| p.file == name);
            assert!(made != MADE_ELSEWHERE.contains(&name.as_str()), "{name}");
        }
        for picture in PICTURES {
            assert!(
                images.iter().any(|(name, _)| name == picture.file),
                "{}: cargo xtask docs",
                picture.file
            );
        }
    }

    #[test]
    fn documents_link_to_existing_files() {
        let mut shown = String::new();
        let others = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"];
        let others = others.map(|name| root().join(name));
        for path in markdown_below(&root().join("docs")).into_iter().chain(others) {
            let text = std::fs::read_to_string(&path).unwrap();
            for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
                let file = link.split('#').next().unwrap();
                if file.is_empty() || file.contains("://") {
                    continue;
                }
                let found = path.parent().unwrap().join(file);
                assert!(found.exists(), "{}: {link}", path.display());
            }
            shown += &text;
        }
        for (name, _) in images() {
            assert!(shown.contains(&format!("images/{name}")), "no document shows {name}");
        }
    }

    #[test]
    fn pictures_are_small() {
        let images = images();
        let total: u64 = images.iter().map(|(_, size)| size).sum();
        assert!(total < 6_000_000, "{total} bytes in total");
    }
}
