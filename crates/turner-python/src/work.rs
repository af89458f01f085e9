//! Long work without the GIL, which Ctrl-C ends.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;

/// Time between two looks at signals and calls of a progress function.
const POLL: Duration = Duration::from_millis(40);

/// Runs `work` on another thread, without the GIL. Meanwhile this thread runs Python's handlers of signals and calls
/// `tick`; an exception of either calls `cancel`, and is returned when the work has ended.
pub(crate) fn attend<T: Send>(
    py: Python<'_>,
    cancel: impl Fn() + Send + Sync,
    work: impl FnOnce() -> T + Send,
    mut tick: impl FnMut(Python<'_>) -> PyResult<()> + Send,
) -> PyResult<T> {
    py.detach(|| {
        std::thread::scope(|scope| {
            let (done, wait) = channel::<()>();
            let worker = scope.spawn(move || {
                let result = work();
                drop(done);
                result
            });
            let mut raised = None;
            while wait.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
                if raised.is_some() {
                    continue;
                }
                raised = Python::attach(|py| py.check_signals().and_then(|()| tick(py))).err();
                if raised.is_some() {
                    cancel();
                }
            }
            let result = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            raised.map_or(Ok(result), Err)
        })
    })
}
