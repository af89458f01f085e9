//! Results as text and JSON.

use std::collections::BTreeMap;

use serde_json::json;
use turner_cli::text;

use super::Left;
use crate::statistics::geometric_mean;

/// Pixels of the picture that seconds are for.
const PIXELS: f64 = 1280.0 * 720.0;

/// A line per number of samples and denoiser.
pub(super) fn rows(rows: &[Left], json: bool) {
    for row in rows {
        let Left { scene, samples, denoiser, noisy, errors, left, seconds } = row;
        let seconds = seconds * PIXELS;
        let line = if json {
            json!({
                "scene": scene, "samples": samples, "denoiser": denoiser, "seconds": seconds,
                "noisy": { "relmse": noisy[0], "flip": noisy[1] },
                "left": left.map(|[estimate, truth]| json!({ "estimate": estimate, "true": truth })),
                "denoised": { "relmse": errors[0], "flip": errors[1] },
            })
            .to_string()
        } else {
            let [relmse, flip] = [0, 1].map(|k| errors[k] / noisy[k]);
            let left = left.map_or(String::new(), |[estimate, truth]| {
                format!("  left {:.1} %, estimated {:.1} %", 100.0 * truth, 100.0 * estimate)
            });
            format!(
                "{scene:24}  {samples:>4}  {denoiser:8}  relMSE {relmse:.3}  FLIP {flip:.3}  {seconds:.3} s{left}"
            )
        };
        text::print(&format!("{line}\n"));
    }
}

/// Geometric means over the scenes; for Turner's denoisers also relative to Open Image Denoise.
pub(super) fn means(all: &[Left]) {
    let mut groups: BTreeMap<(u32, &str), Vec<&Left>> = BTreeMap::new();
    for row in all {
        groups.entry((row.samples, &row.denoiser)).or_default().push(row);
    }
    let mean = |values: &mut dyn Iterator<Item = f64>| geometric_mean(values).unwrap_or(f64::NAN);
    for ((samples, denoiser), rows) in &groups {
        let [relmse, flip] = [0, 1].map(|k| mean(&mut rows.iter().map(|row| row.errors[k] / row.noisy[k])));
        let seconds = rows.iter().map(|row| row.seconds).fold(0.0, f64::max) * PIXELS;
        let mut line = format!(
            "{:24}  {samples:>4}  {denoiser:8}  relMSE {relmse:.3}  FLIP {flip:.3}",
            "geometric mean"
        );
        line += &format!("  {seconds:.3} s at most");
        if let Some(others) = groups.get(&(*samples, "oidn")).filter(|_| *denoiser != "oidn") {
            let [relmse, flip] = [0, 1].map(|k| {
                let ratio = |(own, other): (&&Left, &&Left)| own.errors[k] / other.errors[k];
                let all: Vec<f64> = rows.iter().zip(others).map(ratio).collect();
                (mean(&mut all.iter().copied()), all.iter().copied().fold(0.0, f64::max))
            });
            line += &format!(
                "; over OIDN: relMSE {:.3}, at most {:.2}; FLIP {:.3}, at most {:.2}",
                relmse.0, relmse.1, flip.0, flip.1
            );
        }
        text::print(&format!("{line}\n"));
    }
}
