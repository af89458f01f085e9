//! Commands in documents.

use std::path::{Path, PathBuf};

/// The root of the sources.
pub(crate) fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// All documents with commands.
pub(crate) fn documents() -> Vec<PathBuf> {
    let mut files = markdown_below(&root().join("docs"));
    files.sort();
    let more =
        ["README.md", "scenes/peers/README.md", "scenes/showcase/README.md", "crates/turner-bvh/README.md"];
    files.extend(more.map(|f| root().join(f)));
    files
}

/// The Markdown files in a folder and its subfolders.
pub(crate) fn markdown_below(folder: &Path) -> Vec<PathBuf> {
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

/// The lines of the ```sh and ```console blocks, with their line numbers.
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
