//! Contains panics of the decoding crates: a panic inside a decoder becomes an error.
//!
//! Decoders of untrusted files should return errors, but some, such as the exr crate, panic on certain damaged files.
//! A panic must not end a render server or a program that embeds Turner. [`contain`] runs a decoder inside
//! `catch_unwind` and converts a panic to [`ImageError::Damaged`].
//!
//! This is sound because the decoder only borrows the input and builds new values: on a panic all of them are
//! dropped, and no half-modified state remains visible. It does not protect against aborts, such as stack overflow or
//! a panic during a panic.
//!
//! Rust's default panic hook prints a message before the panic is caught. A program that wants a clean terminal calls
//! [`silence_contained_panics`] once.

use super::{ImageError, ImageFormat};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder; a panic becomes [`ImageError::Damaged`].
///
/// `f` must only borrow its input and build new values.
pub(super) fn contain<T>(
    name: &str,
    format: ImageFormat,
    f: impl FnOnce() -> Result<T, ImageError>,
) -> Result<T, ImageError> {
    let failed = || Err(ImageError::damaged(name, format, "the decoder failed on inconsistent data"));
    caught(f).unwrap_or_else(failed)
}

/// The same for any decoder; `None` if it panicked.
pub(crate) fn caught<T>(f: impl FnOnce() -> T) -> Option<T> {
    let before = CONTAINED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(f));
    CONTAINED.set(before);
    // Dropping the payload could panic again. The payloads are short strings, so leaking one is harmless.
    result.map_err(std::mem::forget).ok()
}

/// Installs a panic hook that is silent for contained panics and passes all others to the previous hook. For `main`;
/// a library must not call it on behalf of its user.
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
