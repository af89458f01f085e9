//! Progress: a bar on a terminal, events for programs, nothing in a pipe.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use turner::film::Noise;

use crate::render::Budget;
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
    /// The name of the scene.
    name: &'a str,
    deadline: Option<Instant>,
    bar: Option<ProgressBar>,
    start: Instant,
    /// Fraction of the work that was done before.
    resumed: f64,
    state: Mutex<State>,
}

struct State {
    /// Samples per pixel: of finished passes, of the current pass, in total.
    before: f64,
    pass: f64,
    total: u32,
    /// When the current pass began.
    begun: Instant,
    /// Fraction of all the work.
    done: f64,
    /// The noise after some pass.
    noise: Option<f64>,
    /// The samples per pixel after which the noise is low enough, if it ends the work.
    needed: Option<f64>,
    pace: Pace,
    next: Instant,
}

/// How long samples take. Within a pass the costliest tiles come first, and the first pass waits for the choices of the
/// integrator: so whole passes are timed, and the first one counts only until the second is done.
#[derive(Clone, Copy, Debug, Default)]
struct Pace {
    /// Passes, and their samples per pixel and seconds.
    passes: u32,
    samples: f64,
    seconds: f64,
}

impl Pace {
    fn add(&mut self, samples: f64, seconds: f64) {
        if self.passes == 1 {
            (self.samples, self.seconds) = (0.0, 0.0);
        }
        self.passes += 1;
        self.samples += samples;
        self.seconds += seconds;
    }

    /// Seconds left of a pass of `pass` samples per pixel that began `since` seconds ago and has the fraction `done`,
    /// and of `after` samples per pixel after it. `None` before the first pass is done.
    fn left(&self, pass: f64, since: f64, done: f64, after: f64) -> Option<f64> {
        let each = self.seconds / self.samples;
        // A pass that takes longer than expected: the fraction tells more.
        let late = if done > 0.0 { since * (1.0 - done) / done } else { 0.0 };
        let here = if since < each * pass { each * pass - since } else { late.min(each * pass) };
        (self.samples > 0.0).then_some(here + each * after)
    }
}

