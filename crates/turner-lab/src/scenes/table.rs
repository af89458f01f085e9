//! Results as text, JSON and Markdown.

use std::fmt::Write;

use serde_json::{Value, json};
use turner_cli::text;

use super::{Measured, SceneResult};
use crate::statistics::geometric_mean;

/// Scenes at or below this ratio are counted.
const GOOD: f64 = 0.8;

/// Time, error, and time x error of one renderer over those of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ratio {
    time: f64,
    error: f64,
}

impl Ratio {
    fn of(one: &Measured, other: &Measured) -> Ratio {
        Ratio { time: one.seconds() / other.seconds(), error: one.error() / other.error() }
    }

    /// Time to equal error, as errors fall as one over time.
    fn cost(self) -> f64 {
        self.time * self.error
    }

    fn json(self) -> Value {
        json!({ "time": self.time, "error": self.error, "cost": self.cost() })
    }
}

/// One renderer over another in all scenes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Summary {
    of: String,
    over: String,
    scenes: usize,
    /// Geometric means.
    time: f64,
    error: f64,
    cost: f64,
    /// Scenes whose time x error is at most [`GOOD`].
    good: usize,
    /// The scene with the largest time x error.
    worst: (String, f64),
}

/// Each Turner over the other renderer, then the first Turner over the second.
pub(super) fn summaries(results: &[SceneResult]) -> Vec<Summary> {
    let Some(first) = results.first() else { return Vec::new() };
    let count = first.renderers.len();
    let pairs = (1..count).map(|i| (i, 0)).chain((count > 2).then_some((1, 2)));
    pairs.filter_map(|(of, over)| summary(results, of, over)).collect()
}

fn summary(results: &[SceneResult], of: usize, over: usize) -> Option<Summary> {
    let mut ratios = Vec::new();
    for result in results {
        let (one, other) = (result.renderers.get(of)?, result.renderers.get(over)?);
        ratios.push((&result.scene, Ratio::of(one, other)));
    }
    let name = |i: usize| results.first()?.renderers.get(i).map(|m| m.name.clone());
    let mean = |value: fn(Ratio) -> f64| geometric_mean(ratios.iter().map(|(_, r)| value(*r)));
    let worst = ratios.iter().max_by(|a, b| a.1.cost().total_cmp(&b.1.cost()))?;
    Some(Summary {
        of: name(of)?,
        over: name(over)?,
        scenes: ratios.len(),
        time: mean(|r| r.time)?,
        error: mean(|r| r.error)?,
        cost: mean(Ratio::cost)?,
        good: ratios.iter().filter(|(_, r)| r.cost() <= GOOD).count(),
        worst: (worst.0.clone(), worst.1.cost()),
    })
}

/// The columns of [`rows`].
pub(super) fn header(peer: &str) -> String {
    let over = format!("over {peer}");
    format!(
        "{:60}  {over:>25}\n{:24}  {:14}  {:>10}  {:>8}  {:>6}  {:>7}  {:>7}  {:>12}\n",
        "", "scene", "renderer", "seconds", "relMSE", "mean", "time", "error", "time x error"
    )
}

/// A line for each renderer.
pub(super) fn rows(result: &SceneResult) -> String {
    let mut out = String::new();
    let (width, height) = result.size;
    for (i, m) in result.renderers.iter().enumerate() {
        let label = match i {
            0 => result.scene.clone(),
            1 => format!("  {width}x{height}, {}", text::plural(u64::from(result.samples), "sample")),
            _ => String::new(),
        };
        let [seconds, error, mean] =
            [text::seconds(m.seconds()), format!("{:.2e}", m.error()), format!("{:.3}", m.brightness())];
        let _ = write!(out, "{label:24}  {:14}  {seconds:>10}  {error:>8}  {mean:>6}", m.name);
        if let Some(ratio) = ratio(result, i) {
            let _ = write!(out, "  {:>7.3}  {:>7.3}  {:>12.3}", ratio.time, ratio.error, ratio.cost());
        }
        out.push('\n');
    }
    out
}

/// The renderer with this index over the first one, which is the other renderer.
fn ratio(result: &SceneResult, index: usize) -> Option<Ratio> {
    let over = result.renderers.first().filter(|_| index > 0)?;
    result.renderers.get(index).map(|m| Ratio::of(m, over))
}

