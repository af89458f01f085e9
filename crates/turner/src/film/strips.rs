//! Values computed in strips by several threads, in any order: each depends on its own place only.

use std::sync::Mutex;

/// Values of a strip: enough that the lock between two strips costs nothing.
const STRIP: usize = 1 << 14;

/// A vector of `count` values, filled in strips of `length`: `work` gets the index of the first value of a strip, and
/// the strip. `threads` of 0 uses all; 1 starts none.
pub(crate) fn filled<T: Clone + Default + Send>(
    count: usize,
    length: usize,
    threads: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) -> Vec<T> {
    let mut out = vec![T::default(); count];
    let length = length.max(1);
    let strips = Mutex::new(out.chunks_mut(length).enumerate());
    let all = || {
        loop {
            let next = strips.lock().unwrap_or_else(|e| e.into_inner()).next();
            let Some((i, strip)) = next else { break };
            work(i * length, strip);
        }
    };
    run(all, threads, count.div_ceil(length));
    out
}

/// The same in strips of whole rows of `columns` values.
pub(crate) fn rows<T: Clone + Default + Send>(
    columns: usize,
    rows: usize,
    threads: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) -> Vec<T> {
    let length = STRIP.div_ceil(columns.max(1)) * columns;
    filled(columns * rows, length, threads, |first, strip| {
        let top = first / columns;
        strip.chunks_mut(columns).zip(top..).for_each(|(row, y)| work(y, row));
    })
}

/// `of` of each index below `count`.
pub(crate) fn map<T: Clone + Default + Send>(
    count: usize,
    threads: usize,
    of: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    filled(count, STRIP, threads, |first, strip| {
        strip.iter_mut().enumerate().for_each(|(i, value)| *value = of(first + i));
    })
}

/// `of` of each index below `count`, one at a time; each thread has a state of its own.
pub(crate) fn with<T: Send, S>(
    count: usize,
    threads: usize,
    state: impl Fn() -> S + Sync,
    of: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let mut out: Vec<Option<T>> = (0..count).map(|_| None).collect();
    let next = Mutex::new(out.iter_mut().enumerate());
    let all = || {
        let mut state = state();
        loop {
            let place = next.lock().unwrap_or_else(|e| e.into_inner()).next();
            let Some((i, place)) = place else { break };
            *place = Some(of(&mut state, i));
        }
    };
    run(all, threads, count);
    out.into_iter().flatten().collect()
}

/// Runs `work` on `threads` threads, but no more than there are `tasks`. 0 uses all; 1 starts none.
fn run(work: impl Fn() + Sync, threads: usize, tasks: usize) {
    let threads = match threads {
        0 => turner_host::thread::available(),
        n => n,
    };
    let more = threads.min(tasks).saturating_sub(1);
    if more == 0 {
        return work();
    }
    turner_host::thread::scope(|scope| {
        (0..more).for_each(|_| {
            scope.spawn(&work);
        });
        work();
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_computed_once_on_any_number_of_threads() {
        for (count, length) in [(0, 1), (1, 7), (5000, 0), (7 * 901, 7), (7 * 901 + 3, 70)] {
            for threads in [0, 1, 2, 5] {
                let found = filled(count, length, threads, |first, strip: &mut [usize]| {
                    strip.iter_mut().enumerate().for_each(|(i, v)| *v += first + i + 1);
                });
                assert!(found.iter().enumerate().all(|(i, v)| *v == i + 1), "{count} {length} {threads}");
                let mapped = map(count, threads, |i| i + 1);
                assert_eq!(found, mapped);
            }
        }
        let found = rows(300, 200, 3, |y, row: &mut [usize]| row.iter_mut().for_each(|v| *v += y));
        assert!(found.iter().enumerate().all(|(i, v)| *v == i / 300));
    }
}
