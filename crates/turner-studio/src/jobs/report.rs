//! How far a job is, from the events of its process.

use std::time::Instant;

use serde_json::Value;

/// What a job does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// It waits for those before it.
    #[default]
    Waiting,
    /// Its scene is written and read.
    Preparing,
    /// It renders.
    Rendering,
    /// It was asked to stop, and keeps what is rendered.
    Stopping,
    /// It was stopped.
    Stopped,
    /// It is complete.
    Done,
    /// It failed.
    Failed,
}

impl State {
    /// Whether a process runs or begins.
    pub fn is_running(self) -> bool {
        matches!(self, State::Preparing | State::Rendering | State::Stopping)
    }

    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            State::Waiting => "waiting",
            State::Preparing => "preparing",
            State::Rendering => "rendering",
            State::Stopping => "stopping",
            State::Stopped => "stopped",
            State::Done => "done",
            State::Failed => "failed",
        }
    }
}

/// How far a job is.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// What it does.
    pub state: State,
    /// The picture that it renders, from 0.
    pub picture: u32,
    /// The fraction of this picture that is done.
    pub done: f64,
    /// Seconds left for this picture, as its process estimates them; `None` while that is unknown.
    pub left: Option<f64>,
    /// When that was said.
    pub at: Option<Instant>,
    /// Samples per pixel so far.
    pub samples: f64,
    /// The noise so far, as a fraction.
    pub noise: Option<f64>,
    /// Seconds of rendering of the pictures that are complete, and their number.
    pub complete: (f64, u32),
    /// The file that was written last.
    pub written: Option<String>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Why it failed, with the remedy.
    pub error: Option<String>,
}

impl Report {
    /// The fraction of all pictures that is done.
    pub fn fraction(&self, pictures: u32) -> f64 {
        if self.state == State::Done {
            return 1.0;
        }
        ((f64::from(self.picture) + self.done) / f64::from(pictures.max(1))).clamp(0.0, 1.0)
    }

    /// Seconds left for all pictures. Of pictures that have not begun it knows only that they take as long as the mean of
    /// those that are complete; before there is one, nothing.
    pub fn seconds_left(&self, pictures: u32) -> Option<f64> {
        let since = self.at.map_or(0.0, |at| at.elapsed().as_secs_f64());
        let here = self.left.map(|left| (left - since).max(0.0));
        let after = pictures.saturating_sub(self.picture + 1);
        if after == 0 {
            return here;
        }
        let (seconds, count) = self.complete;
        let each = (count > 0).then(|| seconds / f64::from(count))?;
        Some(here.unwrap_or(each * (1.0 - self.done)) + each * f64::from(after))
    }

    /// Learns from an event: a line of the process.
    pub(super) fn hear(&mut self, line: &str) {
        let Ok(event) = serde_json::from_str::<Value>(line) else { return };
        let text = |key: &str| event[key].as_str().map(str::to_owned);
        let number = |key: &str| event[key].as_f64();
        match event["event"].as_str() {
            Some("start") => {
                (self.done, self.left, self.samples) = (0.0, None, 0.0);
                if self.state == State::Preparing {
                    self.state = State::Rendering;
                }
            }
            Some("progress") => {
                self.done = number("done").unwrap_or(self.done);
                self.samples = number("samples_per_pixel").unwrap_or(self.samples);
                (self.left, self.at) = (number("seconds_left"), Some(Instant::now()));
                self.noise = number("noise").or(self.noise);
            }
            Some("done") => {
                self.written = text("output").or(self.written.take());
                if event["complete"] == Value::Bool(true) {
                    let seconds = &event["seconds"];
                    let all = ["load", "render", "save"].iter().filter_map(|part| seconds[part].as_f64());
                    self.complete.0 += all.sum::<f64>();
                    self.complete.1 += 1;
                    (self.picture, self.done, self.left) = (self.picture + 1, 0.0, None);
                } else {
                    self.done = number("finished").unwrap_or(self.done);
                }
            }
            Some("skipped") => {
                self.written = text("output").or(self.written.take());
                self.picture += 1;
            }
            Some("animation") => self.written = text("output"),
            Some("warning") => self.warnings.extend(text("message")),
            Some("error") => {
                let help = text("help").map_or(String::new(), |help| format!(": {help}"));
                let message = text("message").unwrap_or_default();
                let before = self.error.take().map_or(String::new(), |error| format!("{error}\n"));
                self.error = Some(format!("{before}{message}{help}"));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_is_said_only_when_it_is_known() {
        let mut report = Report { state: State::Preparing, ..Report::default() };
        report.hear(r#"{"event":"start"}"#);
        assert_eq!((report.state, report.seconds_left(1)), (State::Rendering, None));
        report.hear(r#"{"event":"progress","done":0.5,"seconds_left":null,"samples_per_pixel":3}"#);
        assert_eq!((report.seconds_left(1), report.samples), (None, 3.0));
        report.hear(r#"{"event":"progress","done":0.5,"seconds_left":40,"samples_per_pixel":4,"noise":0.1}"#);
        let left = report.seconds_left(1).unwrap();
        assert!((39.0..=40.0).contains(&left), "{left}");
        assert_eq!(
            (report.seconds_left(2), report.fraction(2)),
            (None, 0.25),
            "the second picture is unknown"
        );
        report.hear(r#"{"event":"done","complete":true,"output":"a_0000.png","seconds":{"load":1,"render":6,"save":1}}"#);
        assert_eq!((report.fraction(4), report.seconds_left(4)), (0.25, Some(32.0 - 8.0)));
        report.hear("no event");
        report.hear(r#"{"event":"skipped","output":"a_0001.png"}"#);
        assert_eq!((report.picture, report.written.as_deref()), (2, Some("a_0001.png")));
    }

    #[test]
    fn errors_keep_their_remedies() {
        let mut report = Report::default();
        report.hear(r#"{"event":"error","message":"no space","help":"free some"}"#);
        report.hear(r#"{"event":"error","message":"and more","help":null}"#);
        assert_eq!(report.error.as_deref(), Some("no space: free some\nand more"));
    }
}
