//! Noticing that a file of the scene was changed by another program. Modification time and length are polled a few times
//! a second in a thread: this works on network folders and with editors that replace files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use turner::SceneDesc;
use turner_io::scene::Sources;

/// Interval between two looks at the files.
const INTERVAL: Duration = Duration::from_millis(200);

type Stamp = Option<(SystemTime, u64)>;

fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// Watches files until it is dropped.
pub struct Watch {
    changed: Arc<AtomicBool>,
    end: Arc<AtomicBool>,
}

impl Watch {
    /// Watches a scene file and the files that the scene was read from. `wake` is called when one has changed and all are
    /// stable.
    pub fn new(path: &Path, sources: &Sources, desc: &SceneDesc, wake: impl Fn() + Send + 'static) -> Watch {
        let folder = path.parent().unwrap_or(Path::new(""));
        let texts = sources.files().iter().filter(|f| !f.is_argument).map(|f| folder.join(&f.uri));
        let images = desc.images.iter().map(|i| folder.join(&i.uri));
        let meshes = desc.meshes.iter().map(|m| folder.join(&m.uri));
        let imports = desc.imports.iter().map(|i| folder.join(&i.file));
        let mut files: Vec<PathBuf> = std::iter::once(path.to_owned()).chain(texts).chain(images).collect();
        files.extend(meshes.chain(imports));
        files.sort();
        files.dedup();
        files.retain(|file| file.is_file());
        let (changed, end) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let (of_changed, of_end) = (Arc::clone(&changed), Arc::clone(&end));
        let watch = move || {
            let mut known: Vec<Stamp> = files.iter().map(|file| stamp(file)).collect();
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
        let _ = std::thread::Builder::new().name("watch".into()).spawn(watch);
        Watch { changed, end }
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
