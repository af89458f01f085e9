//! Temporary files beside an output, and what killed programs left of theirs.
//!
//! A temporary file is locked as long as the program that writes it lives; the system lets go of the lock however the
//! program ends. One that nobody holds any more is swept away by the next program that writes into the folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use tempfile::NamedTempFile;

const PREFIX: &str = ".turner-";
const SUFFIX: &str = ".tmp";

/// Folders that were swept in this process: once is enough.
static SWEPT: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Makes an empty temporary file that no other program sweeps away.
pub(super) fn create_in(folder: &Path) -> io::Result<NamedTempFile> {
    sweep_once(folder);
    loop {
        let file = make(folder)?;
        match file.as_file().try_lock() {
            // Another program may have come between making and locking it.
            Ok(()) if is_in_place(&file) => return Ok(file),
            // It looks at the file, finds it without an owner and removes it.
            Ok(()) | Err(TryLockError::WouldBlock) => {}
            // A file system without locks: nobody sweeps there either.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
}

/// `tempfile` makes files for their owner only; an output is for whom the umask says.
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

/// Removes the temporary files of programs that are no more. What cannot be opened or removed is left where it is.
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
            // Removed while it is locked, so that nobody takes it for theirs.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The rename is on disk when the folder is. Only Unix lets a folder be opened for that.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

/// Bytes that may still be written into `folder`; `None` if the system does not say.
pub(super) fn free_space(folder: &Path) -> Option<u64> {
    #[cfg(unix)]
    {
        let stat = rustix::fs::statvfs(folder).ok()?;
        // Some network and memory file systems have no size.
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
