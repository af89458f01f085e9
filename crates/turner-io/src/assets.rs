//! Access to files: the bytes of a URI. Scenes reach other files only through this module.
//!
//! A URI is a path relative to the scene's folder, with `/` or `\` as separator, and may be percent-encoded as in
//! glTF. It may not leave that folder: not through `..` (encoded or not), an absolute path, `file://`, a Windows
//! drive or network share, or a symbolic link. Nothing is fetched from a network.

mod kept;
mod memory;
mod spelling;

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use turner::schema::{ErrorCode, Limits, Remedy, SceneError};

use crate::scene::two_lines;

pub use kept::KeptAssets;
pub use memory::MemoryAssets;

pub(crate) use crate::words::{nearest, printable};

/// Default limit of all reads of a [`FolderAssets`] and its clones together, in bytes: 4 GiB.
pub const DEFAULT_BUDGET: u64 = 4 << 30;

/// Most directory entries that are compared with a missing name.
const MAX_LISTED: usize = 10_000;

/// Why an asset could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AssetError {
    /// The file does not exist.
    #[error("{uri}: no such file in {folder}{nearest}\n  check the name, or copy the file there")]
    Missing {
        /// The URI as given.
        uri: String,
        /// The folder that was searched.
        folder: String,
        /// `"; the nearest is \"wood.png\""`, or empty.
        nearest: String,
    },
    /// The URI leads out of the scene's folder.
    #[error(
        "{uri}: {reason}; expected a path inside {root}\n  \
         move the file there, or allow the scene to read that folder"
    )]
    Outside {
        /// The URI as given.
        uri: String,
        /// How it leaves the folder.
        reason: &'static str,
        /// The scene's folder.
        root: String,
    },
    /// The URI is not a valid path.
    #[error("{uri}: {reason}; expected a path relative to the scene's folder")]
    Invalid {
        /// The URI as given.
        uri: String,
        /// The problem.
        reason: &'static str,
    },
    /// Not a regular file.
    #[error("{uri} is {found}; expected a regular file")]
    NotAFile {
        /// The URI as given.
        uri: String,
        /// What was found.
        found: &'static str,
    },
    /// The file exceeds the caller's limit.
    #[error("{uri}: has {size} bytes; expected at most {limit}\n  use a smaller file")]
    TooLarge {
        /// The URI as given.
        uri: String,
        /// Its size in bytes, at least.
        size: u64,
        /// The limit in bytes.
        limit: u64,
    },
    /// All files of the scene together exceed the limit.
    #[error(
        "{uri}: has {size} bytes; the files of the scene together would exceed {budget} bytes\n  raise the memory limit"
    )]
    Budget {
        /// The URI as given.
        uri: String,
        /// Its size in bytes.
        size: u64,
        /// The limit for all files together, in bytes.
        budget: u64,
    },
    /// The memory limit does not allow the read.
    #[error("{message}\n  {help}")]
    Memory {
        /// How much was requested and how much is left.
        message: String,
        /// The remedy.
        help: String,
    },
    /// The operating system reported an error.
    #[error("{uri}: cannot be read: {source}\n  {}", remedy_of(source))]
    Io {
        /// The URI as given.
        uri: String,
        /// The system's error.
        source: io::Error,
    },
}

/// What to do about an error of the operating system.
fn remedy_of(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "check its path",
        io::ErrorKind::NotADirectory => "check its path: a part of it is a file",
        _ => "check its permissions",
    }
}

impl AssetError {
    /// What a program can do about the error.
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            AssetError::Outside { .. } => Some(Remedy::OpenFolder),
            AssetError::Budget { .. } | AssetError::Memory { .. } => Some(Remedy::MoreMemory),
            _ => None,
        }
    }

    /// Converts to an error of the scene that refers to the file.
    pub fn to_scene_error(&self) -> SceneError {
        let code = match self {
            AssetError::TooLarge { .. } | AssetError::Budget { .. } | AssetError::Memory { .. } => {
                ErrorCode::TooLarge
            }
            _ => ErrorCode::File,
        };
        two_lines(code, &self.to_string()).remedy(self.remedy())
    }
}

/// A source of files for loaders.
pub trait AssetSource: Sync {
    /// Reads `uri`. A file of more than `limit` bytes is an error; it is never truncated.
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError>;

