//! Opening files in the background.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::SystemTime;

use turner::schema::SceneError;
use turner_io::LoadOptions;
use turner_io::edit::Opened;
use turner_io::scene::{LoadError, SceneFormat};

use super::watch::{stamp, stamps};
use super::{Document, Start};

/// Why a file could not be opened.
#[derive(Clone, Debug)]
pub struct OpenError {
    /// The file.
    pub path: PathBuf,
    /// The problem with its position: `scene.toml:12:3: unknown key …`.
    pub message: String,
    /// The remedy.
    pub help: Option<String>,
    /// The line in the file, from 1, and its text.
    pub line: Option<(usize, String)>,
    /// The file before it was read.
    pub(super) stamp: Option<Box<(SystemTime, u64)>>,
}

impl OpenError {
    fn new(path: &Path, error: &LoadError) -> OpenError {
        let line = error.location().map(|at| (at.line, at.excerpt.clone()));
        let place = error.location().map(|at| format!("{}:{}:{}: ", at.file, at.line, at.column));
        OpenError {
            path: path.to_owned(),
            message: format!("{}{}", place.unwrap_or_default(), error.error.message),
            help: error.error.help.clone(),
            line,
            stamp: None,
        }
    }

    fn plain(path: &Path, error: &SceneError) -> OpenError {
        OpenError {
            path: path.to_owned(),
            message: error.message.clone(),
            help: error.help.clone(),
            line: None,
            stamp: None,
        }
    }
}

/// Whether a file has a format that Turner reads, by its name.
pub fn readable(path: &Path) -> bool {
    SceneFormat::of_path(path).is_some()
}

/// A file that is read in a thread of its own.
pub struct Opening {
    path: PathBuf,
    result: Receiver<Result<Document, OpenError>>,
}

impl Opening {
    /// Starts reading a file. `wake` is called at the end.
    pub fn start(path: PathBuf, wake: impl FnOnce() + Send + 'static) -> Opening {
        let (send, result) = channel();
        let file = path.clone();
        let read = move || {
            let before = stamp(&file);
            let read = std::panic::catch_unwind(|| Document::open(&file)).unwrap_or_else(|_| {
                let message = "reading the file stopped with a fault".to_owned();
                let help = Some("please report it together with the file".to_owned());
                Err(OpenError { path: file.clone(), message, help, line: None, stamp: None })
            });
            let _ = send.send(read.map_err(|error| OpenError { stamp: before.map(Box::new), ..error }));
            wake();
        };
        // Without a thread the sender is dropped, which `poll` reports.
        let _ = turner_host::thread::Builder::new().name("open".into()).spawn(read);
        Opening { path, result }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The result, once there is one.
    pub fn poll(&self) -> Option<Result<Document, OpenError>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                let message = "no thread can be started to read it".to_owned();
                Some(Err(OpenError { path: self.path.clone(), message, help: None, line: None, stamp: None }))
            }
        }
    }
}

impl Document {
    /// Reads a scene or a model.
    ///
    /// Errors: those of [`turner_io::load`], with the line.
    pub fn open(path: &Path) -> Result<Document, OpenError> {
        let before = stamp(path);
        let opened =
            Opened::load(path, &LoadOptions::default()).map_err(|error| OpenError::new(path, &error))?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut document = Document::of(opened.desc.clone(), String::new(), folder.to_owned());
        document.path = Some(path.to_owned());
        document.sources = Arc::new(opened.sources.clone());
        document.stamps = Arc::new(stamps(path, before, &opened.sources, &opened.desc));
        document.opened = Some(Arc::new(opened));
        Ok(document)
    }

    /// A scene of the gallery, as a new document.
    ///
    /// Errors: the folder for temporary files cannot be written.
    pub fn start(start: &Start) -> Result<Document, OpenError> {
        let name = PathBuf::from(format!("{}.toml", start.file));
        let failed = |error: std::io::Error| OpenError {
            path: name.clone(),
            message: format!("its files cannot be written for reading: {error}"),
            help: Some("free some space in the folder for temporary files".into()),
            line: None,
            stamp: None,
        };
        let folder = tempfile::Builder::new().prefix("turner-start-").tempdir().map_err(failed)?;
        for (file, bytes) in start.files {
            let path = folder.path().join(file);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent).map_err(failed)?;
            }
            std::fs::write(path, bytes).map_err(failed)?;
        }
        let path = folder.path().join(&name);
        std::fs::write(&path, start.text).map_err(failed)?;
        let mut document = Document::open(&path)?;
        document.path = None;
        document.title = start.name.to_owned();
        document._temporary = Some(Arc::new(folder));
        Ok(document)
    }

    /// Why a scene with a problem is not shown, as an error of its file.
    pub fn problem(&self, error: &SceneError) -> OpenError {
        let path = self.path.clone().unwrap_or_else(|| PathBuf::from(&self.title));
        let mut plain = OpenError::plain(&path, error);
        if let Some(at) = error.span.and_then(|span| self.sources.locate(span)) {
            plain.message = format!("{}:{}:{}: {}", at.file, at.line, at.column, error.message);
            plain.line = Some((at.line, at.excerpt.clone()));
        }
        plain
    }
}
