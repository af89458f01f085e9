//! The effect of an interrupt in each phase of the work, and the memory watch.
//!
//! Ctrl-C and a request to terminate differ only in the exit code. Signals that arrive within half a second of the
//! first one are the same request: `timeout` signals the program and then its whole process group, and a shell that
//! closes does the same.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use turner::schema::{Memory, SceneError};

use crate::events::Events;
use crate::report::Reporter;

const IDLE: u8 = 0;
const RENDERING: u8 = 1;
const SAVING: u8 = 2;

/// The phase of the work and the request to stop it; shared between the worker and the main thread.
#[derive(Debug)]
pub struct Control {
    /// When the program started.
    pub(crate) begun: Instant,
    /// True when rendering should stop and save the picture.
    pub(crate) cancel: AtomicBool,
    phase: AtomicU8,
    /// The memory limit, from the time a scene is loaded.
    memory: Mutex<Option<Arc<Memory>>>,
    /// Whether memory ran out while there was a picture to save.
    starved: AtomicBool,
    /// The destination of errors that the main thread reports.
    events: Mutex<Option<Events>>,
    /// The exit code after the interrupt.
    code: AtomicU8,
    /// When the first interrupt arrived.
    first: Mutex<Option<Instant>>,
    /// True when the passes of the renderer should return: after an interrupt, or for a checkpoint.
    pub(crate) pause: AtomicBool,
}

impl Default for Control {
    fn default() -> Control {
        Control {
            begun: Instant::now(),
            cancel: AtomicBool::default(),
            phase: AtomicU8::default(),
            memory: Mutex::default(),
            starved: AtomicBool::default(),
            events: Mutex::default(),
            code: AtomicU8::default(),
            first: Mutex::default(),
            pause: AtomicBool::default(),
        }
    }
}

/// What a signal asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interrupt {
    /// Stop rendering and save.
    Stop,
    /// Nothing new: it belongs to the first signal.
    Same,
    /// End the program at once: nothing is there to save, or the user asks a second time.
    Exit,
}

/// Signals within this time of the first are the same request.
const SAME: Duration = Duration::from_millis(500);

/// Shortest and longest interval between memory checks.
const INTERVALS: [Duration; 2] = [Duration::from_millis(1), Duration::from_millis(100)];

/// Bytes that all threads together can allocate in a millisecond, an upper estimate.
const GROWTH: u64 = 8 << 20;

/// Margin below the limit: memory that may be allocated between two checks.
const MARGIN: u64 = 16 << 20;

impl Control {
    /// From here on an interrupt stops rendering and saves the picture.
    pub(crate) fn begin_rendering(&self) {
        self.phase.store(RENDERING, Ordering::SeqCst);
    }

    /// From here on an interrupt waits for the output file.
    pub(crate) fn begin_saving(&self) {
        self.phase.store(SAVING, Ordering::SeqCst);
    }

    /// From here on an interrupt ends the program at once.
    pub(crate) fn end(&self) {
        self.phase.store(IDLE, Ordering::SeqCst);
    }

    /// Whether rendering should stop.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }

    /// The exit code of interrupted work: 128 + the number of the signal.
    pub(crate) fn exit_code(&self) -> u8 {
        self.code.load(Ordering::SeqCst)
    }

    /// A signal with this exit code, at this time.
    pub(crate) fn interrupt(&self, code: u8, now: Instant) -> Interrupt {
        let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(first) = *first {
            return if now.saturating_duration_since(first) < SAME {
                Interrupt::Same
            } else {
                Interrupt::Exit
            };
        }
        self.code.store(code, Ordering::SeqCst);
        if self.phase.load(Ordering::SeqCst) == IDLE {
            return Interrupt::Exit;
        }
        *first = Some(now);
        self.stop();
        Interrupt::Stop
    }

    /// Stops rendering.
    fn stop(&self) {
        self.cancel.store(true, Ordering::SeqCst);
        self.pause.store(true, Ordering::SeqCst);
    }

    /// From here on errors of the main thread are reported like those of the command.
    pub(crate) fn hear(&self, reporter: &Reporter) {
        *self.events.lock().unwrap_or_else(PoisonError::into_inner) = reporter.events;
    }

    /// The reporter of errors.
    pub(crate) fn reporter(&self) -> Reporter {
        Reporter { quiet: false, events: *self.events.lock().unwrap_or_else(PoisonError::into_inner) }
    }

    /// From here on the main thread checks the memory in use. Large allocations are checked beforehand
    /// ([`Memory::need`]); this catches many small ones.
    pub(crate) fn watch_memory(&self, memory: &Arc<Memory>) {
        *self.memory.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(memory));
    }

    /// Time until the next memory check: shorter when less memory is left.
    pub(crate) fn memory_interval(&self) -> Option<Duration> {
        let Some(memory) = self.watched() else { return Some(5 * INTERVALS[0]) };
        if memory.limit() == u64::MAX || self.starved.load(Ordering::SeqCst) {
            return None;
        }
        let left = memory.limit().saturating_sub(memory.in_use()?).saturating_sub(MARGIN);
        Some(Duration::from_millis(left / GROWTH).clamp(INTERVALS[0], INTERVALS[1]))
    }

    /// The error if memory ran out and the program must end now. If there is a picture to save, rendering stops
    /// instead, and [`Control::starved`] returns the error.
    pub(crate) fn out_of_memory(&self) -> Option<SceneError> {
        let memory = self.watched()?;
        if memory.in_use()?.saturating_add(MARGIN) <= memory.limit() {
            return None;
        }
        if self.phase.load(Ordering::SeqCst) == IDLE {
            return Some(memory.exhausted());
        }
        self.starved.store(true, Ordering::SeqCst);
        self.stop();
        None
    }

    /// The error of a render that stopped because memory ran out.
    pub(crate) fn starved(&self) -> Option<SceneError> {
        self.starved.load(Ordering::SeqCst).then(|| self.watched().map(|m| m.exhausted())).flatten()
    }

    /// The memory limit; none before a scene is loaded.
    pub(crate) fn memory(&self) -> Arc<Memory> {
        self.watched().unwrap_or_default()
    }

    fn watched(&self) -> Option<Arc<Memory>> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether the output file is being written.
    pub(crate) fn is_saving(&self) -> bool {
        self.phase.load(Ordering::SeqCst) == SAVING
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_interrupt_saves_and_a_late_one_exits() {
        let (control, now) = (Control::default(), Instant::now());
        assert_eq!(control.interrupt(130, now), Interrupt::Exit, "nothing to save while loading");
        assert!(!control.is_interrupted());
        control.begin_rendering();
        assert_eq!(control.interrupt(143, now), Interrupt::Stop);
        assert!(control.is_interrupted() && control.pause.load(Ordering::SeqCst));
        for (milliseconds, what) in [(0, Interrupt::Same), (499, Interrupt::Same), (501, Interrupt::Exit)] {
            assert_eq!(control.interrupt(130, now + Duration::from_millis(milliseconds)), what);
        }
        assert_eq!(control.exit_code(), 143);
        // Once everything is written, it is as while loading.
        control.end();
        assert_eq!(control.interrupt(130, now + SAME), Interrupt::Exit);
    }
}
