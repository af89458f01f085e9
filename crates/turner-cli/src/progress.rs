//! Progress: a bar on a terminal, events for programs, nothing in a pipe.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;

use crate::report::Reporter;
use crate::text;

/// Shorter renders show no bar.
const BAR_DELAY: Duration = Duration::from_millis(400);
const BAR_INTERVAL: Duration = Duration::from_millis(100);
const EVENT_INTERVAL: Duration = Duration::from_millis(250);
/// Minimum time and fraction of the work before the remaining time is estimated.
const FIRST_ESTIMATE: (Duration, f64) = (Duration::from_millis(500), 0.01);

/// Receives finished tiles from any thread and shows the progress at intervals.
pub(crate) struct Progress<'a> {
    reporter: &'a Reporter,
    bar: Option<ProgressBar>,
    start: Instant,
    state: Mutex<State>,
}

struct State {
    /// Samples per pixel: of finished passes, of the current pass, in total.
    before: u32,
    pass: u32,
    total: u32,
    /// Fraction of all the work.
    done: f64,
    next: Instant,
}

impl<'a> Progress<'a> {
    /// For work of `total` samples per pixel.
    pub(crate) fn new(reporter: &'a Reporter, total: u32) -> Progress<'a> {
        let show = reporter.events.is_none() && !reporter.quiet && std::io::stderr().is_terminal();
        let start = Instant::now();
        let first = if reporter.events.is_some() { EVENT_INTERVAL } else { BAR_DELAY };
        let state = State { before: 0, pass: 0, total: total.max(1), done: 0.0, next: start + first };
        Progress { reporter, bar: show.then(bar), start, state: Mutex::new(state) }
    }

    /// A pass of `samples` per pixel begins.
    pub(crate) fn begin_pass(&self, samples: u32) {
        let mut state = self.lock();
        state.before += state.pass;
        state.pass = samples;
    }

    /// `done` of `tiles` tiles of this pass are finished.
    pub(crate) fn tile(&self, done: usize, tiles: usize) {
        let mut state = self.lock();
        let fraction = done as f64 / tiles.max(1) as f64;
        let total = (f64::from(state.before) + fraction * f64::from(state.pass)) / f64::from(state.total);
        // Threads may report out of order.
        state.done = state.done.max(total);
        let now = Instant::now();
        if now < state.next {
            return;
        }
        state.next = now + if self.reporter.events.is_some() { EVENT_INTERVAL } else { BAR_INTERVAL };
        let left = self.seconds_left(state.done);
        if let Some(events) = self.reporter.events {
            events.send(json!({
                "event": "progress",
                "done": state.done,
                "seconds": self.start.elapsed().as_secs_f64(),
                "seconds_left": left,
            }));
        } else if let Some(bar) = &self.bar {
            bar.set_position((state.done * 1000.0) as u64);
            // Rounded down: 100 % means complete.
            let percent = (state.done * 100.0).floor();
            let left = left.map_or(String::new(), |s| format!("  about {} left", rough(s)));
            bar.set_message(format!("{percent:>3} %{left}"));
            bar.tick();
        }
    }

    /// Removes the bar and returns the fraction of the work that is done.
    pub(crate) fn finish(self) -> f64 {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        self.lock().done
    }

    /// Extrapolates the mean rate since the beginning.
    fn seconds_left(&self, done: f64) -> Option<f64> {
        let elapsed = self.start.elapsed();
        (elapsed >= FIRST_ESTIMATE.0 && done >= FIRST_ESTIMATE.1)
            .then(|| elapsed.as_secs_f64() * (1.0 - done) / done)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|e| e.into_inner())
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    match ProgressStyle::with_template("{bar:32} {msg}") {
        Ok(style) => bar.with_style(style.progress_chars("━━ ")),
        Err(_) => bar,
    }
}

/// A rounded estimate.
fn rough(seconds: f64) -> String {
    if seconds < 1.0 {
        "1 s".into()
    } else {
        text::seconds(seconds.ceil()).replace(".00", "").replace(".0", "")
    }
}
