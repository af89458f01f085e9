//! Atomic output files: at any moment the path holds either the old file or the complete new one.
//!
//! The temporary file is created in the destination folder before rendering starts, so an unwritable path is reported
//! immediately and not after an hour. A killed process may leave a `.turner-*.tmp` file, which the next process that
//! writes into the folder removes.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Cursor, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::WriteSeek;
use super::temporary::{create_in, free_space, sync_folder};
use crate::assets::printable;

/// Why an output file could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The folder does not exist.
    #[error("{path}: the folder {folder} does not exist\n  create it (mkdir -p) or choose another path")]
    NoFolder {
        /// The output path.
        path: String,
        /// Its folder.
        folder: String,
    },
    /// The path is a folder.
    #[error("{path}: is a folder; expected a file name\n  add one, such as {path}/picture.png")]
    IsFolder {
        /// The output path.
        path: String,
    },
    /// The path has no file name.
    #[error("\"{path}\": has no file name\n  add one, such as picture.png")]
    NoName {
        /// The output path.
        path: String,
    },
    /// The existing file is read-only.
    #[error("{path}: exists and is read-only\n  make it writable or choose another path")]
    ReadOnly {
        /// The output path.
        path: String,
    },
    /// The disk has too little free space.
    #[error("{path}: may take {}, but its disk has {} left\n  free some space or choose another disk",
        bytes_text(*need), bytes_text(*free))]
    NoSpace {
        /// The output path.
        path: String,
        /// Bytes that the file may need.
        need: u64,
        /// Free bytes.
        free: u64,
    },
    /// The operating system reported an error.
    #[error("{path}: cannot {step}: {source}\n  {remedy}")]
    Io {
        /// The output path.
        path: String,
        /// The step that failed.
        step: &'static str,
        /// The remedy.
        remedy: &'static str,
        /// The system's error.
        source: io::Error,
    },
}

/// An output file that appears under its path when complete. If dropped before [`OutputFile::commit`], it removes its
/// temporary file and leaves an existing file unchanged.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    target: Target,
}

#[derive(Debug)]
enum Target {
    /// A regular file: `temporary`, in `folder`, replaces it.
    File { temporary: NamedTempFile, folder: PathBuf },
    /// A device or pipe, such as /dev/null: written to, not replaced.
    Stream,
}

impl OutputFile {
    /// Checks that `path` can be written, by creating a temporary file in its folder. Symbolic links are
    /// followed: the target is replaced, not the link.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, OutputError> {
        let asked = path.into();
        let shown = printable(&asked.to_string_lossy());
        // Only existing paths can be canonicalised.
        let path = fs::canonicalize(&asked).unwrap_or_else(|_| asked.clone());
        match fs::metadata(&path) {
            Ok(meta) if meta.is_dir() => return Err(OutputError::IsFolder { path: shown }),
            Ok(meta) if !meta.is_file() => return Ok(Self { path, target: Target::Stream }),
            Ok(meta) if meta.permissions().readonly() => return Err(OutputError::ReadOnly { path: shown }),
            Ok(_) => {}
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            Err(e) => return Err(failed(&path, "get its metadata", e)),
        }
        let trailing = asked.to_string_lossy().ends_with(std::path::MAIN_SEPARATOR);
        if path.file_name().is_none() || trailing {
            return Err(OutputError::NoName { path: shown });
        }
        let folder = match path.parent() {
            Some(p) if !p.as_os_str().is_empty() => p.to_owned(),
            _ => PathBuf::from("."),
        };
        if !folder.is_dir() {
            let folder = printable(&folder.to_string_lossy());
            return Err(OutputError::NoFolder { path: shown, folder });
        }
        let temporary =
            create_in(&folder).map_err(|e| failed(&path, "create a file in its folder", unnamed(e)))?;
        Ok(Self { path, target: Target::File { temporary, folder } })
    }

    /// Checks that the disk has `need` free bytes, if the system reports its free space.
    pub fn check_space(&self, need: u64) -> Result<(), OutputError> {
        match &self.target {
            Target::Stream => Ok(()),
            Target::File { folder, .. } => match free_space(folder) {
                Some(free) if free < need => {
                    Err(OutputError::NoSpace { path: printable(&self.path.to_string_lossy()), need, free })
                }
                _ => Ok(()),
            },
        }
    }

    /// The path that will be written, with links resolved.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the bytes, flushes them to disk, and renames the file to its path atomically. An existing file's
    /// permissions are kept; a new file has the user's default permissions.
    pub fn commit(self, bytes: &[u8]) -> Result<(), OutputError> {
        self.commit_with(|out| out.write_all(bytes))
    }

    /// Like [`OutputFile::commit_with`], for formats whose first bytes are written last.
    pub fn commit_seeking(
        self,
        write: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        match self.target {
            // A pipe cannot seek.
            Target::Stream => self.commit_with(|out| {
                let mut bytes = Cursor::new(Vec::new());
                write(&mut bytes)?;
                out.write_all(&bytes.into_inner())
            }),
            Target::File { temporary, folder } => replace(&self.path, temporary, &folder, |out| write(out)),
        }
    }

    /// Like [`OutputFile::commit`], with the bytes that `write` produces.
    pub fn commit_with(
        self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let path = &self.path;
        match self.target {
            Target::Stream => OpenOptions::new()
                .write(true)
                .open(path)
                .and_then(|mut f| write(&mut f))
                .map_err(|e| failed(path, "write", e)),
            Target::File { temporary, folder } => replace(path, temporary, &folder, |out| write(out)),
        }
    }
}

/// Writes a temporary file, flushes it to the disk, and renames it.
fn replace(
    path: &Path,
    mut temporary: NamedTempFile,
    folder: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let mut buffered = BufWriter::with_capacity(1 << 16, temporary.as_file_mut());
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(|e| failed(path, "write", e))?;
    drop(buffered);
    if let Ok(existing) = fs::metadata(path) {
        let keep = temporary.as_file().set_permissions(existing.permissions());
        keep.map_err(|e| failed(path, "keep its permissions", e))?;
    }
    temporary.as_file().sync_all().map_err(|e| failed(path, "flush it to the disk", e))?;
    temporary.persist(path).map_err(|e| failed(path, "replace it", e.error))?;
    sync_folder(folder).map_err(|e| failed(path, "flush its folder to the disk", e))
}

/// A size for messages: `1.5 MB`.
fn bytes_text(bytes: u64) -> String {
    if bytes < 1_000_000 { format!("{bytes} bytes") } else { format!("{:.1} MB", bytes as f64 / 1e6) }
}

/// The error without the name of the temporary file, which would confuse the user.
fn unnamed(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::PermissionDenied
        | io::ErrorKind::ReadOnlyFilesystem
        | io::ErrorKind::StorageFull
        | io::ErrorKind::QuotaExceeded
        | io::ErrorKind::NotFound
        | io::ErrorKind::InvalidFilename => error.kind().into(),
        _ => error,
    }
}

fn failed(path: &Path, step: &'static str, source: io::Error) -> OutputError {
    let remedy = match source.kind() {
        io::ErrorKind::PermissionDenied => "change its permissions or choose another path",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "free some space or choose another disk",
        io::ErrorKind::ReadOnlyFilesystem => "choose a path on a disk that can be written",
        io::ErrorKind::InvalidFilename => "choose a shorter name without special characters",
        _ => "choose another path",
    };
    OutputError::Io { path: printable(&path.to_string_lossy()), step, remedy, source }
}
