//! The command line of Turner: arguments, messages, files. It owns no rendering.
//!
//! ```text
//! main ── start ── cli ─┬─ render   scene ─> picture file      ┌─ scene      load, prepare, overrides
//!                       ├─ resume   continue a checkpoint      ├─ checkpoint samples on disk
//!                       ├─ merge    parts of a picture         ├─ output     the output file
//!                       ├─ farm     jobs for queues            │
//!                       ├─ remake   a picture from its header  ├─ recipe     its making in the header
//!                       ├─ info     contents of a scene        │
//!                       ├─ list     names                      ├─ report     errors, warnings, events
//!                       ├─ help     ── lookup ── reference     ├─ usage      errors of arguments
//!                       │                                      └─ progress   bar and time left
//!                       ├─ bench    render speed of this machine
//!                       ├─ verify   statistical tests
//!                       ├─ explain  the rays behind a pixel
//!                       ├─ doctor   why a picture is black, noisy, washed out, slow
//!                       ├─ compare  error metrics of two pictures
//!                       ├─ tonemap  display values from scene values
//!                       ├─ view     contents of a picture file
//!                       ├─ convert  a scene to another format
//!                       ├─ watch    render after each change
//!                       ├─ new      ── templates
//!                       ├─ window   starts Turner Studio
//!                       ├─ serve    the page, for browsers
//!                       └─ completions, man ── shell
//! ```
//!
//! Public items are those that other programs use. `turner-lab`: measuring scenes, running checks, messages and failures.
//! `turner-python`: explanations, findings and cameras as JSON, pages of the reference, and the command line itself.
//!
//! The work runs on a second thread. The main thread waits for its end or for a signal, so that a second Ctrl-C ends
//! the program at once and only `main` exits the process.
#![forbid(unsafe_code)]

mod animation;
mod aovs;
pub mod bench;
pub mod camera;
mod checkpoint;
mod cli;
pub mod color;
pub mod command_line;
mod compare;
mod control;
pub mod convert;
pub mod doctor;
mod encoding;
pub mod error_pages;
pub mod events;
pub mod explain;
pub mod failure;
mod farm;
mod film_picture;
mod flags;
mod foreign;
mod header;
mod help;
mod info;
pub mod instructions;
pub mod limits;
mod list;
mod lookup;
mod merge;
mod new;
mod options;
mod output;
mod picture_file;
mod preview;
mod progress;
mod recipe;
pub mod reference;
mod remake;
mod render;
pub mod report;
mod resume;
mod run_args;
mod scene;
mod sequence;
mod serve;
mod shell;
mod signals;
mod studio;
pub mod text;
mod tonemap;
mod topics;
mod usage;
pub mod verify;
mod view;
mod watch;
mod window;

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

pub use control::Control;
use control::Interrupt;
use failure::Failure;
pub use render::threads;
use turner::schema::{ErrorCode, SceneError};

/// Every word that `turner help` explains, without those of other programs.
pub fn words() -> std::collections::BTreeSet<String> {
    let cli = cli::command();
    let mut words = lookup::words(&cli);
    words.extend(cli::command_names());
    words
}

/// The text of `turner help WORD`; `None` if the word is unknown.
pub fn explained(word: &str) -> Option<String> {
    let mut cli = cli::command();
    cli.build();
    lookup::explain(word, &cli).or_else(|| cli.find_subcommand(word).map(ToString::to_string))
}

/// All remedies for words of other programs.
pub fn remedies() -> Vec<&'static str> {
    use turner::schema::foreign::{KEYS, KINDS};
    KEYS.iter().chain(KINDS).map(|f| f.remedy).chain(foreign::OPTIONS.iter().map(|o| o.remedy)).collect()
}

/// An event that the main thread waits for.
enum Event {
    /// The command ended with this exit code.
    Done(u8),
    /// Ctrl-C or a request to terminate, with its exit code.
    Signal(u8),
}

/// The longest time that a second Ctrl-C waits for an output file that is being written.
const SAVING: Duration = Duration::from_secs(2);

