//! Tasks of a pilot run on several threads.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Applies `f` to each number below `count`. Results are in order and do not depend on the number of threads (0: all
/// available). `worker` makes the state of a thread, on which a result must not depend.
pub(in crate::integrator) fn map<W, R: Send>(
    count: usize,
    threads: usize,
    worker: impl Fn() -> W + Sync,
    f: impl Fn(&mut W, usize) -> R + Sync,
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let work = || {
        let (mut state, mut done) = (worker(), Vec::new());
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= count {
                return done;
            }
            done.push((i, f(&mut state, i)));
        }
    };
    let threads = match threads {
        0 => turner_host::thread::available(),
        n => n,
    };
    let mut done = turner_host::thread::scope(|scope| {
        let helpers: Vec<_> = (1..threads.min(count)).map(|_| scope.spawn(work)).collect();
        let mut done = work();
        for helper in helpers {
            done.extend(helper.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        done
    });
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order() {
        for threads in [0, 1, 2, 5, 100] {
            assert_eq!(map(37, threads, || (), |(), i| i * i), (0..37).map(|i| i * i).collect::<Vec<_>>());
        }
        assert!(map(0, 3, || (), |(), i| i).is_empty());
    }
}
