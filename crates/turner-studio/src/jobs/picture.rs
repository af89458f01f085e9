//! The picture of a checkpoint, made in a thread.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use turner::schema::Limits;
use turner::{Picture, SceneDesc};

use super::Wake;

/// The picture so far of a render that runs.
pub struct Peek {
    /// The picture, and the samples per pixel that it has. Noise is not removed from it.
    pub picture: Option<(Arc<Picture>, f64)>,
    /// Why there is none.
    pub error: Option<String>,
    result: Option<Receiver<Result<(Picture, f64), String>>>,
}

impl Peek {
    /// Starts reading a checkpoint of a scene. Until the picture is ready, that of `last` stays.
    pub(super) fn start(file: PathBuf, desc: &Arc<SceneDesc>, last: Option<Peek>, wake: Wake) -> Peek {
        let (send, result) = channel();
        let desc = Arc::clone(desc);
        let read = move || {
            let _ = send.send(read(&file, &desc));
            wake();
        };
        // Without a thread the sender is dropped, which `poll` reports.
        let _ = std::thread::Builder::new().name("checkpoint".into()).spawn(read);
        Peek { picture: last.and_then(|last| last.picture), error: None, result: Some(result) }
    }

    /// Whether its picture is being made.
    pub fn is_reading(&self) -> bool {
        self.result.is_some()
    }

    /// Takes the picture, once it is ready.
    pub(super) fn poll(&mut self) {
        let Some(result) = &self.result else { return };
        match result.try_recv() {
            Err(TryRecvError::Empty) => return,
            Ok(Ok((picture, samples))) => self.picture = Some((Arc::new(picture), samples)),
            Ok(Err(error)) => self.error = Some(error),
            Err(TryRecvError::Disconnected) => self.error = Some("the checkpoint was not read".into()),
        }
        self.result = None;
    }
}

fn read(file: &std::path::Path, desc: &SceneDesc) -> Result<(Picture, f64), String> {
    let checkpoint = turner_io::checkpoint::read(file, &Limits::default()).map_err(|e| e.message)?;
    let mut film = desc.film.clone();
    [film.width, film.height] = checkpoint.header.size;
    film.samples = checkpoint.header.samples;
    // One thread: the render has the others.
    let picture = checkpoint.film.develop(&film, 1);
    Ok((picture, checkpoint.film.mean_samples()))
}
