//! Work in a thread of its own, whose result the window picks up when it is there.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Work that runs, or has run. Dropping it asks the work to stop.
pub struct Task<T> {
    stop: Arc<AtomicBool>,
    result: Receiver<T>,
}

impl<T: Send + 'static> Task<T> {
    /// Starts work. It is given a flag that is set when nobody waits for it. `wake` is called at the end.
    pub fn start(wake: &egui::Context, work: impl FnOnce(&AtomicBool) -> T + Send + 'static) -> Task<T> {
        let (send, result) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let (of_thread, context) = (Arc::clone(&stop), wake.clone());
        let run = move || {
            // After a panic the sender is gone, which `poll` reports.
            let _ = send.send(work(&of_thread));
            context.request_repaint();
        };
        let _ = std::thread::Builder::new().name("task".into()).spawn(run);
        Task { stop, result }
    }

    /// The result: `None` while it works, an error if it stopped with a fault.
    pub fn poll(&self) -> Option<Result<T, &'static str>> {
        match self.result.try_recv() {
            Ok(value) => Some(Ok(value)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err("this analysis stopped with a fault")),
        }
    }
}

impl<T> Drop for Task<T> {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
