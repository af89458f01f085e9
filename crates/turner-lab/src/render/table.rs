//! Results as text, JSON and Markdown.

use std::fmt::Write;

use serde_json::json;
use turner_cli::text;

use super::Series;
use super::curve::Reach;

/// The errors that times are shown for.
pub(super) const TARGETS: [f64; 2] = [0.01, 0.001];

/// A row per sample count and renderer.
pub(super) fn rows(series: &[Series]) -> String {
    let mut out = String::new();
    let Some(first) = series.first() else { return out };
    let width = width(series);
    let Series { scene, threads, width: w, height: h, .. } = first;
    let _ = writeln!(out, "{scene} {w}x{h}, {}", text::plural(*threads as u64, "thread"));
    let _ = writeln!(out, "  {:width$}  samples     seconds    relMSE     paths/s", "renderer");
    for s in series {
        for m in &s.measured {
            let error = m.error().map_or("-".into(), |e| format!("{e:.2e}"));
            let _ = writeln!(
                out,
                "  {:width$}  {:>7}  {:>10}  {error:>8}  {:>10}",
                s.renderer,
                m.samples,
                text::seconds(m.seconds()),
                text::count(s.paths(m) / m.seconds()),
            );
        }
    }
    out.push('\n');
    out
}

/// Times to the target errors.
pub(super) fn summary(series: &[Series]) -> String {
    let mut out = String::new();
    let width = width(series);
    let scenes = series.iter().map(|s| s.scene.chars().count()).max().unwrap_or(0).max(5);
    let _ = writeln!(
        out,
        "{:scenes$}  threads  {:width$}       start   relMSE 0.01            relMSE 0.001              paths/s",
        "scene", "renderer"
    );
    for s in series {
        let _ = write!(
            out,
            "{:scenes$}  {:>7}  {:width$}  {:>10}",
            s.scene,
            s.threads,
            s.renderer,
            text::seconds(s.start)
        );
        for target in TARGETS {
            let (reach, ratio) = reach(series, s, target);
            let _ = write!(out, "  {reach:>12}  {ratio:>7}");
        }
        let rate = s.paths_per_second().map_or("-".into(), text::count);
        let _ = writeln!(out, "  {rate:>10}");
    }
    out
}

/// Times to the target errors as a Markdown table.
pub(super) fn markdown(series: &[Series]) -> String {
    let mut out = String::from(
        "| scene | threads | renderer | start | seconds to relMSE 0.01 | Turner's ratio | to 0.001 | Turner's ratio | million paths/s |\n\
         |---|--:|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for s in series {
        let name = format!("{} {}", s.renderer, s.version);
        let _ = write!(out, "| {} | {} | {} | {:.2} s", s.scene, s.threads, name.trim_end(), s.start);
        for target in TARGETS {
            let (reach, ratio) = reach(series, s, target);
            let _ = write!(out, " | {reach} | {}", if ratio == "-" { "" } else { &ratio });
        }
        let rate = s.paths_per_second().map_or(String::new(), |r| format!("{:.2}", r / 1e6));
        let _ = writeln!(out, " | {rate} |");
    }
    out
}

/// A JSON line per sample count, and one per renderer.
pub(super) fn lines(series: &[Series]) -> String {
    let mut out = String::new();
    for s in series {
        for m in &s.measured {
            let line = json!({
                "scene": s.scene,
                "renderer": s.renderer,
                "version": s.version,
                "threads": s.threads,
                "samples": m.samples,
                "seconds": m.seconds,
                "median_seconds": m.seconds(),
                "relmse": m.error(),
                "relmse_of_runs": m.errors,
                "paths_per_second": s.paths(m) / m.seconds(),
            });
            let _ = writeln!(out, "{line}");
        }
        let reach: Vec<_> = TARGETS
            .iter()
            .map(|&target| {
                let reach = s.reach(target);
                json!({
                    "relmse": target,
                    "seconds": reach.map(|r| r.seconds),
                    "measured": reach.map(|r| r.measured),
                })
            })
            .collect();
        let line = json!({
            "scene": s.scene,
            "renderer": s.renderer,
            "version": s.version,
            "threads": s.threads,
            "width": s.width,
            "height": s.height,
            "start_seconds": s.start,
            "reach": reach,
            "paths_per_second": s.paths_per_second(),
        });
        let _ = writeln!(out, "{line}");
    }
    out
}

/// The time of one renderer, and Turner's time divided by it.
fn reach(all: &[Series], s: &Series, target: f64) -> (String, String) {
    let Some(reach) = s.reach(target) else { return ("-".into(), "-".into()) };
    let same = |t: &&Series| t.scene == s.scene && t.threads == s.threads && t.renderer == "turner";
    let turner = all.iter().find(same).filter(|t| t.renderer != s.renderer).and_then(|t| t.reach(target));
    let ratio = turner.map_or("-".into(), |t| format!("{:.2}x", t.seconds / reach.seconds));
    (shown(reach), ratio)
}

fn shown(reach: Reach) -> String {
    format!("{}{}", if reach.measured { "" } else { "~" }, text::seconds(reach.seconds))
}

fn width(series: &[Series]) -> usize {
    series.iter().map(|s| s.renderer.chars().count()).max().unwrap_or(0).max(8)
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::Measured;
    use super::*;

    /// A renderer whose error is `at_a_second` divided by its seconds.
    pub(in super::super) fn series(renderer: &str, at_a_second: f64) -> Series {
        let measured = |k: i32| Measured {
            samples: 1 << k,
            seconds: vec![f64::from(1 << k); 3],
            errors: vec![Some(at_a_second / f64::from(1 << k)); 3],
        };
        Series {
            scene: "s1".into(),
            renderer: renderer.into(),
            version: "3".into(),
            threads: 2,
            width: 1000,
            height: 1000,
            start: 1.5,
            measured: (0..4).map(measured).collect(),
        }
    }

    #[test]
    fn ratios_compare_times_to_the_same_error() {
        let all = [series("turner", 0.02), series("cycles", 0.08)];
        let text = markdown(&all);
        let row = text.lines().last().unwrap();
        assert_eq!(row, "| s1 | 2 | cycles 3 | 1.50 s | 8.00 s | 0.25x | ~80.0 s | 0.25x | 1.00 |");
        assert!(summary(&all).contains("0.25x"), "{}", summary(&all));
        let json = lines(&all);
        let last: serde_json::Value = serde_json::from_str(json.lines().last().unwrap()).unwrap();
        assert_eq!(last["reach"][0]["measured"], true);
        assert_eq!(json.lines().count(), 10);
    }

    #[test]
    fn without_references_there_are_times_but_no_errors() {
        let mut s = series("turner", 1.0);
        s.measured.iter_mut().for_each(|m| m.errors = vec![None; 3]);
        assert!(rows(std::slice::from_ref(&s)).contains("       -"));
        assert!(markdown(&[s]).contains("| - |"));
    }
}
