//! Files that are read ahead. An importer asks for the files of a scene one after the other; meanwhile other threads read
//! and decode those that it will ask for.
//!
//! ```text
//!   importer:  scene.xml | a.obj |  c.png  | d.obj   ...     takes what is ready, reads what nobody has begun,
//!   threads:             |  b.obj  | e.obj |  f.png  ...     and helps with others while it waits
//! ```
//!
//! What a thread cannot read is left to the importer, which reports why. So scenes, warnings and errors do not depend on
//! the number of threads.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Most bytes that are read and not yet asked for.
const MOST: u64 = 1 << 30;

/// Files by keys `K`, decoded to `T`.
pub(crate) struct Ahead<'a, K, T> {
    read: &'a (dyn Fn(&K) -> Option<(T, u64)> + Sync),
    state: Mutex<State<K, T>>,
    changed: Condvar,
}

struct State<K, T> {
    slots: BTreeMap<K, Slot<T>>,
    /// The keys that nobody has begun, the last one first.
    left: Vec<K>,
    /// Bytes that are read and not yet asked for.
    bytes: u64,
    /// Whether the importer has ended.
    over: bool,
}

enum Slot<T> {
    Waiting,
    Begun,
    Ready(T, u64),
    /// Taken, or it could not be read.
    Gone,
}

impl<'a, K: Ord + Clone + Send, T: Send> Ahead<'a, K, T> {
    /// Runs an importer while `threads` - 1 other threads read `keys` by `read`, which returns a value and its bytes.
    pub(crate) fn run<R>(
        keys: Vec<K>,
        threads: usize,
        read: &'a (dyn Fn(&K) -> Option<(T, u64)> + Sync),
        importer: impl FnOnce(&Ahead<'a, K, T>) -> R,
    ) -> R {
        let slots: BTreeMap<K, Slot<T>> = keys.iter().map(|key| (key.clone(), Slot::Waiting)).collect();
        let helpers = threads.saturating_sub(1).min(slots.len());
        let left = if helpers > 0 { keys.into_iter().rev().collect() } else { Vec::new() };
        let state = Mutex::new(State { slots, left, bytes: 0, over: false });
        let ahead = Ahead { read, state, changed: Condvar::new() };
        turner_host::thread::scope(|scope| {
            let end = End(&ahead);
            for _ in 0..helpers {
                // Without a thread, the importer reads on its own.
                let _ = turner_host::thread::Builder::new().spawn_scoped(scope, || while ahead.help(true) {});
            }
            let made = importer(&ahead);
            drop(end);
            made
        })
    }

    fn lock(&self) -> MutexGuard<'_, State<K, T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The file, if it could be read ahead. Each file is given once.
    pub(crate) fn take(&self, key: &K) -> Option<T> {
        loop {
            let mut state = self.lock();
            let slot = state.slots.get_mut(key)?;
            match std::mem::replace(slot, Slot::Gone) {
                Slot::Waiting | Slot::Gone => return None,
                Slot::Ready(value, bytes) => {
                    state.bytes -= bytes;
                    drop(state);
                    self.changed.notify_all();
                    return Some(value);
                }
                Slot::Begun => *slot = Slot::Begun,
            }
            drop(state);
            if !self.help(false) {
                let state = self.lock();
                if matches!(state.slots.get(key), Some(Slot::Begun)) {
                    drop(self.changed.wait(state).unwrap_or_else(PoisonError::into_inner));
                }
            }
        }
    }

    /// Reads one more file; false if there is none. `waits` for room.
    fn help(&self, waits: bool) -> bool {
        let mut state = self.lock();
        while waits && state.bytes > MOST && !state.over {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.over || state.bytes > MOST {
            return false;
        }
        let key = loop {
            let Some(key) = state.left.pop() else { return false };
            if let Some(slot @ Slot::Waiting) = state.slots.get_mut(&key) {
                *slot = Slot::Begun;
                break key;
            }
        };
        drop(state);
        // If this panics, the importer must not wait for the file.
        let mut given = Given { ahead: self, key, value: None };
        given.value = (self.read)(&given.key);
        true
    }
}

/// Ends the threads, also when the importer panics.
struct End<'b, 'a, K: Ord + Clone + Send, T: Send>(&'b Ahead<'a, K, T>);

impl<K: Ord + Clone + Send, T: Send> Drop for End<'_, '_, K, T> {
    fn drop(&mut self) {
        self.0.lock().over = true;
        self.0.changed.notify_all();
    }
}

/// Puts a value in its slot when it is dropped.
struct Given<'b, 'a, K: Ord + Clone + Send, T: Send> {
    ahead: &'b Ahead<'a, K, T>,
    key: K,
    value: Option<(T, u64)>,
}

impl<K: Ord + Clone + Send, T: Send> Drop for Given<'_, '_, K, T> {
    fn drop(&mut self) {
        let mut state = self.ahead.lock();
        let slot = match self.value.take() {
            Some((value, bytes)) => {
                state.bytes += bytes;
                Slot::Ready(value, bytes)
            }
            None => Slot::Gone,
        };
        state.slots.insert(self.key.clone(), slot);
        drop(state);
        self.ahead.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn every_file_is_given_once_or_left_to_the_importer() {
        for threads in [1, 2, 5] {
            let reads = AtomicUsize::new(0);
            let read = |key: &u32| {
                reads.fetch_add(1, Ordering::Relaxed);
                // Every third file cannot be read.
                (!key.is_multiple_of(3)).then_some((key * key, u64::from(*key)))
            };
            let keys: Vec<u32> = (0..200).collect();
            let (given, again) = Ahead::run(keys.clone(), threads, &read, |ahead| {
                let given: Vec<Option<u32>> = keys.iter().map(|key| ahead.take(key)).collect();
                let again = keys.iter().filter(|key| ahead.take(key).is_some()).count();
                assert_eq!(ahead.take(&1000), None);
                (given, again)
            });
            assert_eq!(again, 0);
            for (key, value) in keys.iter().zip(given) {
                assert!(value.is_none_or(|v| v == key * key && !key.is_multiple_of(3)));
            }
            assert!(reads.load(Ordering::Relaxed) <= 200);
            assert!(threads > 1 || reads.load(Ordering::Relaxed) == 0);
        }
    }

    #[test]
    fn large_files_wait_until_they_are_asked_for() {
        let most = AtomicUsize::new(0);
        let read = |key: &u32| {
            most.fetch_max(*key as usize, Ordering::Relaxed);
            Some((*key, MOST / 2 + 1))
        };
        Ahead::run((0..50).collect(), 3, &read, |ahead| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            // Two threads may each have begun one more.
            assert!(most.load(Ordering::Relaxed) <= 4, "{most:?}");
            (0..50).for_each(|key| assert!(ahead.take(&key).is_none_or(|v| v == key)));
        });
    }

    #[test]
    fn an_importer_that_ends_early_ends_the_threads() {
        let read = |key: &u32| Some((*key, 1));
        let made = Ahead::run((0..100_000).collect(), 4, &read, |ahead| ahead.take(&99_999));
        assert!(made.is_none_or(|v| v == 99_999));
    }
}
