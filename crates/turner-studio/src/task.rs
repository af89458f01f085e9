//! Work in a thread of its own, whose result the window picks up when it is there.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Work that runs, or has run. Dropping it asks the work to stop.
pub struct Task<T> {
    stop: Arc<AtomicBool>,
    result: Receiver<T>,
}

/// Shows another frame when it is dropped: after a fault, too.
struct Wake(egui::Context);

impl Drop for Wake {
    fn drop(&mut self) {
        self.0.request_repaint();
    }
}

impl<T: Send + 'static> Task<T> {
    /// Starts work. It is given a flag that is set when nobody waits for it. `wake` is called at the end.
    pub fn start(wake: &egui::Context, work: impl FnOnce(&AtomicBool) -> T + Send + 'static) -> Task<T> {
        let (send, result) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let (of_thread, context) = (Arc::clone(&stop), wake.clone());
        let run = move || {
            let _wake = Wake(context);
            // Dropped before the window wakes. After a panic the sender is gone, which `poll` reports.
            let send = send;
            let _ = send.send(work(&of_thread));
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// Waits for the call that shows another frame; then the result is there.
    fn result(work: fn() -> u32) -> Result<u32, &'static str> {
        let context = egui::Context::default();
        let (send, woken) = channel();
        context.set_request_repaint_callback(move |_| {
            let _ = send.send(());
        });
        let task = Task::start(&context, move |_| work());
        woken.recv_timeout(Duration::from_secs(60)).expect("the window wakes");
        task.poll().expect("the result is there when the window wakes")
    }

    #[test]
    fn the_window_wakes_with_the_result_or_the_fault() {
        assert_eq!(result(|| 7), Ok(7));
        assert!(result(|| panic!("a fault for the test")).is_err());
    }
}
