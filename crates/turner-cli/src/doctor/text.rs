//! Findings as text.

use turner::doctor::{Finding, PathKind, Severity};

use super::Report;
use crate::flags;
use crate::text::{columns, plural, seconds, wrap};

/// The findings, including notes if `all`, and the measurements.
pub(super) fn of(report: &Report<'_>, all: bool) -> String {
    let e = report.examination;
    let mut out = String::new();
    let shown = |f: &&Finding| all || f.severity != Severity::Note;
    for finding in e.findings.iter().filter(shown) {
        one(&mut out, finding, report);
    }
    let hidden = e.findings.iter().filter(|f| !shown(f)).count() as u64;
    if e.findings.iter().filter(shown).count() == 0 {
        out += "no problems found\n\n";
    }
    out += &measured(report);
    if hidden > 0 {
        out += &format!("{} more with --all\n", plural(hidden, "note"));
    }
    for written in report.written {
        out += &format!("{}: {}\n", written.path, written.shows);
    }
    if !report.written.is_empty() {
        let legend: Vec<String> = PathKind::ALL
            .iter()
            .map(|k| {
                let [r, g, b] = k.color();
                format!("#{r:02x}{g:02x}{b:02x} {}", k.words())
            })
            .collect();
        let mut text = String::new();
        wrap(&mut text, &format!("colours of path-kind: {}", legend.join(", ")), 2);
        out += &text;
    }
    out
}

/// Replaces control characters, because names come from the scene file and must not control the terminal.
fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

fn one(out: &mut String, f: &Finding, report: &Report<'_>) {
    *out += &format!("{}[{}]: {}\n", f.severity.word(), f.code, clean(&f.what));
    if let Some(at) = f.span.and_then(|span| report.ready.sources.locate(span)) {
        *out += &format!("    --> {}:{}:{}\n", clean(at.file), at.line, at.column);
    }
    for (label, text) in [("why", &f.why), ("remedy", &f.remedy)] {
        if !text.is_empty() {
            let mut wrapped = String::new();
            wrap(&mut wrapped, &format!("{label}: {}", clean(text)), 4);
            *out += &wrapped;
        }
    }
    if !f.remedies.is_empty() {
        let flags: Vec<String> = f.remedies.iter().map(|r| clean(&flags::of(r))).collect();
        *out += &format!("    try: {}\n", flags.join("   or: "));
    }
    out.push('\n');
}

fn percent(v: f64) -> String {
    format!("{:.0} %", 100.0 * v)
}

fn measured(report: &Report<'_>) -> String {
    let s = &report.examination.summary;
    let mut rows: Vec<(&str, String)> = Vec::new();
    let samples = if s.samples > 1 { format!(", {} samples each", s.samples) } else { String::new() };
    let cut = if s.complete { "" } else { "; stopped by the time limit" };
    rows.push(("probed", format!("{} pixels{samples}, in {}{cut}", s.pixels, seconds(report.seconds))));
    let [low, median, high] = s.shown;
    rows.push((
        "brightness",
        format!("{low:.2} to {high:.2} of 1 as displayed, median {median:.2}; {} white", percent(s.white)),
    ));
    if let (Some(error), Some(wanted), false) = (s.error, s.samples_wanted, s.black) {
        rows.push((
            "noise",
            format!("expected error {error:.2e} (relMSE); {} for 0.01", plural(wanted, "sample")),
        ));
    }
    rows.push((
        "cost",
        format!(
            "{:.1} surfaces and {:.1} shadow rays per sample, {:.0} boxes and shapes per camera ray",
            s.surfaces_per_sample, s.shadow_rays_per_sample, s.steps_per_ray
        ),
    ));
    let kinds: Vec<String> = s
        .kinds
        .iter()
        .filter(|k| k.light > 0.005 || k.variance > 0.005)
        .map(|k| {
            format!(
                "{} {} of the light, {} of the variance",
                k.kind.word(),
                percent(k.light),
                percent(k.variance)
            )
        })
        .collect();
    if !kinds.is_empty() {
        rows.push(("paths", kinds.join("; ")));
    }
    let lights: Vec<String> = s
        .lights
        .iter()
        .take(6)
        .map(|l| {
            format!(
                "{} reaches {} of the surfaces, irradiance {:.3}",
                clean(&l.name),
                percent(l.reaches),
                l.irradiance
            )
        })
        .collect();
    if !lights.is_empty() {
        let more = s.emitters.saturating_sub(lights.len());
        let more = if more > 0 { format!("; {more} more") } else { String::new() };
        rows.push(("lights", format!("{}{more}", lights.join("; "))));
    }
    columns(rows.iter().map(|(name, what)| (*name, what.clone())))
}