/// Runs the command given by the arguments of the process. Exit codes: 0 success, 1 bad input or failure, 2 bad usage,
/// 130 after an interrupt, 143 after a request to terminate.
pub fn start() -> ExitCode {
    start_with(cli::run)
}

/// [`start`] for another program: `run` gets the arguments of the process and returns the exit code.
pub fn start_with(run: fn(Vec<OsString>, &Control) -> u8) -> ExitCode {
    ExitCode::from(begin(run, std::env::args_os().collect()))
}

/// [`start`] with other arguments than those of the process: for a program that has the command line in it. The first
/// one is the name of the program.
pub fn start_from(args: Vec<OsString>) -> ExitCode {
    ExitCode::from(run_from(args))
}

/// [`start_from`] that returns the exit code as a number, for programs that are not Rust's. It sets handlers of signals
/// and panics for the whole process.
pub fn run_from(args: Vec<OsString>) -> u8 {
    begin(cli::run, args)
}

fn begin(run: fn(Vec<OsString>, &Control) -> u8, args: Vec<OsString>) -> u8 {
    let fault: Arc<Mutex<Option<String>>> = Arc::default();
    install_panic_hook(Arc::clone(&fault));
    let control = Arc::new(Control::default());
    let (sender, events) = channel();
    signals::watch(sender.clone());
    let worker = spawn(move |control| run(args, control), sender, Arc::clone(&control), fault);
    if let Err(error) = worker {
        report::print_error(&internal(&format!("cannot start a thread: {error}")));
        return failure::FAILED;
    }
    loop {
        let event = match control.memory_interval() {
            None => events.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(interval) => events.recv_timeout(interval),
        };
        match event {
            Err(RecvTimeoutError::Timeout) => {
                if let Some(error) = control.out_of_memory() {
                    control.reporter().failure(&Failure::new(error));
                    return failure::FAILED;
                }
            }
            Ok(Event::Done(code)) => return code,
            Ok(Event::Signal(code)) => {
                if control.interrupt(code, Instant::now()) == Interrupt::Exit {
                    if control.is_saving() {
                        wait_for_end(&events);
                    }
                    return code;
                }
            }
            Err(RecvTimeoutError::Disconnected) => return failure::FAILED,
        }
    }
}

/// Waits until the command ends, but not for long. More signals change nothing.
fn wait_for_end(events: &Receiver<Event>) {
    let end = Instant::now() + SAVING;
    while let Some(left) = end.checked_duration_since(Instant::now()) {
        if !matches!(events.recv_timeout(left), Ok(Event::Signal(_))) {
            return;
        }
    }
}

/// Runs the command on a thread with a stack of known size.
fn spawn(
    run: impl FnOnce(&Control) -> u8 + Send + 'static,
    sender: Sender<Event>,
    control: Arc<Control>,
    fault: Arc<Mutex<Option<String>>>,
) -> std::io::Result<()> {
    const STACK: usize = 8 << 20;
    let work = move || {
        let work = AssertUnwindSafe(|| run(&control));
        let code = catch_unwind(work).unwrap_or_else(|_| {
            let fault = fault.lock().unwrap_or_else(|e| e.into_inner()).take();
            control.reporter().failure(&internal(&fault.unwrap_or_default()));
            failure::FAILED
        });
        // The receiver is gone if the main thread has ended.
        let _ = sender.send(Event::Done(code));
    };
    std::thread::Builder::new().name("turner".into()).stack_size(STACK).spawn(work).map(drop)
}

fn internal(what: &str) -> Failure {
    let message = format!("internal error: {what}");
    Failure::new(
        SceneError::new(ErrorCode::Internal, message).help("this is a bug in Turner: please report it"),
    )
}

/// A panic is reported once, where it is caught; the hook only stores its message.
fn install_panic_hook(fault: Arc<Mutex<Option<String>>>) {
    std::panic::set_hook(Box::new(move |info: &PanicHookInfo<'_>| {
        let message = info.payload_as_str().unwrap_or("unknown");
        let position = info.location().map_or(String::new(), |l| format!(" ({}:{})", l.file(), l.line()));
        *fault.lock().unwrap_or_else(|e| e.into_inner()) = Some(format!("{message}{position}"));
    }));
    turner_io::image::silence_contained_panics();
}
