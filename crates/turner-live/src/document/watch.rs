//! Noticing that a file of the scene was changed by another program. Modification time and length are polled a few times
//! a second in a thread: this works on network folders and with editors that replace files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use turner::SceneDesc;
use turner_io::scene::Sources;

use super::Document;

/// Interval between two looks at the files.
const INTERVAL: Duration = Duration::from_millis(200);

/// Modification time and length of a file; `None` if there is none.
pub(super) type Stamp = Option<(SystemTime, u64)>;

pub(super) fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// The files that a scene is read from: the scene file first.
fn files(path: &Path, sources: &Sources, desc: &SceneDesc) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let texts = sources.files().iter().filter(|f| !f.is_argument).map(|f| folder.join(&f.uri));
    let images = desc.images.iter().map(|i| folder.join(&i.uri));
    let meshes = desc.meshes.iter().map(|m| folder.join(&m.uri));
    let imports = desc.imports.iter().map(|i| folder.join(&i.file));
    let mut files: Vec<PathBuf> = std::iter::once(path.to_owned()).chain(texts).chain(images).collect();
    files.extend(meshes.chain(imports));
    files.sort();
    files.dedup();
    files
}

/// The files of a scene as they were when it was read, so that a change in between is not missed. `own` is the stamp of the
/// scene file before it was read.
pub(super) fn stamps(path: &Path, own: Stamp, sources: &Sources, desc: &SceneDesc) -> Vec<(PathBuf, Stamp)> {
    let with_stamp = |file: PathBuf| {
        let at = if file == path { own } else { stamp(&file) };
        (file, at)
    };
    files(path, sources, desc).into_iter().map(with_stamp).collect()
}

/// Watches files until it is dropped.
pub struct Watch {
    changed: Arc<AtomicBool>,
    end: Arc<AtomicBool>,
}

impl Watch {
    /// Watches a document's scene file and the files that the scene was read from. `wake` is called when one has changed
    /// since it was read and all are stable. `None` for a scene without a file.
    pub fn new(document: &Document, wake: impl Fn() + Send + 'static) -> Option<Watch> {
        let path = document.path()?;
        let files = files(path, document.sources(), document.desc());
        let read = document.stamps.clone();
        let (changed, end) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let (of_changed, of_end) = (Arc::clone(&changed), Arc::clone(&end));
        let watch = move || {
            let files: Vec<PathBuf> = files.into_iter().filter(|file| file.is_file()).collect();
            let of_file = |file: &PathBuf| {
                let known = read.iter().find(|(other, _)| other == file).map(|(_, stamp)| *stamp);
                known.unwrap_or_else(|| stamp(file))
            };
            let mut known: Vec<Stamp> = files.iter().map(of_file).collect();
            while !of_end.load(Ordering::Relaxed) {
                std::thread::sleep(INTERVAL);
                let now: Vec<Stamp> = files.iter().map(|file| stamp(file)).collect();
                if now == known {
                    continue;
                }
                // A file that is being replaced is missing, empty or growing for a moment.
                std::thread::sleep(INTERVAL);
                let again: Vec<Stamp> = files.iter().map(|file| stamp(file)).collect();
                let whole = again.iter().all(|stamp| stamp.is_some_and(|(_, length)| length > 0));
                if again == now && whole {
                    known = now;
                    of_changed.store(true, Ordering::Release);
                    wake();
                }
            }
        };
        // Without a thread, nothing is noticed; reloading by hand still works.
        let _ = turner_host::thread::Builder::new().name("watch".into()).spawn(watch);
        Some(Watch { changed, end })
    }

    /// Whether a file has changed since the last call.
    pub fn take(&self) -> bool {
        self.changed.swap(false, Ordering::AcqRel)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
    }
}
