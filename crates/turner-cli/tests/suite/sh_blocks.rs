//! Commands in documents.

use std::path::{Path, PathBuf};

/// The root of the sources.
pub(crate) fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// All documents that have commands.
pub(crate) fn documents() -> Vec<PathBuf> {
    let docs = std::fs::read_dir(root().join("docs")).unwrap().map(|e| e.unwrap().path());
    let mut files: Vec<_> = docs.filter(|p| p.extension().is_some_and(|e| e == "md")).collect();
    files.sort();
    let more =
        ["README.md", "scenes/peers/README.md", "scenes/showcase/README.md", "crates/turner-bvh/README.md"];
    files.extend(more.map(|f| root().join(f)));
    files
}

/// The lines of the ```sh and ```console blocks, with their numbers.
pub(crate) fn lines(text: &str) -> Vec<(usize, String)> {
    let mut out = Vec::new();
    let mut block: Option<bool> = None;
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        match (line.strip_prefix("```"), block) {
            (Some(language), None) => block = Some(["sh", "console"].contains(&language)),
            (Some(_), Some(_)) => block = None,
            (None, Some(true)) => out.push((i + 1, line.trim_start_matches("$ ").to_owned())),
            (None, _) => {}
        }
    }
    out
}