/// All scenes as a Markdown table, with the means as its last rows.
pub(super) fn markdown(results: &[SceneResult]) -> String {
    let mut out = String::from(
        "| scene | renderer | seconds | relMSE | mean | time | error | time x error |\n\
         |---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for result in results {
        for (i, m) in result.renderers.iter().enumerate() {
            let ratio = ratio(result, i).map_or(" | | |".to_owned(), |r| {
                format!(" {:.2} | {:.2} | {:.2} |", r.time, r.error, r.cost())
            });
            let name = format!("{} {}", m.name, m.version);
            let _ = writeln!(
                out,
                "| {} | {} | {:.3} | {:.2e} | {:.3} |{ratio}",
                result.scene.replace('|', "\\|"),
                name.trim_end(),
                m.seconds(),
                m.error(),
                m.brightness()
            );
        }
    }
    for s in summaries(results) {
        let _ = writeln!(
            out,
            "| geometric mean | {} over {} | | | | {:.2} | {:.2} | {:.2} |",
            s.of, s.over, s.time, s.error, s.cost
        );
    }
    out
}

/// A line for each summary.
pub(super) fn summary_text(summaries: &[Summary]) -> String {
    let mut out = String::new();
    for s in summaries {
        let Summary { of, over, time, error, cost, good, .. } = s;
        let scenes = text::plural(s.scenes as u64, "scene");
        let _ = writeln!(
            out,
            "{of} over {over}, {scenes}: time {time:.3}, error {error:.3}, time x error {cost:.3} (geometric means); \
             time x error: {good} at or below {GOOD}, worst {} with {:.3}",
            s.worst.0, s.worst.1
        );
    }
    out
}

/// The scenes left out, with their reasons or, where those were shown before, their names alone.
pub(super) fn all_left_out(scenes: &[(String, String)], reasons: bool) -> String {
    if scenes.is_empty() {
        return String::new();
    }
    let count = text::plural(scenes.len() as u64, "scene");
    if reasons {
        let list: String = scenes.iter().map(|(scene, reason)| format!("  {scene}: {reason}\n")).collect();
        return format!("{count} left out:\n{list}");
    }
    let names: Vec<&str> = scenes.iter().map(|(scene, _)| scene.as_str()).collect();
    format!("{count} left out: {}\n", names.join(", "))
}

/// A JSON line for each renderer.
pub(super) fn lines(result: &SceneResult) -> String {
    let mut out = String::new();
    for (i, m) in result.renderers.iter().enumerate() {
        let line = json!({
            "scene": result.scene,
            "width": result.size.0,
            "height": result.size.1,
            "samples": result.samples,
            "renderer": m.name,
            "version": m.version,
            "seconds": m.seconds,
            "median_seconds": m.seconds(),
            "relmse": m.error(),
            "relmse_of_runs": m.errors,
            "mean": m.brightness(),
            "over_peer": ratio(result, i).map(Ratio::json),
        });
        let _ = writeln!(out, "{line}");
    }
    out
}

/// A line for a scene that is left out.
pub(super) fn left_out(scene: &str, reason: &str) -> String {
    format!("{scene:24}  left out: {reason}\n")
}

/// The same as JSON.
pub(super) fn left_out_line(scene: &str, reason: &str) -> String {
    format!("{}\n", json!({ "scene": scene, "left_out": reason }))
}

