//! The exports of the WebAssembly module: one session for each memory.
//!
//! The page's script calls them with addresses in the module's memory; `page/core.js` is the other side. Texts are UTF-8.
//! A panic ends the instance; its message reaches the page by the import `turner.fault`.

use std::alloc::{Layout, alloc, dealloc};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde_json::{Value as Json, json};
use turner::Picture;
use turner::schema::{Limits, Memory};

use crate::session::{Event, Reply, Session};

#[link(wasm_import_module = "turner")]
unsafe extern "C" {
    /// Tells the message of a panic.
    #[link_name = "fault"]
    fn fault(text: *const u8, length: usize);
}

/// What the exports work on.
#[derive(Default)]
struct State {
    session: Option<Session>,
    /// Files for the next call.
    files: Vec<(String, Vec<u8>)>,
    /// What the last export answered: JSON and bytes.
    json: Vec<u8>,
    bytes: Answer,
    events: Vec<Event>,
}

/// Bytes of an answer.
#[derive(Default)]
enum Answer {
    #[default]
    None,
    Bytes(Vec<u8>),
    Picture(Arc<Picture>),
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

fn state() -> MutexGuard<'static, Option<State>> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn with<T>(work: impl FnOnce(&mut State) -> T) -> T {
    work(state().get_or_insert_default())
}

/// Layout of a block of memory for the page's script.
fn layout(length: usize) -> Option<Layout> {
    Layout::from_size_align(length.max(1), 16).ok()
}

/// Memory for the page's script: `length` bytes, aligned to 16. 0 if there is no room.
#[unsafe(no_mangle)]
extern "C" fn turner_alloc(length: usize) -> *mut u8 {
    // SAFETY: the layout has at least one byte.
    layout(length).map_or(std::ptr::null_mut(), |layout| unsafe { alloc(layout) })
}

/// Frees what `turner_alloc` gave, with the same length.
///
/// # Safety
///
/// `at` is from `turner_alloc(length)` and is not used any more.
#[unsafe(no_mangle)]
unsafe extern "C" fn turner_free(at: *mut u8, length: usize) {
    if let Some(layout) = layout(length) {
        // SAFETY: as above.
        unsafe { dealloc(at, layout) }
    }
}

/// The bytes at an address.
///
/// # Safety
///
/// `length` bytes at `at` are initialised and do not change meanwhile.
unsafe fn bytes<'a>(at: *const u8, length: usize) -> &'a [u8] {
    // SAFETY: as above.
    unsafe { std::slice::from_raw_parts(at, length) }
}

/// Begins a session. `limit` is the most memory that it may use, in bytes.
#[unsafe(no_mangle)]
extern "C" fn turner_begin(limit: f64) {
    std::panic::set_hook(Box::new(|info| {
        let text = info.to_string();
        // SAFETY: the text lives during the call.
        unsafe { fault(text.as_ptr(), text.len()) }
    }));
    let in_use = || Some(core::arch::wasm32::memory_size(0) as u64 * 65_536);
    let memory = Memory::new(limit as u64, in_use);
    let limits = Limits { memory: Arc::new(memory), ..Limits::default() };
    with(|state| state.session = Some(Session::new(0, limits)));
}

/// A file for the next call.
///
/// # Safety
///
/// Both ranges are initialised.
#[unsafe(no_mangle)]
unsafe extern "C" fn turner_put(name: *const u8, name_length: usize, at: *const u8, length: usize) {
    // SAFETY: as above.
    let (name, bytes) = unsafe { (bytes(name, name_length), bytes(at, length)) };
    let name = String::from_utf8_lossy(name).into_owned();
    with(|state| state.files.push((name, bytes.to_vec())));
}

/// Makes a call: a JSON object with `do` and its arguments. The answer, with `ok` or `error`, is at `turner_json`, its
/// bytes at `turner_bytes`.
///
/// # Safety
///
/// The range is initialised.
#[unsafe(no_mangle)]
unsafe extern "C" fn turner_call(at: *const u8, length: usize) {
    // SAFETY: as above.
    let text = unsafe { bytes(at, length) };
    with(|state| {
        let files = std::mem::take(&mut state.files);
        state.bytes = Answer::None;
        let answer = match (serde_json::from_slice::<Json>(text), &mut state.session) {
            (Ok(args), Some(session)) => {
                let name = args.get("do").and_then(Json::as_str).unwrap_or_default();
                match session.call(name, &args, files) {
                    Ok(Reply { json, bytes }) => {
                        state.bytes = Answer::Bytes(bytes);
                        json!({ "ok": json })
                    }
                    Err(error) => json!({ "error": error.json() }),
                }
            }
            (Err(error), _) => json!({ "error": { "message": error.to_string() } }),
            (_, None) => json!({ "error": { "message": "the session has not begun" } }),
        };
        state.json = answer.to_string().into_bytes();
    });
}

/// Does the next piece of rendering. 1 if there is more to do.
#[unsafe(no_mangle)]
extern "C" fn turner_step() -> u32 {
    with(|state| state.session.as_mut().map_or(0, |session| u32::from(session.step())))
}

/// Takes the next event: 1 if there is one. Its kind and its data are at `turner_json`; the pixels of a frame, as RGBA,
/// are at `turner_bytes`.
#[unsafe(no_mangle)]
extern "C" fn turner_event() -> u32 {
    with(|state| {
        if state.events.is_empty() {
            state.events = state.session.as_mut().map_or_else(Vec::new, Session::events);
            state.events.reverse();
        }
        let Some(event) = state.events.pop() else { return 0 };
        let (kind, data, bytes) = match event {
            Event::Frame(data, picture) => ("frame", data, Answer::Picture(picture)),
            Event::Status(data) => ("status", data, Answer::None),
            Event::Document(data) => ("document", data, Answer::None),
        };
        state.json = json!({ "event": kind, "detail": data }).to_string().into_bytes();
        state.bytes = bytes;
        1
    })
}

/// The address of the last answer's JSON.
#[unsafe(no_mangle)]
extern "C" fn turner_json() -> *const u8 {
    with(|state| state.json.as_ptr())
}

/// Its length in bytes.
#[unsafe(no_mangle)]
extern "C" fn turner_json_length() -> usize {
    with(|state| state.json.len())
}

fn answered(state: &State) -> &[u8] {
    match &state.bytes {
        Answer::None => &[],
        Answer::Bytes(bytes) => bytes,
        Answer::Picture(picture) => picture.display.as_flattened(),
    }
}

/// The address of the last answer's bytes.
#[unsafe(no_mangle)]
extern "C" fn turner_bytes() -> *const u8 {
    with(|state| answered(state).as_ptr())
}

/// Their number.
#[unsafe(no_mangle)]
extern "C" fn turner_bytes_length() -> usize {
    with(|state| answered(state).len())
}

/// Frees the last answer's bytes.
#[unsafe(no_mangle)]
extern "C" fn turner_forget() {
    with(|state| state.bytes = Answer::None);
}

/// The address of the byte that ends the step that runs when another thread sets it to 1. It stays the same.
#[unsafe(no_mangle)]
extern "C" fn turner_stop() -> *const u8 {
    with(|state| state.session.as_ref().map_or(std::ptr::null(), |session| session.stop().as_ptr().cast()))
}

/// Threads that render.
#[unsafe(no_mangle)]
extern "C" fn turner_threads() -> usize {
    turner_host::thread::available()
}

/// Runs tasks until the page ends the thread: for the workers of the page.
#[unsafe(no_mangle)]
extern "C" fn turner_serve() {
    turner_host::thread::serve()
}
