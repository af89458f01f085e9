//! Temporary files for output, and removal of those that killed programs left behind.
//!
//! A temporary file is locked while the program that writes it runs; the system releases the lock however the program
//! ends. The next program that writes into the folder removes files that are not locked.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use tempfile::NamedTempFile;

const PREFIX: &str = ".turner-";
const SUFFIX: &str = ".tmp";

/// Folders that this process has already cleaned.
static SWEPT: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Creates an empty, locked temporary file.
pub(super) fn create_in(folder: &Path) -> io::Result<NamedTempFile> {
    sweep_once(folder);
    loop {
        let file = make(folder)?;
        match file.as_file().try_lock() {
            // Another program may have removed it between creation and locking.
            Ok(()) if is_in_place(&file) => return Ok(file),
            // Another program is about to remove it; try again.
            Ok(()) | Err(TryLockError::WouldBlock) => {}
            // A file system without locks; nobody removes files there.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
}

/// Creates the file with the permissions of the umask; `tempfile` would restrict it to its owner.
fn make(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Whether the file still has a name.
fn is_in_place(file: &NamedTempFile) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        file.as_file().metadata().is_ok_and(|meta| meta.nlink() > 0)
    }
    #[cfg(not(unix))]
    file.path().exists()
}

fn sweep_once(folder: &Path) {
    let Ok(folder) = folder.canonicalize() else { return };
    let mut swept = SWEPT.lock().unwrap_or_else(|e| e.into_inner());
    if !swept.contains(&folder) {
        sweep(&folder);
        swept.push(folder);
    }
}

/// Removes the temporary files of programs that have ended. Files that cannot be opened or removed are left.
fn sweep(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if !ours || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let Ok(file) = OpenOptions::new().write(true).open(entry.path()) else { continue };
        if file.try_lock().is_ok() {
            // Removed while locked, so that no other program takes it over.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Flushes a folder, which makes a rename in it durable. Only Unix can open folders.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

/// Free bytes in `folder`; `None` if the system does not report them.
pub(super) fn free_space(folder: &Path) -> Option<u64> {
    #[cfg(unix)]
    {
        let stat = rustix::fs::statvfs(folder).ok()?;
        // Some network and memory file systems report no size.
        (stat.f_blocks > 0).then(|| stat.f_bavail.saturating_mul(stat.f_frsize))
    }
    #[cfg(not(unix))]
    {
        let _ = folder;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn only_files_without_an_owner_are_swept() {
        let folder = tempfile::tempdir().unwrap();
        let held = create_in(folder.path()).unwrap();
        let held_name = held.path().file_name().unwrap().to_str().unwrap().to_owned();
        fs::write(folder.path().join(".turner-left.tmp"), "half a picture").unwrap();
        fs::write(folder.path().join("turner-mine.tmp"), "not ours").unwrap();
        fs::create_dir(folder.path().join(".turner-folder.tmp")).unwrap();
        sweep(folder.path());
        let mut expected = [held_name.as_str(), ".turner-folder.tmp", "turner-mine.tmp"];
        expected.sort();
        assert_eq!(names(folder.path()), expected);
    }

    #[test]
    fn many_programs_may_sweep_and_write_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        std::thread::scope(|scope| {
            for i in 0..4 {
                scope.spawn(move || {
                    for k in 0..50 {
                        let file = create_in(path).unwrap();
                        sweep(path);
                        assert!(is_in_place(&file));
                        file.persist(path.join(format!("{i}-{k}"))).unwrap();
                    }
                });
            }
        });
        assert_eq!(names(path).len(), 200);
    }
}
