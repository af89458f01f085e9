//! Findings as JSON. docs/reference/doctor.md describes the format.

use serde_json::{Map, Value, json};
use turner::doctor::{Finding, PathKind};

use turner::doctor::Examination;
use turner_io::scene::Sources;

use super::Report;
use crate::flags;

/// Format version. Increased if keys are removed or change their meaning; new keys may be added without an increase.
const VERSION: u32 = 2;

pub(super) fn of(report: &Report<'_>, scene: &str) -> Value {
    let mut out = examination(report.examination, &report.ready.sources);
    let maps: Vec<Value> = report
        .written
        .iter()
        .map(|w| json!({ "file": w.path, "maps": w.names, "ranges": w.ranges }))
        .collect();
    out["scene"] = json!(scene);
    out["scene_hash"] = json!(report.ready.hash.whole);
    out["maps"] = json!(maps);
    out["seconds"] = json!(report.seconds);
    out
}

/// What does not depend on files and time.
pub(super) fn examination(examination: &Examination, sources: &Sources) -> Value {
    let s = &examination.summary;
    let kinds: Vec<Value> = s
        .kinds
        .iter()
        .map(|k| json!({ "kind": k.kind.word(), "light": k.light, "variance": k.variance }))
        .collect();
    let lights: Vec<Value> = s
        .lights
        .iter()
        .map(|l| {
            json!({
                "name": l.name,
                "irradiance": l.irradiance,
                "irradiance_blocked": l.blocked_irradiance,
                "reaches": l.reaches,
                "light": l.light,
                "variance": l.variance,
            })
        })
        .collect();
    let legend: Map<String, Value> =
        PathKind::ALL.iter().map(|k| (k.word().to_owned(), json!(k.color()))).collect();
    json!({
        "format": "turner-doctor",
        "version": VERSION,
        "findings": examination.findings.iter().map(|f| finding(f, sources)).collect::<Vec<_>>(),
        "summary": {
            "pixels": s.pixels,
            "samples": s.samples,
            "complete": s.complete,
            "brightness": s.shown,
            "white": s.white,
            "hit": s.hit_fraction,
            "black": s.black,
            "error": s.error,
            "samples_needed": s.samples_wanted,
            "surfaces_per_sample": s.surfaces_per_sample,
            "shadow_rays_per_sample": s.shadow_rays_per_sample,
            "steps_per_ray": s.steps_per_ray,
            "kinds": kinds,
            "lights": lights,
            "emitters": s.emitters,
        },
        "legend": legend,
    })
}

fn finding(f: &Finding, sources: &Sources) -> Value {
    let at = f.span.and_then(|span| sources.locate(span));
    let measured: Map<String, Value> =
        f.measured.iter().map(|m| (m.name.to_owned(), json!({ "value": m.value, "unit": m.unit }))).collect();
    json!({
        "code": f.code,
        "severity": f.severity.word(),
        "question": f.question.word(),
        "what": f.what,
        "why": f.why,
        "remedy": f.remedy,
        "flags": f.remedies.iter().map(flags::of).collect::<Vec<_>>(),
        "subject": f.subject,
        "file": at.as_ref().map(|at| at.file),
        "line": at.as_ref().map(|at| at.line),
        "column": at.as_ref().map(|at| at.column),
        "measured": measured,
    })
}
