//! Which scenes are measured, and their names.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use turner::schema::{ErrorCode, SceneError};
use turner_cli::failure::Failure;

/// A file and the name that tables show.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SceneFile {
    pub(super) name: String,
    pub(super) path: PathBuf,
}

/// The files among `given`, and of each folder its XML files and the `scene.xml` of each of its folders.
pub(super) fn find(given: &[PathBuf]) -> Result<Vec<SceneFile>, Failure> {
    let mut paths = Vec::new();
    for path in given {
        if path.is_dir() {
            let found = in_folder(path)
                .map_err(|e| usage(&format!("{}: the folder cannot be read: {e}", path.display())))?;
            if found.is_empty() {
                return Err(usage(&format!(
                    "{}: there is no XML file in it, and no scene.xml in its folders",
                    path.display()
                )));
            }
            paths.extend(found);
        } else if path.is_file() {
            paths.push(path.clone());
        } else {
            return Err(usage(&format!("{}: there is no such file or folder", path.display())));
        }
    }
    Ok(named(paths))
}

fn usage(message: &str) -> Failure {
    let error = SceneError::new(ErrorCode::File, message);
    Failure::usage(
        error.help("name Mitsuba's XML files, or a folder with such files or with folders of a scene.xml"),
    )
}

fn in_folder(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let inner = path.join("scene.xml");
        if inner.is_file() {
            found.push(inner);
        } else if path.is_file() && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xml")) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// A name for each file: its own without the extension; that of its folder for `scene.xml` and where several files have
/// the same name; both if that is not unique either.
fn named(paths: Vec<PathBuf>) -> Vec<SceneFile> {
    let text = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let stem = |path: &Path| text(path.file_stem());
    let folder = |path: &Path| {
        // `scene.xml` alone is in the current folder.
        let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        text(full.parent().and_then(Path::file_name))
    };
    let stems = counts(paths.iter().map(|p| stem(p)));
    let short = |path: &Path| {
        let own = stem(path);
        let shared = own == "scene" || stems.get(&own).is_some_and(|n| *n > 1);
        Some(folder(path)).filter(|f| shared && !f.is_empty()).unwrap_or(own)
    };
    let shorts = counts(paths.iter().map(|p| short(p)));
    let name = |path: &Path| match short(path) {
        name if shorts.get(&name).is_some_and(|n| *n > 1) => format!("{}/{}", folder(path), stem(path)),
        name => name,
    };
    let names: Vec<String> = paths.iter().map(|p| name(p)).collect();
    names.into_iter().zip(paths).map(|(name, path)| SceneFile { name, path }).collect()
}

fn counts(names: impl Iterator<Item = String>) -> HashMap<String, usize> {
    let mut counts = HashMap::new();
    for name in names {
        *counts.entry(name).or_insert(0) += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(paths: &[&str]) -> Vec<String> {
        named(paths.iter().map(PathBuf::from).collect()).into_iter().map(|f| f.name).collect()
    }

    #[test]
    fn names_are_short_and_different() {
        assert_eq!(names(&["a/cbox.xml", "a/kitchen/scene.xml"]), ["cbox", "kitchen"]);
        assert_eq!(names(&["m/cbox/s.xml", "m/veach/s.xml", "m/one.xml"]), ["cbox", "veach", "one"]);
        assert_eq!(names(&["a/kitchen/scene.xml", "b/kitchen.xml"]), ["kitchen/scene", "b/kitchen"]);
    }

    #[test]
    fn folders_have_scenes_as_files_and_in_folders() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["b", "c", "empty"] {
            std::fs::create_dir(path(name)).unwrap();
        }
        for name in ["z.XML", "a.xml", "notes.txt", "b/scene.xml", "b/part.xml", "c/other.xml"] {
            std::fs::write(path(name), "").unwrap();
        }
        let found = find(&[folder.path().to_owned()]).unwrap();
        let names: Vec<&str> = found.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "z"]);
        let one = find(&[path("c/other.xml")]).unwrap();
        assert_eq!(one, [SceneFile { name: "other".into(), path: path("c/other.xml") }]);
        for (wrong, why) in [("empty", "no XML file"), ("d", "no such file")] {
            let failure = find(&[path(wrong)]).unwrap_err();
            assert!(failure.errors[0].message.contains(why), "{failure:?}");
            assert_eq!(failure.exit, turner_cli::failure::USAGE);
        }
    }
}
