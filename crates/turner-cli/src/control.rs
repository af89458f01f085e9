//! What an interrupt does, by phase.
//!
//! Ctrl-C is one, and so is a request to terminate: its exit code is the only difference.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use turner::schema::{Memory, SceneError};

use crate::events::Events;
use crate::report::Reporter;

const IDLE: u8 = 0;
const RENDERING: u8 = 1;
const SAVING: u8 = 2;

/// The phase of the work and the wish to stop it; shared between the worker and the main thread.
#[derive(Debug, Default)]
pub struct Control {
    /// Becomes true when rendering should stop and what there is should be saved.
    pub(crate) cancel: AtomicBool,
    phase: AtomicU8,
    /// The memory that loading may take, while there is a scene.
    memory: Mutex<Option<Arc<Memory>>>,
    /// Memory ran out while there was something to save.
    starved: AtomicBool,
    /// Where programs hear why the command ends.
    events: Mutex<Option<Events>>,
    /// The exit code of a program that was interrupted so.
    code: AtomicU8,
}

/// How often memory is looked at, at most and at least.
const INTERVALS: [Duration; 2] = [Duration::from_millis(1), Duration::from_millis(100)];

/// Bytes that all threads together fill in a millisecond.
const GROWTH: u64 = 8 << 20;

/// How near the limit memory ends: what may be filled between two looks.
const MARGIN: u64 = 16 << 20;

impl Control {
    /// From here on an interrupt asks for what is rendered to be saved.
    pub(crate) fn begin_rendering(&self) {
        self.phase.store(RENDERING, Ordering::SeqCst);
    }

    /// From here on an interrupt waits for the file, which takes moments.
    pub(crate) fn begin_saving(&self) {
        self.phase.store(SAVING, Ordering::SeqCst);
    }

    /// There is nothing to lose any more.
    pub(crate) fn end(&self) {
        self.phase.store(IDLE, Ordering::SeqCst);
    }

    /// Whether rendering was asked to stop.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }

    /// The exit code of work that was interrupted: 128 and the signal's number.
    pub(crate) fn exit_code(&self) -> u8 {
        self.code.load(Ordering::SeqCst)
    }

    /// Asks the work to stop and end with this exit code. False if the program should leave at once: it was asked before,
    /// or has nothing to save.
    pub(crate) fn interrupt(&self, code: u8) -> bool {
        if !self.is_interrupted() {
            self.code.store(code, Ordering::SeqCst);
        }
        self.phase.load(Ordering::SeqCst) != IDLE && !self.cancel.swap(true, Ordering::SeqCst)
    }

    /// From here on errors that end the program from outside the command go where its own do.
    pub(crate) fn hear(&self, reporter: &Reporter) {
        *self.events.lock().unwrap_or_else(PoisonError::into_inner) = reporter.events;
    }

    /// Who hears why the program ends.
    pub(crate) fn reporter(&self) -> Reporter {
        Reporter { quiet: false, events: *self.events.lock().unwrap_or_else(PoisonError::into_inner) }
    }

    /// From here on the main thread looks at how much memory there is. Whatever is large asks for memory before it takes it
    /// ([`Memory::need`]); this is for what is large because it is many small things.
    pub(crate) fn watch_memory(&self, memory: &Arc<Memory>) {
        *self.memory.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(memory));
    }

    /// When to look at the memory again: sooner the less is left.
    pub(crate) fn memory_interval(&self) -> Option<Duration> {
        let Some(memory) = self.watched() else { return Some(5 * INTERVALS[0]) };
        if memory.limit() == u64::MAX || self.starved.load(Ordering::SeqCst) {
            return None;
        }
        let left = memory.limit().saturating_sub(memory.in_use()?).saturating_sub(MARGIN);
        Some(Duration::from_millis(left / GROWTH).clamp(INTERVALS[0], INTERVALS[1]))
    }

    /// Why the program must end now, if memory has run out. While there is something to save it is saved first, and
    /// [`Control::starved`] has the error.
    pub(crate) fn out_of_memory(&self) -> Option<SceneError> {
        let memory = self.watched()?;
        if memory.in_use()?.saturating_add(MARGIN) <= memory.limit() {
            return None;
        }
        if self.phase.load(Ordering::SeqCst) == IDLE {
            return Some(memory.exhausted());
        }
        self.starved.store(true, Ordering::SeqCst);
        self.cancel.store(true, Ordering::SeqCst);
        None
    }

    /// The error of a render that was ended because memory ran out.
    pub(crate) fn starved(&self) -> Option<SceneError> {
        self.starved.load(Ordering::SeqCst).then(|| self.watched().map(|m| m.exhausted())).flatten()
    }

    fn watched(&self) -> Option<Arc<Memory>> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether a file is being put in its place.
    pub(crate) fn is_saving(&self) -> bool {
        self.phase.load(Ordering::SeqCst) == SAVING
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_interrupt_saves_and_the_second_leaves() {
        let control = Control::default();
        assert!(!control.interrupt(130) && !control.is_interrupted(), "nothing to save while loading");
        control.begin_rendering();
        assert!(control.interrupt(143) && control.is_interrupted());
        assert!(!control.interrupt(130));
        assert_eq!(control.exit_code(), 143);
    }
}
