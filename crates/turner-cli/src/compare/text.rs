//! The result as text.

use turner::compare::{Metric, Worst};

use super::{Compared, Verdict};
use crate::text::plural;

/// The table of metrics, remarks on non-finite pixels, and the verdict in the last line.
pub(super) fn of(c: &Compared) -> String {
    let (pair, [a, b]) = (&c.pair, &c.names);
    let kind = if pair.is_linear { "linear light" } else { "display values" };
    let alpha = if pair.has_alpha { ", partly transparent" } else { "" };
    let mut out = format!("{b} against {a}: {}x{}, {kind}{alpha}\n", pair.width, pair.height);
    if let Some((width, height)) = c.resized {
        out += &format!("{b}: scaled from {width}x{height}\n");
    }
    for (metric, found) in &c.measured {
        out += &format!(
            "  {:8} {:14} {}\n",
            metric.title(),
            value(*metric, found.value),
            worst(*metric, &found.worst)
        );
    }
    for (name, bad) in [a, b].into_iter().zip(&pair.non_finite) {
        if let Some((x, y)) = bad.first {
            let n = plural(bad.count, "pixel");
            out += &format!(
                "{name}: {n} non-finite (NaN or infinite), counted as black in both; the first in column {x}, row {y}\n"
            );
        }
    }
    if let Some((x, y)) = pair.unlike.first {
        let n = plural(pair.unlike.count, "pixel");
        out += &format!("{n} of these differ between the two; the first in column {x}, row {y}\n");
    }
    if let Some(diff) = &c.diff {
        out += &format!(
            "{}: {} per pixel, black 0, pale yellow {}\n",
            diff.path,
            map_of(diff.metric),
            number(f64::from(diff.white))
        );
    }
    if let Some(verdict) = &c.verdict {
        out += &judged(c, verdict);
    }
    out
}

fn judged(c: &Compared, v: &Verdict) -> String {
    let (title, shown) = (v.metric.title(), value(v.metric, v.value));
    let tolerance = number(v.tolerance);
    let bound = if v.metric.is_similarity() { "at least" } else { "at most" };
    if v.within {
        return format!("within the tolerance: {title} {shown}, {bound} {tolerance} required\n");
    }
    if v.metric.is_within(v.value, v.tolerance) {
        return format!(
            "beyond the tolerance: {title} {shown} is within {tolerance}, but non-finite pixels differ\n"
        );
    }
    let worst = c.measured.iter().find(|(m, _)| *m == v.metric).map_or(String::new(), |(_, found)| {
        format!("; worst pixel in column {}, row {}", found.worst.x, found.worst.y)
    });
    format!("beyond the tolerance: {title} {shown}, {bound} {tolerance} required{worst}\n")
}

/// A metric's value with its unit.
fn value(metric: Metric, v: f64) -> String {
    match metric {
        Metric::Psnr if v.is_infinite() => "no difference".to_owned(),
        Metric::Psnr => format!("{v:.2} dB"),
        _ => number(v),
    }
}

/// The quantity in the map of a metric.
fn map_of(metric: Metric) -> &'static str {
    match metric {
        Metric::Flip => "FLIP",
        Metric::Ssim => "1 - SSIM",
        Metric::RelMse => "relMSE",
        Metric::Max | Metric::Mean | Metric::Rmse | Metric::Psnr => "the largest difference",
    }
}

fn worst(metric: Metric, worst: &Worst) -> String {
    if worst.value > 0.0 {
        let v = if metric == Metric::Ssim { 1.0 - worst.value } else { worst.value };
        format!("worst {} in column {}, row {}", number(f64::from(v)), worst.x, worst.y)
    } else {
        String::new()
    }
}

/// Five significant digits.
fn number(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e6).contains(&v.abs()) {
        return format!("{v:.4e}");
    }
    let text = [(1e5, 0), (1e4, 0), (1e3, 1), (1e2, 2), (1e1, 3), (1.0, 4), (0.1, 5), (0.01, 6), (1e-3, 7)];
    let digits = text.iter().find(|(least, _)| v.abs() >= *least).map_or(8, |(_, digits)| *digits);
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_five_digits() {
        let shown = [0.0, 1.0, 0.5, 0.1234567, 12.345678, 0.00012345678, 1e-9, 123456.7, -0.25].map(number);
        assert_eq!(
            shown,
            ["0", "1", "0.5", "0.12346", "12.346", "0.00012346", "1.0000e-9", "123457", "-0.25"]
        );
    }
}
