//! A wall around the decoding crates: a panic inside one of them becomes an error.
//!
//! The exr crate panics on some damaged files. The panic is caught where it is joined, but Rust's default hook has
//! printed its text by then; a program that wants a clean terminal calls [`silence_contained_panics`] once.

use super::{ImageError, ImageFormat};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder; a panic inside comes back as [`ImageError::Damaged`].
///
/// `f` only borrows bytes and builds new values, all dropped on a panic, so nothing half-changed is seen later.
pub(super) fn contain<T>(
    name: &str,
    format: ImageFormat,
    f: impl FnOnce() -> Result<T, ImageError>,
) -> Result<T, ImageError> {
    let before = CONTAINED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(f));
    CONTAINED.set(before);
    result.unwrap_or_else(|payload| {
        // A payload may itself panic when it is dropped; ours are strings, and forgetting one is harmless.
        std::mem::forget(payload);
        Err(ImageError::damaged(name, format, "the decoder gave up on contradictory data"))
    })
}

/// Installs a panic hook that stays silent for panics that turn into an [`ImageError`] and passes all others to
/// the hook that was there before. For `main`; a library must not call it on its user's behalf.
pub fn silence_contained_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let previous = take_hook();
        set_hook(Box::new(move |info| {
            if !CONTAINED.get() {
                previous(info);
            }
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error() {
        silence_contained_panics();
        let result: Result<(), _> = contain("a.exr", ImageFormat::Exr, || panic!("boom"));
        let message = result.unwrap_err().to_string();
        assert!(message.starts_with("a.exr: damaged OpenEXR"), "{message}");
        assert!(!CONTAINED.get());
    }
}
