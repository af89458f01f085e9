//! What an interrupt does, by phase.
//!
//! Ctrl-C is one, and so is a request to terminate: its exit code is the only difference.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

const IDLE: u8 = 0;
const RENDERING: u8 = 1;
const SAVING: u8 = 2;

/// The phase of the work and the wish to stop it; shared between the worker and the main thread.
#[derive(Debug, Default)]
pub(crate) struct Control {
    /// Becomes true when rendering should stop and what there is should be saved.
    pub(crate) cancel: AtomicBool,
    phase: AtomicU8,
    /// The exit code of a program that was interrupted so.
    code: AtomicU8,
}

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
