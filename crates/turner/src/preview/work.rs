//! Tasks of a frame on several threads.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::schema::{ErrorCode, SceneError};

/// Runs the tasks, one thread for each worker, and returns whether all were done. The result of a task must not depend on
/// the worker. If a task panics, the others stop, and the panic becomes an error.
pub(super) fn run<W: Send, T: Send>(
    workers: &mut [W],
    cancel: &AtomicBool,
    tasks: Vec<T>,
    work: impl Fn(&mut W, T) + Sync,
) -> Result<bool, SceneError> {
    let tasks = Mutex::new(tasks.into_iter());
    let failed = AtomicBool::new(false);
    let all = |worker: &mut W| {
        while !cancel.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
            let next = tasks.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some(task) = next else { break };
            if catch_unwind(AssertUnwindSafe(|| work(worker, task))).is_err() {
                failed.store(true, Ordering::Relaxed);
            }
        }
    };
    match workers {
        [] => return Ok(false),
        [worker] => all(worker),
        workers => turner_host::thread::scope(|scope| {
            let all = &all;
            let Some((first, others)) = workers.split_first_mut() else { return };
            for worker in others {
                scope.spawn(move || all(worker));
            }
            all(first);
        }),
    }
    if failed.load(Ordering::Relaxed) {
        return Err(SceneError::new(ErrorCode::Internal, "a fault while drawing a preview")
            .help("this is a bug in Turner: please report it"));
    }
    Ok(!cancel.load(Ordering::Relaxed))
}
