//! Turns: a run works on a value in slices, between which others read it.
//!
//! ```text
//! run      ── slice ──────────┐ turn ├── slice ──────────┐ turn ├── slice ── end
//! reader A      asks ┄┄┄┄┄┄┄┄┄ looks                     ┆      ┆
//! reader B               asks  looks   asks ┄┄┄┄┄┄┄┄┄┄┄┄┄ looks
//! ```
//!
//! Without readers a run never gives up the value. A reader that comes ends the slice once it has lasted [`SLICE`]; all
//! that have asked by then look, and the next slice begins. So neither readers nor the run wait for the other for long,
//! however often someone reads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The time that a run works at least between two turns of readers.
const SLICE: Duration = Duration::from_millis(50);

/// A value that one run at a time changes, slice by slice, and that others read meanwhile.
pub(crate) struct Turns<T> {
    value: Mutex<T>,
    /// Held by a run, and by changes that wait for its end.
    running: Mutex<()>,
    state: Mutex<State>,
    changed: Condvar,
    /// Ends the slice: a reader waits, or the run is cancelled.
    stop: AtomicBool,
    cancelled: AtomicBool,
}

struct State {
    phase: Phase,
    /// Readers that have asked since the last turn.
    waiting: usize,
    /// Readers of this turn that have not looked yet.
    admitted: usize,
    /// The number of turns that were given.
    turn: u64,
    /// The least time of later slices.
    slice: Duration,
}

impl State {
    /// A slice that begins now.
    fn slice(&self) -> Phase {
        Phase::Slice { begun: Instant::now(), least: self.slice }
    }
}

#[derive(Clone, Copy)]
enum Phase {
    /// Nothing runs: everyone may read.
    Idle,
    /// The run works on the value.
    Slice { begun: Instant, least: Duration },
    /// The run waits until the admitted readers have looked.
    Turn,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T> Turns<T> {
    pub(crate) fn new(value: T) -> Turns<T> {
        let state = State { phase: Phase::Idle, waiting: 0, admitted: 0, turn: 0, slice: SLICE };
        Turns {
            value: Mutex::new(value),
            running: Mutex::default(),
            state: Mutex::new(state),
            changed: Condvar::new(),
            stop: AtomicBool::new(false),
            cancelled: AtomicBool::new(false),
        }
    }

    /// Reads the value: at once, or after the slice that runs.
    pub(crate) fn read<R>(&self, look: impl FnOnce(&T) -> R) -> R {
        let admitted = Admitted(self.ask().then_some(self));
        let result = look(&lock(&self.value));
        drop(admitted);
        result
    }

    /// Waits for a turn. Returns whether the run waits for this reader.
    fn ask(&self) -> bool {
        let mut state = lock(&self.state);
        if matches!(state.phase, Phase::Idle) {
            return false;
        }
        state.waiting += 1;
        let turn = state.turn;
        while state.turn == turn {
            let left = match state.phase {
                Phase::Slice { begun, least } => least.saturating_sub(begun.elapsed()),
                Phase::Idle | Phase::Turn => Duration::MAX,
            };
            if left.is_zero() {
                self.stop.store(true, Ordering::SeqCst);
            }
            state = if left.is_zero() || left == Duration::MAX {
                self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
            } else {
                self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0
            };
        }
        // A turn after an idle time does not wait for this reader.
        matches!(state.phase, Phase::Turn) && state.turn == turn + 1
    }

    /// Changes the value after the run, if there is one.
    pub(crate) fn change<R>(&self, change: impl FnOnce(&mut T) -> R) -> R {
        let _alone = lock(&self.running);
        change(&mut lock(&self.value))
    }

    /// Begins a run, after the one that runs.
    pub(crate) fn run(&self) -> Run<'_, T> {
        let running = lock(&self.running);
        let mut state = lock(&self.state);
        state.slice = SLICE;
        state.phase = state.slice();
        drop(state);
        Run { turns: self, _running: running }
    }

    /// Ends the run within milliseconds; without one, the next one.
    pub(crate) fn cancel(&self) {
        self.cancelled.store(true, Ordering::SeqCst);
        self.stop.store(true, Ordering::SeqCst);
    }

    /// Whether the run is to end.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::SeqCst)
    }

    /// Takes back a cancel. Returns whether there was one.
    pub(crate) fn uncancel(&self) -> bool {
        self.cancelled.swap(false, Ordering::SeqCst)
    }
}

/// A reader that the run waits for, also if it panics.
struct Admitted<'a, T>(Option<&'a Turns<T>>);

impl<T> Drop for Admitted<'_, T> {
    fn drop(&mut self) {
        if let Some(turns) = self.0 {
            lock(&turns.state).admitted -= 1;
            turns.changed.notify_all();
        }
    }
}

/// A run.
pub(crate) struct Run<'a, T> {
    turns: &'a Turns<T>,
    _running: MutexGuard<'a, ()>,
}

impl<T> Run<'_, T> {
    /// Works on the value, after a turn of the readers that have waited long enough. `work` ends soon when its flag is set.
    pub(crate) fn slice<R>(&self, work: impl FnOnce(&mut T, &AtomicBool) -> R) -> R {
        let turns = self.turns;
        let mut state = lock(&turns.state);
        if let Phase::Slice { begun, least } = state.phase
            && state.waiting > 0
            && begun.elapsed() >= least
        {
            self.admit(&mut state, Phase::Turn);
            while state.admitted > 0 {
                state = turns.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
            state.phase = state.slice();
            // Those who came meanwhile count the time of this slice.
            turns.changed.notify_all();
        }
        turns.stop.store(false, Ordering::SeqCst);
        if turns.is_cancelled() {
            turns.stop.store(true, Ordering::SeqCst);
        }
        drop(state);
        work(&mut lock(&turns.value), &turns.stop)
    }

    /// Makes later slices longer: the last one was too short to get anything done.
    pub(crate) fn lengthen(&self) {
        let mut state = lock(&self.turns.state);
        state.slice = state.slice.saturating_mul(2);
    }

    /// Does something without the value, which everyone may read meanwhile.
    pub(crate) fn aside<R>(&self, work: impl FnOnce() -> R) -> R {
        self.admit(&mut lock(&self.turns.state), Phase::Idle);
        let result = work();
        let mut state = lock(&self.turns.state);
        state.phase = state.slice();
        result
    }

    fn admit(&self, state: &mut State, phase: Phase) {
        state.phase = phase;
        state.turn += 1;
        let waiting = std::mem::take(&mut state.waiting);
        state.admitted = if matches!(phase, Phase::Turn) { waiting } else { 0 };
        self.turns.changed.notify_all();
    }
}

impl<T> Drop for Run<'_, T> {
    fn drop(&mut self) {
        self.admit(&mut lock(&self.turns.state), Phase::Idle);
    }
}