    /// Reads `uri` before it is known that it is used, on another thread than that of the loader. The loader passes the
    /// mark to [`AssetSource::used`] when it uses the file.
    fn read_ahead(&self, uri: &str, limit: u64) -> Result<(Vec<u8>, String), AssetError> {
        Ok((self.read(uri, limit)?, String::new()))
    }

    /// Notes that a file that was read ahead is used.
    fn used(&self, _mark: String) {}

    /// Opens `uri` for streaming, for files too large to hold in memory.
    fn open<'a>(&'a self, uri: &str, limit: u64) -> Result<Box<dyn Read + 'a>, AssetError> {
        self.read(uri, limit).map(|bytes| Box::new(io::Cursor::new(bytes)) as Box<dyn Read + 'a>)
    }

    /// The name of `uri` in messages.
    fn describe(&self, uri: &str) -> String;

    /// Resolves `uri`, as written in the file `from`, relative to the scene's folder: `("parts/a.toml", "b.png")`
    /// gives `parts/b.png`. `..` may leave `parts`, but not the scene's folder.
    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        resolve_inside(from, uri)
    }
}

/// A scene's folder on disk.
#[derive(Clone, Debug)]
pub struct FolderAssets {
    root: PathBuf,
    /// Additional folders that may be read, canonical.
    more: Vec<PathBuf>,
    allow_outside: bool,
    limits: Limits,
    budget: u64,
    used: Arc<AtomicU64>,
}

impl FolderAssets {
    /// `root` is the folder of the scene file; "" is the current folder.
    pub fn new(root: impl AsRef<Path>) -> Result<Self, AssetError> {
        let root = if root.as_ref().as_os_str().is_empty() { Path::new(".") } else { root.as_ref() };
        let uri = || printable(&root.to_string_lossy());
        let canonical = fs::canonicalize(root).map_err(|source| AssetError::Io { uri: uri(), source })?;
        if !canonical.is_dir() {
            let reason = "is not a folder";
            return Err(AssetError::Invalid { uri: uri(), reason });
        }
        Ok(Self {
            root: canonical,
            more: Vec::new(),
            allow_outside: false,
            limits: Limits::default(),
            budget: DEFAULT_BUDGET,
            used: Arc::default(),
        })
    }

    /// Allows reads from additional folders; links are resolved first. A missing folder is an error.
    pub fn allow_paths(mut self, folders: &[PathBuf]) -> Result<Self, AssetError> {
        for folder in folders {
            self.more.push(Self::new(folder)?.root);
        }
        Ok(self)
    }

    /// Sets the memory limits. All files together may have as many bytes as the memory limit, but at least
    /// [`DEFAULT_BUDGET`].
    pub fn with_limits(mut self, limits: Limits) -> Self {
        if limits.memory.limit() != u64::MAX {
            self.budget = self.budget.max(limits.memory.limit());
        }
        self.limits = limits;
        self
    }

    /// Whether `..`, absolute paths and links may leave the folder. Only for scenes that the user trusts.
    pub fn allow_outside(mut self, allow: bool) -> Self {
        self.allow_outside = allow;
        self
    }

    /// Sets the limit of all reads together, in bytes.
    pub fn with_budget(mut self, bytes: u64) -> Self {
        self.budget = bytes;
        self
    }

    /// Whether a canonical path may be read.
    fn may_read(&self, real: &Path) -> bool {
        self.allow_outside
            || real.starts_with(&self.root)
            || self.more.iter().any(|folder| real.starts_with(folder))
    }