impl<'a> Progress<'a> {
    /// For work of `total` samples per pixel, of which the fraction `resumed` is done. It also ends at the deadline.
    pub(crate) fn new(
        reporter: &'a Reporter,
        name: &'a str,
        total: u32,
        resumed: f64,
        deadline: Option<Instant>,
    ) -> Progress<'a> {
        let show = reporter.events.is_none() && !reporter.quiet && std::io::stderr().is_terminal();
        let start = Instant::now();
        let first = if reporter.events.is_some() { EVENT_INTERVAL } else { BAR_DELAY };
        let total = total.max(1);
        let state = State {
            before: 0.0,
            pass: 0.0,
            total,
            done: resumed,
            noise: None,
            needed: None,
            begun: start,
            pace: Pace::default(),
            next: start + first,
        };
        Progress { reporter, name, deadline, bar: show.then(bar), start, resumed, state: Mutex::new(state) }
    }

    /// A pass begins, or the rest of one that a checkpoint has interrupted: from `before` samples per pixel, on average,
    /// to `goal`.
    pub(crate) fn begin_pass(&self, before: f64, goal: u32) {
        let mut state = self.lock();
        state.before = before;
        state.pass = (f64::from(goal) - before).max(0.0);
        state.begun = Instant::now();
    }

    /// The current pass is complete.
    pub(crate) fn end_pass(&self) {
        let mut state = self.lock();
        let (samples, seconds) = (state.pass, state.begun.elapsed().as_secs_f64());
        state.pace.add(samples, seconds);
    }

    /// `done` of `tiles` tiles of this pass are finished.
    pub(crate) fn tile(&self, done: usize, tiles: usize) {
        let mut state = self.lock();
        let fraction = done as f64 / tiles.max(1) as f64;
        let samples = state.before + fraction * state.pass;
        let total = state.needed.unwrap_or(f64::from(state.total)).min(f64::from(state.total));
        // Noise falls as expected, or a little later.
        let of_samples = if state.needed.is_some() { (samples / total).min(0.99) } else { samples / total };
        let total_fraction = self.fraction_of_time().max(of_samples);
        // Threads may report out of order.
        state.done = state.done.max(total_fraction);
        let now = Instant::now();
        if now < state.next {
            return;
        }
        state.next = now + if self.reporter.events.is_some() { EVENT_INTERVAL } else { BAR_INTERVAL };
        let after = (total - state.before - state.pass).max(0.0);
        let since = (now - state.begun).as_secs_f64();
        let is_known = state.total < crate::render::UNLIMITED || state.needed.is_some();
        let paced = state.pace.left(state.pass, since, fraction, after).filter(|_| is_known);
        let left = self.seconds_left(paced, state.done);
        if let Some(events) = self.reporter.events {
            events.send(json!({
                "event": "progress",
                "done": state.done,
                "seconds": self.start.elapsed().as_secs_f64(),
                "seconds_left": left,
                "samples_per_pixel": samples,
                "noise": state.noise,
            }));
        } else if let Some(bar) = &self.bar {
            bar.set_position((state.done * 1000.0) as u64);
            // Rounded down: 100 % means complete.
            let percent = (state.done * 100.0).floor();
            let left = left.map_or(String::new(), |s| format!("  about {} left", rough(s)));
            let of = match state.total < crate::render::UNLIMITED {
                true => format!("{samples:.0} of {} samples", state.total),
                false => format!("{samples:.0} samples"),
            };
            let noise =
                state.noise.map_or(String::new(), |n| format!("  noise {}", crate::render::percent(n)));
            bar.set_message(format!("{percent:>3} %  {}  {of}{left}{noise}", self.name));
            bar.tick();
        }
    }

    /// Sets the noise after `samples` samples per pixel, which is computed only if someone sees it.
    pub(crate) fn set_noise(&self, samples: u32, budget: &Budget, noise: impl FnOnce() -> Option<Noise>) {
        if self.bar.is_some() || self.reporter.events.is_some() {
            let noise = noise().map(|noise| noise.value);
            let mut state = self.lock();
            state.noise = noise;
            state.needed = noise.and_then(|noise| budget.needed(samples, noise)).or(state.needed);
        }
    }

    /// The fraction of the time that is over, if there is a deadline.
    fn fraction_of_time(&self) -> f64 {
        let Some(deadline) = self.deadline else { return 0.0 };
        let all = deadline.saturating_duration_since(self.start).as_secs_f64();
        (self.start.elapsed().as_secs_f64() / all.max(1e-3)).min(1.0)
    }

    /// Removes the bar.
    pub(crate) fn finish(self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    /// Until the samples are done by the pace of whole passes, or the deadline, if that is sooner. In the first pass the
    /// mean rate since the beginning is extrapolated.
    fn seconds_left(&self, paced: Option<f64>, done: f64) -> Option<f64> {
        let (elapsed, here) = (self.start.elapsed(), done - self.resumed);
        let time = self.deadline.map(|end| end.saturating_duration_since(Instant::now()).as_secs_f64());
        let mean = || elapsed.as_secs_f64() * (1.0 - done) / here;
        let is_early = elapsed < FIRST_ESTIMATE.0 || here < FIRST_ESTIMATE.1;
        let samples = paced.or_else(|| (!is_early && time.is_none()).then(mean));
        match (samples, time) {
            (Some(samples), Some(time)) => Some(samples.min(time)),
            (samples, time) => samples.or(time),
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_passes_are_timed() {
        let mut pace = Pace::default();
        assert_eq!(pace.left(1.0, 5.0, 0.5, 63.0), None);
        // The first pass chose for four seconds.
        pace.add(1.0, 5.0);
        assert_eq!(pace.left(1.0, 0.0, 0.0, 10.0), Some(55.0));
        pace.add(1.0, 1.0);
        assert_eq!(pace.left(2.0, 0.0, 0.0, 60.0), Some(62.0));
        // The costliest tiles come first: half of the tiles after 1.5 of 2 seconds.
        assert_eq!(pace.left(2.0, 1.5, 0.5, 60.0), Some(60.5));
        // Later than expected.
        assert_eq!(pace.left(2.0, 3.0, 0.75, 60.0), Some(61.0));
    }
}
