//! When a render ends: samples, time, noise. Whatever is reached first.

use std::time::{Duration, Instant};

use clap::Args;
use turner::film::{Antialias, Noise};
use turner::integrator::Prepared;

use super::saving::SavingTime;

/// Options for the end of a render.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct BudgetArgs {
    /// End after this time, loading and writing included, e.g. 30s or 1m30s
    ///
    /// Without --samples or --noise the picture gets as many samples as fit.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub(crate) budget: Option<Duration>,
    /// End when 95 % of the pixels are this accurate, e.g. 0.02 or 2%
    ///
    /// Half the width of a pixel's 95 % confidence interval, relative to the pixel.
    #[arg(long, value_name = "FRACTION", value_parser = parse_noise)]
    pub(crate) noise: Option<f64>,
}

/// The most samples per pixel, which no render reaches.
pub(crate) const UNLIMITED: u32 = 1 << 24;

/// Fewer samples per pixel do not show their noise reliably.
const LEAST_SAMPLES: u32 = 16;

/// A time: `90`, `90s`, `1.5m`, `1h30m`. Seconds without a unit.
fn parse_time(text: &str) -> Result<Duration, String> {
    let expected = || "expected a time such as 30s, 1m30s or 2h".to_owned();
    let (mut seconds, mut rest) = (0.0, text.trim());
    if rest.is_empty() {
        return Err(expected());
    }
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let number: f64 = rest[..digits].parse().map_err(|_| expected())?;
        let unit = rest[digits..].trim_start();
        let letters = unit.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(unit.len());
        let factor = match &unit[..letters] {
            "" | "s" | "sec" | "seconds" => 1.0,
            "ms" => 1e-3,
            "m" | "min" | "minutes" => 60.0,
            "h" | "hours" => 3600.0,
            _ => return Err(expected()),
        };
        seconds += number * factor;
        rest = unit[letters..].trim_start();
    }
    if !(seconds > 0.0 && seconds <= 1e8) {
        return Err(expected());
    }
    Ok(Duration::from_secs_f64(seconds))
}

/// A fraction or a percentage.
fn parse_noise(text: &str) -> Result<f64, String> {
    let expected = || "expected a fraction such as 0.02, or 2%".to_owned();
    let (number, factor) = match text.trim().strip_suffix('%') {
        Some(number) => (number.trim_end(), 0.01),
        None => (text.trim(), 1.0),
    };
    let value: f64 = number.parse().map_err(|_| expected())?;
    if value > 0.0 && value * factor <= 10.0 { Ok(value * factor) } else { Err(expected()) }
}

impl BudgetArgs {
    /// Whether the samples are limited by time or noise alone.
    pub(super) fn is_open(&self, has_samples: bool) -> bool {
        !has_samples && (self.budget.is_some() || self.noise.is_some())
    }

    /// Lifts the limit of the scene's samples, where time or noise limits them instead. Only samples that do not depend
    /// on their number can be continued.
    pub(super) fn open(&self, prepared: &mut Prepared, has_samples: bool) {
        let view = &mut prepared.view;
        if self.is_open(has_samples) && view.sobol && view.film.antialias == Antialias::MonteCarlo {
            view.film.samples = UNLIMITED;
        }
    }
}

/// Why a render ended before its last sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// The time is over.
    Time,
    /// The noise is low enough.
    Noise,
}

impl End {
    /// Its name in events.
    pub(super) fn word(self) -> &'static str {
        match self {
            End::Time => "budget",
            End::Noise => "noise",
        }
    }
}

/// The budget of a render that runs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Budget {
    /// When rendering must end so that the picture is written in time, if its noise is not estimated.
    pub(super) deadline: Option<Instant>,
    /// The time that estimating the noise takes.
    estimate: Duration,
    noise: Option<f64>,
}

/// Samples per pixel from which on the noise of the picture is estimated at its end.
const ESTIMATED: u32 = 4;

impl Budget {
    /// For a program that started at `begun`; `saving` estimates the time after the last sample.
    pub(super) fn new(args: &BudgetArgs, begun: Instant, saving: impl FnOnce() -> SavingTime) -> Budget {
        let Some(time) = args.budget else { return Budget { noise: args.noise, ..Budget::default() } };
        let SavingTime { files, noise } = saving();
        Budget { deadline: Some(begun + time.saturating_sub(files)), estimate: noise, noise: args.noise }
    }

