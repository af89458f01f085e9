//! The result as JSON. docs/reference/compare.md documents the keys: new ones may be added, the meaning of a key does
//! not change.

use serde_json::{Map, Value, json};
use turner::compare::{Metric, NonFinite};

use super::Compared;

/// One object.
pub(super) fn of(c: &Compared) -> Value {
    let pair = &c.pair;
    let metrics: Map<String, Value> = c
        .measured
        .iter()
        .map(|(metric, found)| {
            let w = found.worst;
            let worst = json!({ "x": w.x, "y": w.y, "value": of_map(*metric, w.value) });
            // The PSNR of equal pictures is infinite, which JSON cannot hold: null.
            (metric.word().to_owned(), json!({ "value": finite(found.value), "worst": worst }))
        })
        .collect();
    json!({
        "reference": c.names[0],
        "picture": c.names[1],
        "width": pair.width,
        "height": pair.height,
        "resized_from": c.resized.map(|(width, height)| json!({ "width": width, "height": height })),
        "values": if pair.is_linear { "linear" } else { "display" },
        "alpha": pair.has_alpha,
        "metrics": metrics,
        "non_finite": {
            "reference": non_finite(&pair.non_finite[0]),
            "picture": non_finite(&pair.non_finite[1]),
            "differing": non_finite(&pair.unlike),
        },
        "verdict": c.verdict.as_ref().map(|v| json!({
            "metric": v.metric.word(),
            "value": finite(v.value),
            "tolerance": v.tolerance,
            "within": v.within,
        })),
        "diff": c.diff.as_ref().map(|d| json!({ "file": d.path, "metric": d.metric.word(), "maximum": d.white })),
    })
}

/// The map of SSIM holds 1 - SSIM.
fn of_map(metric: Metric, v: f32) -> f64 {
    if metric == Metric::Ssim { 1.0 - f64::from(v) } else { f64::from(v) }
}

fn finite(v: f64) -> Option<f64> {
    Some(v).filter(|v| v.is_finite())
}

fn non_finite(n: &NonFinite) -> Value {
    json!({ "count": n.count, "first": n.first.map(|(x, y)| json!({ "x": x, "y": y })) })
}
