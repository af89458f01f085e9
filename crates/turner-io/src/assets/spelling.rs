//! File names that differ only in letter case. Scenes made on case-insensitive file systems contain such names.

use super::MAX_LISTED;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Whether an error means that the file does not exist.
pub(super) fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// The path below `root` that differs from `path` only in letter case, if there is exactly one. Folders outside
/// `root` that a link leads to are not searched.
pub(super) fn ignoring_case(root: &Path, path: &Path) -> Option<PathBuf> {
    let mut found = root.to_owned();
    for part in path.strip_prefix(root).ok()?.components() {
        let next = found.join(part);
        if next.symlink_metadata().is_ok() {
            found = next;
            continue;
        }
        if !fs::canonicalize(&found).is_ok_and(|folder| folder.starts_with(root)) {
            return None;
        }
        let wanted = part.as_os_str().to_str()?.to_lowercase();
        let entries = fs::read_dir(&found).ok()?.take(MAX_LISTED).flatten();
        let mut alike =
            entries.filter(|e| e.file_name().to_str().is_some_and(|n| n.to_lowercase() == wanted));
        match (alike.next(), alike.next()) {
            (Some(one), None) => found = one.path(),
            _ => return None,
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_that_differs_in_case_alone_is_found_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let root = fs::canonicalize(folder.path()).unwrap();
        if root.join("A").symlink_metadata().is_ok() || fs::create_dir(root.join("Textures")).is_err() {
            return;
        }
        fs::write(root.join("Textures/Oak.JPG"), "a").unwrap();
        let find = |name: &str| ignoring_case(&root, &root.join(name));
        assert_eq!(find("textures/oak.jpg"), Some(root.join("Textures/Oak.JPG")));
        assert_eq!(find("textures/oak.png"), None);
        fs::write(root.join("Textures/oak.JPG"), "b").unwrap();
        let both = fs::read_dir(root.join("Textures")).unwrap().count() == 2;
        assert!(!both || find("textures/oak.jpg").is_none(), "either could be meant");
        assert_eq!(ignoring_case(&root, Path::new("/elsewhere/oak.jpg")), None);
    }

    #[test]
    #[cfg(unix)]
    fn folders_elsewhere_are_not_looked_into() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let root = fs::canonicalize(folder.path()).unwrap();
        fs::write(other.path().join("Secret"), "a").unwrap();
        std::os::unix::fs::symlink(other.path(), root.join("link")).unwrap();
        assert_eq!(ignoring_case(&root, &root.join("link/secret")), None);
    }
}