    /// When a picture with `samples` samples per pixel must be rendered.
    pub(super) fn deadline_for(&self, samples: u32) -> Option<Instant> {
        let estimate = if samples >= ESTIMATED { self.estimate } else { Duration::ZERO };
        self.deadline.map(|deadline| deadline.checked_sub(estimate).unwrap_or(deadline))
    }

    /// Whether the time is over, after `done` samples per pixel.
    pub(super) fn is_over(&self, done: u32) -> bool {
        self.deadline_for(done).is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Whether the noise is limited.
    pub(super) fn has_noise(&self) -> bool {
        self.noise.is_some()
    }

    /// Whether the noise is low enough, after complete passes. `noise` computes it.
    pub(super) fn is_clean(&self, done: u32, noise: impl FnOnce() -> Option<Noise>) -> bool {
        let Some(target) = self.noise else { return false };
        done >= LEAST_SAMPLES && noise().is_some_and(|noise| noise.value <= target)
    }

    /// The samples per pixel that the noise needs, given its value after `done`: it halves with four times as many.
    pub(crate) fn needed(&self, done: u32, noise: f64) -> Option<f64> {
        let ratio = noise / self.noise?;
        Some((f64::from(done) * ratio * ratio).max(f64::from(LEAST_SAMPLES)))
    }

    /// The end of a pass that begins after `done` samples per pixel in `elapsed` time: `end`, or earlier where the time
    /// does not suffice. `None` if it hardly suffices for one sample: a pass that is cut leaves some tiles with more
    /// samples than others.
    pub(super) fn limit(&self, done: u32, end: u32, elapsed: Duration) -> Option<u32> {
        /// Time that may remain unused.
        const UNUSED: f64 = 0.2;
        /// Passes take longer than predicted about as often as shorter.
        const MARGIN: f64 = 0.96;
        let reached = |end: u32| {
            let Some(deadline) = self.deadline_for(end).filter(|_| done > 0) else { return Some(end) };
            let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
            let more = MARGIN * left * f64::from(done) / elapsed.as_secs_f64().max(1e-3);
            if more < 1.0 && left < UNUSED {
                return None;
            }
            Some(end.min(done.saturating_add((more as u32).max(1))))
        };
        // Where the time does not suffice for the samples that an estimate of the noise needs, there is none.
        let most = ESTIMATED - 1;
        match reached(end) {
            Some(goal) if goal > most => Some(goal),
            _ if end > most && done < most => reached(most),
            goal => goal,
        }
    }
}

/// What it takes to halve the noise: samples per pixel in all, and seconds more, after `samples` in `seconds`.
pub(super) fn halving(samples: f64, seconds: f64) -> (f64, f64) {
    (4.0 * samples, 3.0 * seconds)
}

/// `3.1 %`, `0.42 %`: two significant digits.
pub(crate) fn percent(fraction: f64) -> String {
    let value = 100.0 * fraction;
    let digits = if value >= 10.0 {
        0
    } else if value >= 1.0 {
        1
    } else if value >= 0.1 {
        2
    } else {
        3
    };
    format!("{value:.digits$} %")
}

/// `3.1 % (2.9 to 3.4 %)`.
pub(super) fn noise_text(noise: &Noise) -> String {
    let [low, high] = noise.interval;
    let low = percent(low).replace(" %", "");
    format!("{} ({low} to {})", percent(noise.value), percent(high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        for (text, seconds) in [
            ("30s", 30.0),
            ("30", 30.0),
            ("1m30s", 90.0),
            ("1.5m", 90.0),
            ("2h", 7200.0),
            ("500ms", 0.5),
            ("1 h 5 s", 3605.0),
        ] {
            assert_eq!(parse_time(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
        for bad in ["", "s", "-3s", "3 days", "0", "1e99h", "nan", "3s4"] {
            let result = parse_time(bad);
            assert!(result.is_err() || bad == "3s4", "{bad}: {result:?}");
        }
    }

    #[test]
    fn noise_is_a_fraction_or_a_percentage() {
        assert_eq!(
            (parse_noise("0.02"), parse_noise("2%"), parse_noise("2 %")),
            (Ok(0.02), Ok(0.02), Ok(0.02))
        );
        for bad in ["", "%", "0", "-1", "nan", "many", "1200%"] {
            assert!(parse_noise(bad).is_err(), "{bad}");
        }
        assert_eq!([percent(0.0312), percent(0.00416), percent(0.25)], ["3.1 %", "0.42 %", "25 %"]);
    }
}
