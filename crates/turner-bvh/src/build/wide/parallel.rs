//! Threads, progress and cancellation for the builders.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use turner_host::thread;

use super::super::BuildError;

/// Runs `work(0)` to `work(count - 1)` in parallel, the first on the calling thread. Results are in order. If a thread
/// cannot be started, the calling thread does its work.
pub(super) fn at_once<R: Send>(count: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    thread::scope(|scope| {
        let work = &work;
        let others: Vec<_> =
            (1..count).map(|i| (i, thread::Builder::new().spawn_scoped(scope, move || work(i)))).collect();
        let mut results = vec![work(0)];
        for (i, other) in others {
            results.push(match other {
                Ok(handle) => handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
                Err(_) => work(i),
            });
        }
        results
    })
}

/// Runs all tasks; threads take them in order. Results are in order.
pub(super) fn each<T: Send, R: Send>(threads: usize, tasks: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let threads = threads.min(tasks.len());
    if threads <= 1 {
        return tasks.into_iter().map(work).collect();
    }
    let mut results: Vec<Option<R>> = Vec::new();
    results.resize_with(tasks.len(), || None);
    let queue = Mutex::new(tasks.into_iter().zip(results.iter_mut()));
    at_once(threads, |_| {
        loop {
            let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((task, result)) = next else { return };
            *result = Some(work(task));
        }
    });
    drop(queue);
    results.into_iter().map(|result| result.expect("every task has run")).collect()
}

/// Splits a slice into `count` mutable parts; part `i` is `len * i / count..len * (i + 1) / count`.
pub(super) fn parts<T>(mut slice: &mut [T], count: usize) -> Vec<&mut [T]> {
    let len = slice.len();
    (0..count)
        .map(|i| {
            let (part, rest) =
                std::mem::take(&mut slice).split_at_mut(len * (i + 1) / count - len * i / count);
            slice = rest;
            part
        })
        .collect()
}

/// Progress of the build and its cancellation.
pub(super) struct Progress<'a> {
    report: Option<&'a (dyn Fn(f32) + Sync)>,
    cancel: Option<&'a AtomicBool>,
    done: AtomicUsize,
    total: usize,
    reported: Mutex<f32>,
}

impl<'a> Progress<'a> {
    pub(super) fn new(
        report: Option<&'a (dyn Fn(f32) + Sync)>,
        cancel: Option<&'a AtomicBool>,
        total: usize,
    ) -> Progress<'a> {
        Progress { report, cancel, done: AtomicUsize::new(0), total: total.max(1), reported: Mutex::new(0.0) }
    }

    /// Counts finished work and returns an error if the build was cancelled.
    pub(super) fn advance(&self, work: usize) -> Result<(), BuildError> {
        self.check()?;
        let done = self.done.fetch_add(work, Ordering::Relaxed) + work;
        self.tell((done as f32 / self.total as f32).min(0.99));
        self.check()
    }

    pub(super) fn check(&self) -> Result<(), BuildError> {
        match self.cancel {
            Some(cancel) if cancel.load(Ordering::Relaxed) => Err(BuildError::Cancelled),
            _ => Ok(()),
        }
    }

    /// Reports the fraction if it is larger than the last one reported.
    pub(super) fn tell(&self, fraction: f32) {
        let Some(report) = self.report else { return };
        let mut reported = self.reported.lock().unwrap_or_else(PoisonError::into_inner);
        if fraction > *reported {
            *reported = fraction;
            report(fraction);
        }
    }
}
