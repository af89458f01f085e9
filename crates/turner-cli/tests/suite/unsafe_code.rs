//! `unsafe` occurs only in turner-bvh, in the crates that load libraries of other programs, and in a few files of the Python
//! module and of what WebAssembly needs.

use std::path::{Path, PathBuf};

/// All Rust files in a folder and its subfolders.
fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
        if entry.is_dir() {
            sources(&entry, out);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            out.push(entry);
        }
    }
}

/// Whether a line of code, without comments and strings, has the keyword.
fn is_unsafe(line: &str) -> bool {
    let code = line.split("//").next().unwrap_or_default();
    let outside_strings = code.split('"').step_by(2).collect::<Vec<_>>().join("\"");
    outside_strings.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == "unsafe")
}

/// Crates with unsafe code in single files.
const FILES: [(&str, &[&str]); 3] = [
    // The macros of its bindings write unsafe code of their own, so the crate cannot forbid it.
    ("turner-python", &["interpreter.rs", "mesh_views.rs"]),
    // Tasks that borrow, for the workers of a page; the page's clock.
    ("turner-host", &["page_clock.rs", "pool.rs"]),
    // The exports of the WebAssembly module.
    ("turner-web", &["abi.rs"]),
];

#[test]
fn unsafe_code_stands_in_few_places() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut looked_at = Vec::new();
    for entry in std::fs::read_dir(crates).unwrap().map(|e| e.unwrap().path()) {
        let name = entry.file_name().unwrap().to_string_lossy().into_owned();
        if !entry.join("Cargo.toml").is_file()
            || ["turner-bvh", "turner-embree", "turner-oidn"].contains(&&*name)
        {
            continue;
        }
        if let Some((_, allowed)) = FILES.iter().find(|(own, _)| *own == name) {
            let mut files = Vec::new();
            sources(&entry, &mut files);
            let has = |file: &PathBuf| std::fs::read_to_string(file).unwrap().lines().any(is_unsafe);
            let named = |file: PathBuf| file.file_name().unwrap().to_string_lossy().into_owned();
            let mut found: Vec<String> = files.into_iter().filter(has).map(named).collect();
            found.sort();
            assert_eq!(found, *allowed, "{name}");
            continue;
        }
        let library = std::fs::read_to_string(entry.join("src/lib.rs")).unwrap();
        assert!(library.contains("#![forbid(unsafe_code)]"), "{name} does not forbid it");
        let mut files = Vec::new();
        sources(&entry, &mut files);
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let found = text.lines().position(is_unsafe);
            assert_eq!(found, None, "{} line {:?}", file.display(), found.map(|n| n + 1));
        }
        looked_at.push(name);
    }
    assert!(
        ["turner", "turner-io", "turner-cli"].iter().all(|n| looked_at.iter().any(|l| l == n)),
        "{looked_at:?}"
    );
    assert!(is_unsafe("let a = unsafe { b() };") && !is_unsafe("forbid(unsafe_code) // unsafe"));
}
