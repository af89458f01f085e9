//! Saving in the background.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use turner::SceneDesc;
use turner::schema::{ErrorCode, SceneError};
use turner_io::edit::{Saved, save_scene};

use super::Document;
use super::watch::{Stamp, stamp};

/// A save that runs in a thread of its own.
pub struct Saving {
    /// The file.
    pub path: PathBuf,
    desc: Arc<SceneDesc>,
    result: Receiver<Result<(Saved, Stamp), SceneError>>,
}

impl Document {
    /// Starts saving the scene to a TOML file. A scene that was read from a file keeps its comments and order. `wake` is
    /// called at the end; [`Document::saved`] then takes the result.
    pub fn save(&self, path: &Path, wake: impl FnOnce() + Send + 'static) -> Saving {
        let (send, result) = channel();
        let (desc, opened) = (Arc::clone(&self.desc), self.opened.clone());
        let (file, scene) = (path.to_owned(), Arc::clone(&desc));
        let write = move || {
            // Every save starts from the text that was opened: the positions in all descriptions of the history are those
            // of that text.
            let save = || save_scene(&scene, opened.as_deref(), &file);
            // After a fault the sender is gone, which `saved` reports.
            match catch_unwind(AssertUnwindSafe(save)) {
                Ok(saved) => drop(send.send(saved.map(|saved| (saved, stamp(&file))))),
                Err(_) => drop(send),
            }
            wake();
        };
        let _ = turner_host::thread::Builder::new().name("save".into()).spawn(write);
        Saving { path: path.to_owned(), desc, result }
    }

    /// Takes the result of a save, once there is one. The scene may have changed in the meantime: it then counts as
    /// changed.
    pub fn saved(&mut self, saving: &Saving) -> Option<Result<Saved, SceneError>> {
        let result = match saving.result.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                let message = "saving stopped with a fault; nothing was replaced";
                Err(SceneError::new(ErrorCode::Output, message).help("save under another name"))
            }
        };
        Some(result.map(|(saved, stamp)| {
            self.stamps = Arc::new(vec![(saving.path.clone(), stamp)]);
            self.saved = Arc::clone(&saving.desc);
            self.path = Some(saving.path.clone());
            let folder = saving.path.parent().filter(|p| !p.as_os_str().is_empty());
            self.folder = folder.unwrap_or(Path::new(".")).to_owned();
            saved
        }))
    }
}
