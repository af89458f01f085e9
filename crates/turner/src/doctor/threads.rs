//! A parallel map over a list.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Applies `f` to each item. Results are in the order of the items and do not depend on the number of threads. `None`
/// for items that were not started before `stop` returned true.
pub(super) fn map<T: Sync, R: Send>(
    items: &[T],
    threads: usize,
    stop: &(dyn Fn() -> bool + Sync),
    f: impl Fn(&T) -> R + Sync,
) -> Vec<Option<R>> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(i) else { return done };
            if stop() {
                return done;
            }
            done.push((i, f(item)));
        }
    };
    let mut out: Vec<Option<R>> = Vec::new();
    out.resize_with(items.len(), || None);
    let threads = match threads {
        0 => turner_host::thread::available(),
        n => n,
    };
    let mut keep = |done: Vec<(usize, R)>| {
        for (i, r) in done {
            if let Some(slot) = out.get_mut(i) {
                *slot = Some(r);
            }
        }
    };
    if threads <= 1 {
        keep(work());
        return out;
    }
    let lists = turner_host::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.min(64)).map(|_| scope.spawn(work)).collect();
        // The items of a thread that panicked are `None`.
        workers.into_iter().filter_map(|w| w.join().ok()).collect::<Vec<_>>()
    });
    lists.into_iter().for_each(keep);
    out
}
