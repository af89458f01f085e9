//! The rooms of the crate, from the bottom up, and what each may import. Imports run one way only: a new import
//! upwards fails here, with file and line.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Each room with the rooms that it may import, in addition to those that these may import.
const ROOMS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("choice", &[]),
    ("color", &["math", "choice"]),
    ("image", &["math"]),
    ("sampler", &["math"]),
    ("filter", &["sampler", "choice"]),
    // The language of the scene format: values, keys, errors, limits. It does not depend on the families.
    ("schema", &["color", "image"]),
    // Keyframes, and what moves between two placements.
    ("animation", &["schema"]),
    ("shape", &["schema", "sampler"]),
    // The surface at a hit: plain data.
    ("interaction", &["shape"]),
    // The other families; each contract is at the top of the folder.
    ("texture", &["interaction"]),
    ("bsdf", &["schema", "sampler"]),
    ("medium", &["texture"]),
    ("material", &["bsdf", "medium"]),
    ("light", &["material", "animation"]),
    ("film", &["schema", "filter"]),
    ("denoise", &["film"]),
    ("camera", &["film", "sampler"]),
    // Scene, camera samples, light transport.
    ("scene", &["light"]),
    ("view", &["scene", "camera"]),
    ("integrator", &["view"]),
    // The descriptions of all families: reading and writing.
    ("description", &["integrator"]),
    ("prepare", &["description"]),
    ("render", &["prepare", "denoise"]),
    // Why a pixel has its colour: a sample as a tree of rays.
    ("explain", &["render"]),
    ("preview", &["integrator", "film"]),
    // Tools that check scenes and pictures; nothing below imports them.
    ("compare", &["film"]),
    ("lint", &["prepare"]),
    ("doctor", &["render", "lint"]),
    ("testing", &["render", "compare"]),
];

/// Limits: files and lines of a room without its tests, lines of a file.
const MOST_FILES: usize = 60;
const MOST_LINES: usize = 8000;
const MOST_LINES_OF_A_FILE: usize = 500;

fn files_below(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

/// Whether a file contains only tests.
fn is_test(path: &Path) -> bool {
    let name = path.file_stem().unwrap().to_string_lossy();
    let in_folder = path.components().any(|c| c.as_os_str() == "tests");
    in_folder || name.ends_with("tests") || name == "testing"
}

/// The lines of a file that are compiled outside tests, without comments, with their line numbers.
fn code(text: &str) -> Vec<(usize, &str)> {
    let mut out = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((i, line)) = lines.next() {
        if line.trim() == "#[cfg(test)]" {
            // One item follows: a line, or a module or function that ends at a brace in the same column.
            let close = format!("{}}}", " ".repeat(line.len() - line.trim_start().len()));
            let item = lines.by_ref().find(|(_, l)| !l.trim_start().starts_with("#["));
            if item.is_some_and(|(_, l)| !l.trim_end().ends_with(';')) {
                let _ = lines.by_ref().find(|(_, l)| *l == close);
            }
            continue;
        }
        out.push((i + 1, line.split("//").next().unwrap_or_default()));
    }
    out
}

/// The rooms that a line names after `crate::`.
fn named(line: &str) -> Vec<&str> {
    let mut out = Vec::new();
    for (at, _) in line.match_indices("crate::") {
        let rest = &line[at + "crate::".len()..];
        if let Some(group) = rest.strip_prefix('{') {
            out.extend(group.split(',').map(|part| word(part.trim())));
        } else {
            out.push(word(rest));
        }
    }
    out
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(text.len());
    &text[..end]
}

/// All rooms that a room may import.
fn allowed<'a>(rooms: &BTreeMap<&'a str, &'a [&'a str]>, room: &'a str, out: &mut Vec<&'a str>) {
    if !out.contains(&room) {
        out.push(room);
        for below in rooms.get(room).copied().unwrap_or_default() {
            allowed(rooms, below, out);
        }
    }
}

