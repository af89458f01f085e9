//! Signals that ask the program to stop.

use std::sync::mpsc::Sender;

use crate::Event;
use crate::failure::INTERRUPTED;

/// Reports signals. If no handler can be installed, a signal ends the program.
#[cfg(not(unix))]
pub(crate) fn watch(events: Sender<Event>) {
    let _ = ctrlc::set_handler(move || drop(events.send(Event::Signal(INTERRUPTED))));
}

/// Reports signals, except those that the parent process ignores (`nohup`, background jobs of a script). If no handler
/// can be installed, a signal ends the program.
#[cfg(unix)]
pub(crate) fn watch(events: Sender<Event>) {
    use crate::failure::{HUNG_UP, TERMINATED};
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored();
    let kinds = [(SIGHUP, HUNG_UP), (SIGINT, INTERRUPTED), (SIGTERM, TERMINATED)];
    let handled = kinds.iter().map(|(signal, _)| *signal).filter(|s| ignored >> (s - 1) & 1 == 0);
    let Ok(mut signals) = signal_hook::iterator::Signals::new(handled) else { return };
    let report = move || {
        for signal in signals.forever() {
            let code = kinds.iter().find(|(kind, _)| *kind == signal).map_or(INTERRUPTED, |(_, code)| *code);
            if events.send(Event::Signal(code)).is_err() {
                return;
            }
        }
    };
    let _ = std::thread::Builder::new().name("signals".into()).spawn(report);
}

/// The signals that are ignored at the start, one bit each from signal 1; 0 where the system does not report them.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