    /// The scene's folder, canonical.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The canonical path of a URI. Tries the literal name first, then the percent-decoded one; inside the folder
    /// also the only name that differs just in letter case.
    fn locate(&self, uri: &str) -> Result<PathBuf, AssetError> {
        let decoded = percent_decode(uri)?;
        let spellings: &[&str] = if decoded == uri { &[uri] } else { &[uri, &decoded] };
        let mut missing = self.root.clone();
        for spelling in spellings {
            let path = match relative(spelling).and_then(|r| normalise(r, spelling)) {
                Ok(inside) => self.root.join(inside),
                Err(AssetError::Outside { reason, .. }) => {
                    let path = spelling.strip_prefix("file://").unwrap_or(spelling).replace('\\', "/");
                    let path = self.root.join(path);
                    // Do not reveal whether files exist in folders that may not be read.
                    if !self.may_read(&without_dots(&path))
                        && !fs::canonicalize(&path).is_ok_and(|p| self.may_read(&p))
                    {
                        return Err(self.outside(uri, reason));
                    }
                    path
                }
                Err(AssetError::Invalid { reason, .. }) => {
                    return Err(AssetError::Invalid { uri: printable(uri), reason });
                }
                Err(e) => return Err(e),
            };
            let found =
                fs::canonicalize(&path).or_else(|error| match spelling::ignoring_case(&self.root, &path) {
                    Some(other) if spelling::is_absent(&error) => fs::canonicalize(other),
                    _ => Err(error),
                });
            match found {
                Ok(real) if self.may_read(&real) => return Ok(real),
                Ok(_) => return Err(self.outside(uri, "a link leaves the folder")),
                Err(e) if spelling::is_absent(&e) => missing = path,
                Err(source) => return Err(AssetError::Io { uri: printable(uri), source }),
            }
        }
        Err(self.missing(uri, &missing))
    }

    fn outside(&self, uri: &str, reason: &'static str) -> AssetError {
        let root = printable(&self.root.to_string_lossy());
        AssetError::Outside { uri: printable(uri), reason, root }
    }

    /// The error for a missing file; suggests the nearest name if the folder may be read.
    fn missing(&self, uri: &str, path: &Path) -> AssetError {
        let folder = path.parent().unwrap_or(&self.root);
        let may_list = fs::canonicalize(folder).is_ok_and(|f| self.may_read(&f));
        let wanted = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let names: Vec<String> = match fs::read_dir(folder) {
            Ok(entries) if may_list => {
                let names = entries.take(MAX_LISTED).flatten();
                names.map(|e| e.file_name().to_string_lossy().into_owned()).collect()
            }
            _ => Vec::new(),
        };
        let nearest = nearest(&wanted, names.iter().map(String::as_str))
            .map_or_else(String::new, |n| format!("; the nearest is \"{}\"", printable(n)));
        AssetError::Missing { uri: printable(uri), folder: printable(&folder.to_string_lossy()), nearest }
    }

    /// Charges `size` bytes to the budget.
    fn charge(&self, uri: &str, size: u64) -> Result<(), AssetError> {
        let take = |used: u64| used.checked_add(size).filter(|&sum| sum <= self.budget);
        match self.used.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take) {
            Ok(_) => Ok(()),
            Err(_) => Err(AssetError::Budget { uri: printable(uri), size, budget: self.budget }),
        }
    }
}

impl FolderAssets {
    /// Opens a file and charges its size to the budget.
    fn file(&self, uri: &str, limit: u64) -> Result<(File, u64), AssetError> {
        let io = |source| AssetError::Io { uri: printable(uri), source };
        let path = self.locate(uri)?;
        // Checked before opening: opening a pipe would block until it has a writer.
        regular(uri, &fs::metadata(&path).map_err(io)?)?;
        let file = File::open(&path).map_err(io)?;
        let meta = file.metadata().map_err(io)?;
        regular(uri, &meta)?;
        let size = meta.len();
        if size > limit {
            return Err(AssetError::TooLarge { uri: printable(uri), size, limit });
        }
        self.charge(uri, size)?;
        Ok((file, size))
    }
}

