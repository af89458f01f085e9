//! What the session's thread and the viewers share.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use axum::body::Bytes;
use turner::Picture;

use crate::call_queue::CallQueue;
use crate::outbox::Outbox;
use crate::tiles::{Shown, message};

/// Most viewers at a time.
pub(crate) const MAX_VIEWERS: usize = 64;

/// Most bytes of files that wait for their calls, of all connections together.
pub(crate) const MAX_UPLOAD: u64 = 1 << 30;

/// Pictures that changes refer to. A viewer whose picture is older gets a whole one.
const RECENT: usize = 4;

/// See the module.
#[derive(Default)]
pub(crate) struct Hub {
    pub(crate) calls: CallQueue,
    /// Ends the step that runs.
    stop: Mutex<Arc<AtomicBool>>,
    state: Mutex<State>,
    /// The message that was made last.
    made: Mutex<Option<Made>>,
    /// Bytes of files that were sent for calls to come.
    uploads: Arc<AtomicU64>,
}

/// Room for bytes of files, from their arrival until their call is made.
pub(crate) struct Reservation {
    all: Arc<AtomicU64>,
    bytes: u64,
}

impl Reservation {
    /// Takes more. Returns whether there is as much.
    pub(crate) fn take(&mut self, bytes: u64) -> bool {
        let more = |used: u64| used.checked_add(bytes).filter(|sum| *sum <= MAX_UPLOAD);
        let is_there = self.all.fetch_update(Ordering::SeqCst, Ordering::SeqCst, more).is_ok();
        self.bytes += if is_there { bytes } else { 0 };
        is_there
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.all.fetch_sub(self.bytes, Ordering::SeqCst);
    }
}

/// A message of a picture.
struct Made {
    /// The number of the picture before, that of the picture, and whether it is packed.
    of: (Option<u32>, u32, bool),
    bytes: Bytes,
}

#[derive(Default)]
struct State {
    viewers: Vec<Weak<Outbox>>,
    document: Option<Arc<str>>,
    status: Option<Arc<str>>,
    /// The newest pictures, the newest last.
    recent: VecDeque<Arc<Shown>>,
    pictures: u32,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl State {
    /// The viewers that are there.
    fn viewers(&mut self) -> Vec<Arc<Outbox>> {
        self.viewers.retain(|viewer| viewer.strong_count() > 0);
        self.viewers.iter().filter_map(Weak::upgrade).collect()
    }
}

impl Hub {
    /// Adds a viewer, who gets what is shown and then `hello`. `None` if there are too many.
    pub(crate) fn join(&self, hello: &str) -> Option<Arc<Outbox>> {
        let mut state = lock(&self.state);
        if state.viewers().len() >= MAX_VIEWERS {
            return None;
        }
        let outbox = Arc::new(Outbox::default());
        for text in state.document.iter().chain(&state.status) {
            outbox.text(Arc::clone(text));
        }
        outbox.text(hello.into());
        if let Some(shown) = state.recent.back() {
            outbox.picture(shown);
        }
        state.viewers.push(Arc::downgrade(&outbox));
        Some(outbox)
    }

    pub(crate) fn document(&self, text: Arc<str>) {
        let mut state = lock(&self.state);
        state.viewers().iter().for_each(|viewer| viewer.document(&text));
        state.document = Some(text);
    }

    pub(crate) fn status(&self, text: Arc<str>) {
        let mut state = lock(&self.state);
        state.viewers().iter().for_each(|viewer| viewer.status(&text));
        state.status = Some(text);
    }

    /// Shows a picture; `detail` is the data of its event.
    pub(crate) fn picture(&self, detail: String, picture: &Picture) {
        let mut state = lock(&self.state);
        state.pictures = state.pictures.wrapping_add(1);
        let shown = Arc::new(Shown {
            number: state.pictures,
            width: picture.width,
            height: picture.height,
            detail,
            pixels: picture.display.clone(),
            has_alpha: picture.display.iter().any(|pixel| pixel[3] != 255),
        });
        state.viewers().iter().for_each(|viewer| viewer.picture(&shown));
        state.recent.push_back(shown);
        if state.recent.len() > RECENT {
            state.recent.pop_front();
        }
    }

    /// The session has ended with a fault, and another one begins.
    pub(crate) fn fault(&self, text: Arc<str>) {
        let mut state = lock(&self.state);
        (state.document, state.status) = (None, None);
        state.recent.clear();
        state.viewers().iter().for_each(|viewer| viewer.fault(&text));
    }

    /// The message that brings a viewer from one picture to another. Viewers who keep pace share it.
    pub(crate) fn message(&self, base: Option<&Shown>, shown: &Shown, packed: bool) -> Bytes {
        let of = (base.map(|base| base.number), shown.number, packed);
        let mut made = lock(&self.made);
        if let Some(made) = made.as_ref().filter(|made| made.of == of) {
            return made.bytes.clone();
        }
        let bytes = Bytes::from(message(base, shown, packed));
        *made = Some(Made { of, bytes: bytes.clone() });
        bytes
    }

    /// The flag that ends the step of a session, from its beginning.
    pub(crate) fn set_stop(&self, flag: Arc<AtomicBool>) {
        *lock(&self.stop) = flag;
    }

    /// Ends the step that runs.
    pub(crate) fn stop_step(&self) {
        lock(&self.stop).store(true, Ordering::SeqCst);
    }

    /// Room for files; nothing is taken yet.
    pub(crate) fn room(&self) -> Reservation {
        Reservation { all: Arc::clone(&self.uploads), bytes: 0 }
    }

    /// Ends everything.
    pub(crate) fn close(&self) {
        self.calls.close();
        self.stop_step();
    }
}
