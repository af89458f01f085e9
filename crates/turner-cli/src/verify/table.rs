//! The findings of the checks: a line each, or JSON.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use serde_json::json;

use super::check::{Check, Finding, Verdict};
use crate::events::Events;
use crate::text;

/// Writes rows as they come.
pub(super) struct Table {
    json: bool,
    /// Width of the names.
    width: usize,
    checks: usize,
    /// Whether the running check is shown on standard error.
    progress: bool,
}

impl Table {
    pub(super) fn new(json: bool, checks: &[Check]) -> Table {
        let width = checks.iter().map(|c| c.name.chars().count()).max().unwrap_or(0);
        let progress = !json && std::io::stderr().is_terminal();
        Table { json, width, checks: checks.len(), progress }
    }

    pub(super) fn start(&self, seed: u64, level: f64, statistical: usize) {
        if self.json {
            let checks = self.checks;
            let event = json!({"event": "start", "seed": seed, "level": level, "checks": checks, "statistical": statistical});
            return Events::Stdout.send(event);
        }
        let width = self.width;
        text::print(&format!(
            "Seed {seed}; {} checks, {statistical} of them statistical tests, which fail if p is below {level:.1e}.\n\n\
             {:width$}  verdict  statistic  threshold    time  found\n",
            self.checks, "check"
        ));
    }

    pub(super) fn running(&self, i: usize, check: &Check) {
        if self.progress {
            let mut err = std::io::stderr().lock();
            let _ = write!(err, "\r\x1b[K{} of {}: {} …", i + 1, self.checks, check.name);
            let _ = err.flush();
        }
    }

    fn clear(&self) {
        if self.progress {
            let _ = write!(std::io::stderr().lock(), "\r\x1b[K");
        }
    }

    pub(super) fn row(&self, check: &Check, finding: &Finding, passed: bool, time: Duration) {
        self.clear();
        let seconds = time.as_secs_f64();
        if self.json {
            let (kind, value, limit) = match finding.verdict {
                Verdict::Chance(p) => ("p", p, None),
                Verdict::Limit(value, limit) => ("limit", value, Some(limit)),
            };
            return Events::Stdout.send(json!({
                "event": "check", "name": check.name, "passed": passed, "kind": kind, "value": value, "limit": limit,
                "found": finding.found, "seconds": seconds,
            }));
        }
        let (statistic, threshold) = match finding.verdict {
            Verdict::Chance(p) => (format!("p {p:.1e}"), "level".to_owned()),
            Verdict::Limit(value, limit) => (short(value), format!("<= {limit}")),
        };
        let verdict = if passed { "ok" } else { "FAILED" };
        let width = self.width;
        text::print(&format!(
            "{:width$}  {verdict:7}  {statistic:>9}  {threshold:>9}  {:>6}  {}\n",
            check.name,
            format!("{seconds:.1} s"),
            finding.found
        ));
    }

    pub(super) fn end(&self, checks: usize, failed: u32, seed: u64, time: Duration) {
        if self.json {
            let seconds = time.as_secs_f64();
            let event = json!({"event": "done", "checks": checks, "failed": failed, "seed": seed, "seconds": seconds});
            return Events::Stdout.send(event);
        }
        let seconds = text::seconds(time.as_secs_f64());
        text::print(&match failed {
            0 => format!("\nAll {checks} checks passed in {seconds}.\n"),
            n => {
                format!("\n{n} of {checks} checks failed, in {seconds}. Repeat this run with --seed {seed}\n")
            }
        });
    }
}

fn short(v: f64) -> String {
    if v == v.trunc() && v.abs() < 1e6 { format!("{v}") } else { format!("{v:.3}") }
}