impl AssetSource for FolderAssets {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        let io = |source| AssetError::Io { uri: printable(uri), source };
        let (file, size) = self.file(uri, limit)?;
        self.limits
            .memory
            .need(size, || format!("{}: reading it", printable(uri)))
            .map_err(|e| AssetError::Memory { message: e.message, help: e.help.unwrap_or_default() })?;
        let mut bytes = Vec::new();
        let reserved = usize::try_from(size).map(|n| bytes.try_reserve_exact(n));
        if !matches!(reserved, Ok(Ok(()))) {
            return Err(io(io::ErrorKind::OutOfMemory.into()));
        }
        // Read only the size reported: a file that grows meanwhile must not evade the limits.
        file.take(size).read_to_end(&mut bytes).map_err(io)?;
        Ok(bytes)
    }

    fn open<'a>(&'a self, uri: &str, limit: u64) -> Result<Box<dyn Read + 'a>, AssetError> {
        let (file, size) = self.file(uri, limit)?;
        Ok(Box::new(file.take(size)))
    }

    fn describe(&self, uri: &str) -> String {
        printable(&self.root.join(uri).to_string_lossy())
    }

    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        match resolve_inside(from, uri) {
            Err(AssetError::Outside { .. }) if self.allow_outside || !self.more.is_empty() => {
                let from = Path::new(from).parent().unwrap_or(Path::new(""));
                Ok(from.join(uri.strip_prefix("file://").unwrap_or(uri)).to_string_lossy().into_owned())
            }
            Err(AssetError::Outside { reason, .. }) => Err(self.outside(uri, reason)),
            other => other,
        }
    }
}

/// Removes `.` and `..` from a path, textually.
fn without_dots(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(out.pop()),
            Component::CurDir => {}
            part => out.push(part),
        }
    }
    out
}

fn regular(uri: &str, meta: &fs::Metadata) -> Result<(), AssetError> {
    let found = match () {
        () if meta.is_file() => return Ok(()),
        () if meta.is_dir() => "a folder",
        () => "a pipe, socket or device",
    };
    Err(AssetError::NotAFile { uri: printable(uri), found })
}

/// Refuses everything but relative paths: schemes, drives, shares, absolute paths, NUL.
fn relative(uri: &str) -> Result<&str, AssetError> {
    let invalid = |reason| Err(AssetError::Invalid { uri: printable(uri), reason });
    let outside = |reason| {
        Err(AssetError::Outside { uri: printable(uri), reason, root: "the scene's folder".to_owned() })
    };
    if uri.is_empty() || uri.contains('\0') {
        return invalid("is empty or contains a NUL");
    }
    if uri.starts_with("\\\\") || uri.starts_with("//") {
        return invalid("is a network share");
    }
    if let Some((scheme, _)) = uri.split_once(':')
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'))
    {
        match scheme.to_ascii_lowercase().as_str() {
            "file" => return outside("is a file:// URI"),
            "data" => return invalid("is a data: URI, not a file"),
            s if s.len() == 1 => return outside("begins with a drive letter"),
            s if uri[s.len()..].starts_with("://") => {
                return invalid("is a network address; Turner does not use the network");
            }
            _ => {}
        }
    }
    if uri.starts_with(['/', '\\']) {
        return outside("is an absolute path");
    }
    Ok(uri)
}

fn resolve_inside(from: &str, uri: &str) -> Result<String, AssetError> {
    let base = normalise(relative(from)?, from)?;
    let folder = base.rsplit_once('/').map_or("", |(folder, _)| folder);
    normalise(&format!("{folder}/{}", relative(uri)?), uri)
}

/// Resolves `.` and `..` textually and reads `\` as `/`. A `..` that leaves the folder is refused. `shown` appears in
/// the message.
fn normalise(path: &str, shown: &str) -> Result<String, AssetError> {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." if parts.pop().is_none() => {
                let (reason, root) = ("leaves the folder through ..", "the scene's folder".to_owned());
                return Err(AssetError::Outside { uri: printable(shown), reason, root });
            }
            ".." => {}
            name => parts.push(name),
        }
    }
    Ok(parts.join("/"))
}

/// Percent-decodes: `%20` to a space. A `%` without two hex digits is kept; results that are not UTF-8 are refused.
fn percent_decode(uri: &str) -> Result<String, AssetError> {
    let hex = |b: Option<&u8>| b.and_then(|&b| char::from(b).to_digit(16));
    let bytes = uri.as_bytes();
    let (mut out, mut i) = (Vec::with_capacity(bytes.len()), 0);
    while i < bytes.len() {
        match (bytes[i], hex(bytes.get(i + 1)), hex(bytes.get(i + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                i += 3;
            }
            (b, _, _) => {
                out.push(b);
                i += 1;
            }
        }
    }
    let reason = "its percent-encoding is not UTF-8";
    String::from_utf8(out).map_err(|_| AssetError::Invalid { uri: printable(uri), reason })
}