#[test]
fn imports_run_one_way() {
    let rooms: BTreeMap<&str, &[&str]> = ROOMS.iter().copied().collect();
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut offenders = Vec::new();
    for entry in fs::read_dir(&src).unwrap() {
        let path = entry.unwrap().path();
        let room = path.file_stem().unwrap().to_string_lossy().into_owned();
        if room == "lib" {
            continue;
        }
        let Some((room, _)) = rooms.get_key_value(room.as_str()) else {
            panic!("{room} is no room: give it a line in this table, and say what it may import");
        };
        let mut may = Vec::new();
        allowed(&rooms, room, &mut may);
        let mut files = Vec::new();
        if path.is_dir() {
            files_below(&path, &mut files)
        } else {
            files.push(path.clone())
        }
        for file in files.iter().filter(|f| !is_test(f)) {
            for (number, line) in code(&fs::read_to_string(file).unwrap()) {
                for other in named(line) {
                    // Re-exports at the crate root are for other crates: inside, they would hide the room.
                    if !other.is_empty() && !may.contains(&other) {
                        let shown = file.strip_prefix(&src).unwrap().display();
                        offenders.push(format!("{shown}:{number}: {room} imports {other}: {}", line.trim()));
                    }
                }
            }
        }
    }
    offenders.sort();
    assert!(offenders.is_empty(), "imports that run upwards:\n{}", offenders.join("\n"));
}

#[test]
fn no_room_is_above_itself() {
    let rooms: BTreeMap<&str, &[&str]> = ROOMS.iter().copied().collect();
    for (room, below) in ROOMS {
        for other in *below {
            let mut reached = Vec::new();
            allowed(&rooms, other, &mut reached);
            assert!(!reached.contains(room), "{room} and {other} may import each other");
        }
    }
}

#[test]
fn rooms_and_files_stay_small() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    // The path tracer is a room within a room and counts separately, and so do its light paths, the solids, the curves and
    // text.
    let inner = ["integrator/path", "integrator/path/caustics", "shape/solid", "shape/curves", "shape/text"]
        .map(Path::new);
    for room in ROOMS.iter().map(|(room, _)| Path::new(room)).chain(inner) {
        let mut files = Vec::new();
        if src.join(room).is_dir() {
            files_below(&src.join(room), &mut files);
        }
        let others = inner.iter().filter(|other| other.starts_with(room) && **other != room);
        files.retain(|f| others.clone().all(|other| !f.starts_with(src.join(other))));
        let room = room.display();
        let lengths: Vec<usize> =
            files.iter().map(|f| fs::read_to_string(f).unwrap().lines().count()).collect();
        // Tests do not count towards the size of a room.
        let own = files.iter().zip(&lengths).filter(|(f, _)| !is_test(f));
        let (count, lines) = own.fold((0, 0), |(count, lines), (_, n)| (count + 1, lines + n));
        if count > MOST_FILES || lines > MOST_LINES {
            wrong.push(format!("{room}: {count} files, {lines} lines"));
        }
        let long = files.iter().zip(&lengths).filter(|(_, n)| **n > MOST_LINES_OF_A_FILE);
        wrong.extend(long.map(|(f, n)| format!("{}: {n} lines", f.strip_prefix(&src).unwrap().display())));
    }
    assert!(wrong.is_empty(), "more than {MOST_FILES} files, {MOST_LINES} lines:\n{}", wrong.join("\n"));
}

/// The first command line option (`--name`) in the texts of a line of code. Options of other programs are
/// allowed.
fn options_in(line: &str) -> Option<&str> {
    let line = line.trim_start();
    if line.starts_with("//") || line.contains("pbrt --upgrade") {
        return None;
    }
    let starts = |i: usize| {
        let before = line.get(..i)?.chars().next_back().unwrap_or(' ');
        let after = line.get(i + 2..)?.chars().next()?;
        if " \"`'(".contains(before) && after.is_ascii_lowercase() { line.get(i..) } else { None }
    };
    line.match_indices("--").find_map(|(i, _)| starts(i))
}

/// The library names remedies as scene keys, limits and `Remedy` values; only the command line knows its options.
#[test]
fn no_text_of_the_library_speaks_of_options() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut wrong = Vec::new();
    for name in ["turner", "turner-io"] {
        let mut files = Vec::new();
        files_below(&crates.join(name).join("src"), &mut files);
        assert!(files.len() > 50, "{name}: {}", files.len());
        for path in files {
            let text = fs::read_to_string(&path).unwrap();
            for (i, line) in text.lines().enumerate() {
                if let Some(option) = options_in(line) {
                    wrong.push(format!("{}:{}: {option}", path.display(), i + 1));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for line in ["help(\"raise --max-memory\")", "\"`--caustics off`\"", "\"--define {}\"", "(\"(--force)\")"]
    {
        assert!(options_in(line).is_some(), "{line}");
    }
    for line in ["a -- b", "/// `--strict`", "\"----\"", "\"a--b\""] {
        assert_eq!(options_in(line), None, "{line}");
    }
}
