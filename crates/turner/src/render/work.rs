//! Parallel tasks: threads take task indices from an atomic counter.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::PassOptions;
use crate::schema::{ErrorCode, SceneError};

/// The work of a pass, in one parallel part or several.
pub(super) struct Work<'a> {
    options: &'a PassOptions<'a>,
    threads: usize,
    /// Total number of tasks of the pass.
    pub(super) parts: AtomicUsize,
    done: AtomicUsize,
}

/// A worker's iterator over task indices. It ends when there are no more tasks or the work is stopped.
pub(super) struct Tasks<'a> {
    work: &'a Work<'a>,
    next: &'a AtomicUsize,
    done: &'a AtomicUsize,
    failed: &'a AtomicBool,
    count: usize,
    busy: bool,
}

/// Tells workers to stop.
#[derive(Clone, Copy)]
pub(super) struct Stop<'a> {
    cancel: &'a AtomicBool,
    failed: &'a AtomicBool,
}

impl Stop<'_> {
    /// Whether the pass is cancelled or another worker has panicked.
    #[inline]
    pub(super) fn is_set(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.failed.load(Ordering::Relaxed)
    }
}

/// Work that has not failed.
static NO: AtomicBool = AtomicBool::new(false);

impl Stop<'static> {
    /// Never stops.
    pub(super) const NEVER: Stop<'static> = Stop { cancel: &NO, failed: &NO };
}

impl<'a> Stop<'a> {
    /// Stops when it is cancelled.
    pub(super) fn when(cancel: &'a AtomicBool) -> Stop<'a> {
        Stop { cancel, failed: &NO }
    }
}

impl<'a> Tasks<'a> {
    /// For checks during a task.
    pub(super) fn stop(&self) -> Stop<'a> {
        Stop { cancel: self.work.options.cancel, failed: self.failed }
    }

    /// Marks the current task as unfinished, because the worker stopped.
    pub(super) fn mark_unfinished(&mut self) {
        self.busy = false;
    }
}

impl Iterator for Tasks<'_> {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        if std::mem::take(&mut self.busy) {
            self.done.fetch_add(1, Ordering::Relaxed);
            let done = self.work.done.fetch_add(1, Ordering::Relaxed) + 1;
            if let Some(progress) = self.work.options.progress {
                progress(done, self.work.parts.load(Ordering::Relaxed));
            }
        }
        if self.stop().is_set() {
            return None;
        }
        let task = self.next.fetch_add(1, Ordering::Relaxed);
        self.busy = task < self.count;
        self.busy.then_some(task)
    }
}

impl<'a> Work<'a> {
    pub(super) fn new(options: &'a PassOptions<'a>) -> Work<'a> {
        let threads = match options.threads {
            0 => turner_host::thread::available(),
            n => n,
        };
        Work { options, threads, parts: AtomicUsize::new(0), done: AtomicUsize::new(0) }
    }

    /// Counts tasks as done that need no work.
    pub(super) fn skip(&self, count: usize) {
        self.done.fetch_add(count, Ordering::Relaxed);
    }

    /// Number of threads.
    pub(super) fn threads(&self) -> usize {
        self.threads
    }

    /// Runs `count` tasks on the threads and returns whether all were done. If a worker panics, the others stop,
    /// and the panic becomes an error.
    pub(super) fn run(&self, count: usize, worker: impl Fn(Tasks<'_>) + Sync) -> Result<bool, SceneError> {
        let (next, done, failed) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
        let guarded = || {
            let tasks = Tasks { work: self, next: &next, done: &done, failed: &failed, count, busy: false };
            let result = catch_unwind(AssertUnwindSafe(|| worker(tasks)));
            if result.is_err() {
                failed.store(true, Ordering::Relaxed);
            }
            result.map_err(panic_message)
        };
        let threads = self.threads.min(count).max(1);
        let mut failure = None;
        if threads == 1 {
            failure = guarded().err();
        } else {
            turner_host::thread::scope(|scope| {
                let workers: Vec<_> = (0..threads).map(|_| scope.spawn(guarded)).collect();
                for worker in workers {
                    if let Err(message) = worker.join().unwrap_or_else(|e| Err(panic_message(e))) {
                        failure.get_or_insert(message);
                    }
                }
            });
        }
        if let Some(message) = failure {
            let message = format!("a fault while rendering: {message}");
            return Err(SceneError::new(ErrorCode::Internal, message)
                .help("this is a bug in Turner: please report it"));
        }
        Ok(done.load(Ordering::Relaxed) == count)
    }
}

fn panic_message(payload: Box<dyn std::any::Any + Send>) -> String {
    match payload.downcast::<String>() {
        Ok(s) => *s,
        Err(payload) => payload.downcast_ref::<&str>().map_or("unknown".to_owned(), |s| (*s).to_owned()),
    }
}
