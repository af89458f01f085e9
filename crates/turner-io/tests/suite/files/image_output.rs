//! A file appears complete or not at all, and an unwritable path is rejected in advance.

use std::fs;
use std::path::Path;

use turner_io::image::{OutputError, OutputFile};

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn commit_writes_and_replaces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    OutputFile::create(&path).unwrap().commit(b"one").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"one");
    OutputFile::create(&path).unwrap().commit(b"two").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"two");
    assert_eq!(names(folder.path()), ["a.png"]);
}

#[test]
fn dropping_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    drop(OutputFile::create(&path).unwrap());
    drop(OutputFile::create(folder.path().join("new.png")).unwrap());
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["a.png"]);
}

#[test]
fn wrong_paths_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| OutputFile::create(folder.path().join(name)).unwrap_err();
    let error = at("missing/a.png");
    assert!(matches!(error, OutputError::NoFolder { .. }) && error.to_string().contains("mkdir"), "{error}");
    assert!(matches!(OutputFile::create(folder.path()), Err(OutputError::IsFolder { .. })));
    assert!(matches!(OutputFile::create(""), Err(OutputError::NoName { .. })));
    assert!(matches!(at("new/"), OutputError::NoName { .. }));
    fs::write(folder.path().join("file"), "").unwrap();
    assert!(OutputFile::create(folder.path().join("file/a.png")).is_err());
    let long = at(&"x".repeat(300));
    assert!(matches!(long, OutputError::Io { .. }) && long.to_string().lines().count() <= 3, "{long}");
    assert!(!long.to_string().contains(".turner-"), "{long}");
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn a_read_only_file_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    let mut permissions = fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).unwrap();
    assert!(matches!(OutputFile::create(&path), Err(OutputError::ReadOnly { .. })));
}

#[cfg(unix)]
#[test]
fn permissions_are_ordinary_or_kept() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let (path, ordinary) = (folder.path().join("a.png"), folder.path().join("ordinary"));
    fs::write(&ordinary, "").unwrap();
    OutputFile::create(&path).unwrap().commit(b"x").unwrap();
    assert_eq!(mode(&path), mode(&ordinary));
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    OutputFile::create(&path).unwrap().commit(b"y").unwrap();
    assert_eq!(mode(&path), 0o640);
}

#[cfg(unix)]
#[test]
fn links_stay_and_devices_are_written_to() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("real")).unwrap();
    let (real, link) = (folder.path().join("real/a.png"), folder.path().join("link.png"));
    fs::write(&real, "old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    OutputFile::create(&link).unwrap().commit(b"new").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&real).unwrap(), b"new");
    OutputFile::create("/dev/null").unwrap().commit(b"gone").unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}
