//! Recovery after a crash: unsaved work is written to a folder of the user from time to time, and offered at the next
//! start.
//!
//! Each session has a folder of its own with `scene.toml` and `about.json`. The folder is removed when the scene is saved
//! or closed. A folder whose session still runs is left alone: it holds the process's number.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use turner_host::time::Instant;

use serde::{Deserialize, Serialize};
use turner::SceneDesc;

use super::Document;

/// Time between two writes.
const INTERVAL: Duration = Duration::from_secs(20);

#[derive(Serialize, Deserialize)]
struct About {
    name: String,
    path: Option<PathBuf>,
    process: u32,
}

/// Writes unsaved work from time to time.
pub struct Recovery {
    folder: PathBuf,
    last: Instant,
    written: Option<Arc<SceneDesc>>,
    running: Option<Receiver<()>>,
}

/// Unsaved work of a session that ended without saving.
#[derive(Clone, Debug)]
pub struct Recovered {
    /// The scene file.
    pub scene: PathBuf,
    /// The name of the scene.
    pub name: String,
    /// The file that it belongs to, if it had one.
    pub path: Option<PathBuf>,
    folder: PathBuf,
}

impl Recovered {
    /// Forgets it.
    pub fn discard(&self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl Recovery {
    /// For a session whose folders lie in `root`.
    pub fn new(root: &Path) -> Recovery {
        let folder = root.join(format!("session-{}", std::process::id()));
        Recovery { folder, last: Instant::now(), written: None, running: None }
    }

    /// Writes the scene if it has unsaved changes and it is time; `now` writes at once. The writing is done in a thread.
    pub fn keep(&mut self, document: &Document, now: bool) {
        if self.running.as_ref().is_some_and(|running| {
            running.try_recv().is_err_and(|e| e == std::sync::mpsc::TryRecvError::Empty)
        }) {
            return;
        }
        self.running = None;
        if !document.is_changed() {
            self.clear();
            return;
        }
        let is_new = self.written.as_ref().is_none_or(|written| !Arc::ptr_eq(written, document.desc()));
        if !is_new || !now && self.last.elapsed() < INTERVAL {
            return;
        }
        self.last = Instant::now();
        self.written = Some(Arc::clone(document.desc()));
        let about = About {
            name: document.name(),
            path: document.path().map(Path::to_owned),
            process: std::process::id(),
        };
        let (folder, desc) = (self.folder.clone(), Arc::clone(document.desc()));
        let (end, running) = channel();
        let write = move || {
            // What cannot be kept is no reason to disturb the work.
            let _ = write(&folder, &desc, &about);
            drop(end);
        };
        if turner_host::thread::Builder::new().name("recovery".into()).spawn(write).is_ok() {
            self.running = Some(running);
        }
    }

    /// Waits for a write that runs: before the program ends, and in tests.
    pub fn finish(&mut self) {
        if let Some(running) = self.running.take() {
            let _ = running.recv();
        }
    }

    /// The work is saved, or given up.
    pub fn clear(&mut self) {
        self.finish();
        if self.written.take().is_some() {
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

fn write(folder: &Path, desc: &SceneDesc, about: &About) -> Option<()> {
    std::fs::create_dir_all(folder).ok()?;
    let options = turner_io::convert::ConvertOptions {
        source: about.name.clone(),
        overwrite: true,
        ..Default::default()
    };
    turner_io::convert::to_toml(desc, &folder.join("scene.toml"), &options).ok()?;
    let text = serde_json::to_string(about).ok()?;
    let file = turner_io::image::OutputFile::create(folder.join("about.json")).ok()?;
    file.commit(text.as_bytes()).ok()
}

impl Document {
    /// This document, as the unsaved work that it was read from: with the name and file of that, and changed.
    pub fn recovered(mut self, work: &Recovered) -> Document {
        self.path.clone_from(&work.path);
        self.title.clone_from(&work.name);
        self.opened = None;
        self.stamps = Arc::default();
        // Nothing on disk is this scene.
        self.saved = Arc::default();
        self
    }
}

/// Whether a process runs, where the system tells.
fn is_running(process: u32) -> bool {
    cfg!(target_os = "linux") && Path::new(&format!("/proc/{process}")).exists()
}

/// The unsaved work below `root`, of sessions that have ended.
pub fn recovered(root: &Path) -> Vec<Recovered> {
    let folders = std::fs::read_dir(root).into_iter().flatten().flatten().map(|entry| entry.path());
    let read = |folder: PathBuf| {
        let text = std::fs::read_to_string(folder.join("about.json")).ok()?;
        let about: About = serde_json::from_str(&text).ok()?;
        let scene = folder.join("scene.toml");
        let is_own = about.process == std::process::id();
        (scene.is_file() && !is_own && !is_running(about.process)).then_some(Recovered {
            scene,
            name: about.name,
            path: about.path,
            folder,
        })
    };
    folders.filter_map(read).collect()
}