/// A JSON line for each summary.
pub(super) fn summary_lines(summaries: &[Summary]) -> String {
    let mut out = String::new();
    for s in summaries {
        let line = json!({
            "renderer": s.of,
            "over": s.over,
            "scenes": s.scenes,
            "geometric_mean": { "time": s.time, "error": s.error, "cost": s.cost },
            "at_or_below": { "cost": GOOD, "scenes": s.good },
            "worst": { "scene": s.worst.0, "cost": s.worst.1 },
        });
        let _ = writeln!(out, "{line}");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mitsuba takes a second for an error of 0.1; the Turners take `of` of both.
    fn result(scene: &str, of: &[(&str, f64, f64)]) -> SceneResult {
        let measured = |name: &str, seconds: f64, error: f64| Measured {
            name: name.into(),
            version: "1".into(),
            // The median is the one in the middle.
            seconds: vec![9.0 * seconds, seconds, 0.5 * seconds],
            errors: vec![0.5 * error, error, 1.5 * error],
            brightnesses: vec![1.0, 1.0, 1.03],
        };
        let mut renderers = vec![measured("mitsuba-llvm", 1.0, 0.1)];
        renderers.extend(of.iter().map(|(name, time, error)| measured(name, *time, 0.1 * error)));
        SceneResult { scene: scene.into(), size: (320, 180), samples: 16, renderers }
    }

    fn two() -> [SceneResult; 2] {
        [
            result("kitchen", &[("turner", 2.0, 0.2), ("before", 2.0, 0.4)]),
            result("cbox", &[("turner", 0.5, 1.8), ("before", 1.0, 0.5)]),
        ]
    }

    #[test]
    fn summaries_have_means_counts_and_the_worst() {
        let all = summaries(&two());
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        let over: Vec<_> = all.iter().map(|s| (s.of.as_str(), s.over.as_str())).collect();
        assert_eq!(over, [("turner", "mitsuba-llvm"), ("before", "mitsuba-llvm"), ("turner", "before")]);
        near(all[0].time, 1.0);
        near(all[0].error, 0.6);
        near(all[0].cost, 0.6);
        // 0.4 and 0.9; 0.8 and 0.5; 0.5 and 1.8.
        assert_eq!(all.iter().map(|s| (s.scenes, s.good)).collect::<Vec<_>>(), [(2, 1), (2, 2), (2, 1)]);
        let worst: Vec<&str> = all.iter().map(|s| s.worst.0.as_str()).collect();
        assert_eq!(worst, ["cbox", "kitchen", "cbox"]);
        near(all[2].worst.1, 1.8);
        assert_eq!(summaries(&[]), []);
    }

    #[test]
    fn tables_show_ratios_to_the_other_renderer() {
        let all = two();
        let text = rows(&all[0]);
        let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().collect()).collect();
        assert_eq!(lines[0], ["kitchen", "mitsuba-llvm", "1.00", "s", "1.00e-1", "1.010"]);
        assert_eq!(
            lines[1],
            [
                "320x180,", "16", "samples", "turner", "2.00", "s", "2.00e-2", "1.010", "2.000", "0.200",
                "0.400"
            ]
        );
        assert_eq!(lines[2][..2], ["before", "2.00"]);
        let table = markdown(&all);
        assert_eq!(table.lines().count(), 2 + 6 + 3, "{table}");
        assert!(
            table.contains("| kitchen | turner 1 | 2.000 | 2.00e-2 | 1.010 | 2.00 | 0.20 | 0.40 |"),
            "{table}"
        );
        assert!(table.lines().all(|l| l.matches('|').count() == 9), "{table}");
        assert!(
            table.ends_with("| geometric mean | turner over before | | | | 0.71 | 1.34 | 0.95 |\n"),
            "{table}"
        );
    }

    #[test]
    fn scenes_that_are_left_out_are_listed() {
        let out = [("old", "unexpected <lookAt>"), ("older", "no sensor")].map(|(s, r)| (s.into(), r.into()));
        let text = all_left_out(&out, true);
        assert_eq!(text, "2 scenes left out:\n  old: unexpected <lookAt>\n  older: no sensor\n");
        assert_eq!(all_left_out(&out, false), "2 scenes left out: old, older\n");
        assert_eq!(all_left_out(&[], true), "");
        let text = summary_text(&summaries(&two()));
        assert!(
            text.contains("time x error 0.600 (geometric means); time x error: 1 at or below 0.8"),
            "{text}"
        );
        assert!(text.contains("worst cbox with 0.900\n"), "{text}");
        let line: Value = serde_json::from_str(&left_out_line("old", "why \"not\"")).unwrap();
        assert_eq!(line["left_out"], "why \"not\"");
    }

    #[test]
    fn json_has_a_line_for_each_renderer() {
        let text = lines(&two()[1]);
        let lines: Vec<Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[0]["over_peer"], Value::Null);
        assert_eq!(lines[1]["over_peer"]["time"], 0.5);
        assert_eq!(lines[1]["seconds"], json!([4.5, 0.5, 0.25]));
        let summary: Value =
            serde_json::from_str(summary_lines(&summaries(&two())).lines().next().unwrap()).unwrap();
        assert_eq!(
            (&summary["worst"]["scene"], &summary["at_or_below"]["scenes"]),
            (&json!("cbox"), &json!(1))
        );
    }
}
