//! Writes the checkpoint of a render, from time to time in the background, and at the end.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use turner::film::Film;
use turner::schema::{Memory, Warning, WarningKind};
use turner_io::checkpoint::{Header, to_bytes, write, write_film};
use turner_io::scene::Sources;

use super::free_beside;
use crate::failure::Labels;
use crate::report::Reporter;

/// Renders that are shorter leave no checkpoint, unless it is asked for.
const FIRST: Duration = Duration::from_secs(60);

/// Time between two checkpoints.
const INTERVAL: Duration = Duration::from_secs(30);

/// Larger films are written while rendering waits, instead of a copy of them: 1 GiB.
const MOST_COPIED: u64 = 1 << 30;

/// Rendering waits for checkpoints for at most one part in so many of its time.
const PAUSES: u32 = 20;

/// When and where checkpoints are written.
pub(crate) struct Writer {
    path: PathBuf,
    header: Header,
    interval: Duration,
    next: Instant,
    /// The picture, if the path is chosen when the first checkpoint is written: an existing file is kept, because it
    /// holds the samples of another render.
    beside: Option<PathBuf>,
    task: Option<JoinHandle<Result<(), String>>>,
    memory: Arc<Memory>,
    /// Whether this render wrote or continued the file.
    is_own: bool,
    warned: bool,
    /// Seconds of tracing before this render.
    before: f64,
}

impl Writer {
    /// Writes to `path`, which this render continues if `is_own`. `interval` is in seconds, by default 30 after a
    /// minute.
    pub(crate) fn new(
        path: PathBuf,
        header: Header,
        interval: Option<f64>,
        memory: Arc<Memory>,
        is_own: bool,
    ) -> Writer {
        let asked = interval.map(Duration::from_secs_f64);
        let first = asked.unwrap_or(if header.keep { INTERVAL } else { FIRST });
        let before = header.seconds;
        Writer {
            path,
            header,
            interval: asked.unwrap_or(INTERVAL),
            next: Instant::now() + first,
            beside: None,
            task: None,
            memory,
            is_own,
            warned: false,
            before,
        }
    }

    /// The path lies beside this picture and is chosen so that no existing file is overwritten.
    pub(crate) fn beside(mut self, picture: &Path) -> Writer {
        self.beside = (!self.is_own).then(|| picture.to_owned());
        self
    }

    /// Whether it is time for the next one.
    pub(crate) fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// Writes the film in the background. Failures are reported once; rendering continues.
    pub(crate) fn write(&mut self, film: &Film, seconds: f64, reporter: &Reporter) {
        if self.task.as_ref().is_some_and(|task| !task.is_finished()) {
            // The disk is slow: the next one comes later.
            self.next = Instant::now() + self.interval;
            return;
        }
        let begin = Instant::now();
        self.start(film, seconds, reporter);
        self.next = Instant::now() + self.interval.max(PAUSES * begin.elapsed());
    }

    /// Begins to write the film, after the last write has ended. Rendering continues meanwhile if the film is not large
    /// and there is memory for a copy of it.
    fn start(&mut self, film: &Film, seconds: f64, reporter: &Reporter) {
        self.join(reporter);
        self.prepare(film, seconds);
        let size = film.memory() as u64;
        if size > MOST_COPIED || self.memory.left() < size {
            match write_film(&self.path, &self.header, film) {
                Ok(()) => self.is_own = true,
                Err(message) => self.warn(&message, reporter),
            }
            return;
        }
        match to_bytes(&self.header, film) {
            Ok(bytes) => {
                let path = self.path.clone();
                let work = move || write(&path, &bytes).map_err(|e| e.to_string());
                self.task = std::thread::Builder::new().name("checkpoint".into()).spawn(work).ok();
            }
            Err(error) => self.warn(&error.message, reporter),
        }
    }

    /// Writes the last checkpoint. Returns its path, or `None` after a failure, which is reported in any case.
    pub(crate) fn write_last(&mut self, film: &Film, seconds: f64, reporter: &Reporter) -> Option<&Path> {
        self.join(reporter);
        self.warned = false;
        self.prepare(film, seconds);
        match write_film(&self.path, &self.header, film) {
            Ok(()) => {
                self.is_own = true;
                Some(&self.path)
            }
            Err(message) => {
                self.warn(&message, reporter);
                None
            }
        }
    }

    /// Ends the work after the picture is written: removes the checkpoint, unless the user named it.
    pub(crate) fn remove(&mut self, reporter: &Reporter) {
        self.join(reporter);
        if self.is_own && !self.header.keep {
            // It may never have been written.
            let _ = std::fs::remove_file(&self.path);
        }
    }

    /// Whether the user named the file, so that it stays.
    pub(crate) fn is_kept(&self) -> bool {
        self.header.keep
    }

    /// Waits for the background.
    fn join(&mut self, reporter: &Reporter) {
        match self.task.take().map(JoinHandle::join) {
            Some(Ok(Ok(()))) => self.is_own = true,
            Some(Ok(Err(message))) => self.warn(&message, reporter),
            Some(Err(_)) => self.warn("a fault while writing it", reporter),
            None => {}
        }
    }

    /// Chooses the path, and completes the header.
    fn prepare(&mut self, film: &Film, seconds: f64) {
        if let Some(picture) = self.beside.take() {
            self.path = free_beside(&picture);
            self.is_own = true;
        }
        let pixels = (film.region.area() as f64).max(1.0);
        self.header.held = film.samples() as f64 / pixels;
        self.header.seconds = self.before + seconds;
    }

    fn warn(&mut self, message: &str, reporter: &Reporter) {
        if std::mem::replace(&mut self.warned, true) {
            return;
        }
        let message = format!("the checkpoint cannot be written: {}", message.replace("\n  ", "; "));
        let warning = Warning::new(WarningKind::Doubtful, message);
        reporter.warnings(&[warning], &Sources::default(), &Labels::new());
    }
}
