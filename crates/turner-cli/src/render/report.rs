//! What is said after rendering: the closing line or the event `done`, and late warnings.

use std::path::Path;

use serde_json::json;
use turner::film::Film;
use turner::integrator::IntegratorDesc;
use turner::render::Renderer;
use turner::schema::{Warning, WarningKind};

use super::budget::{End, halving, noise_text, percent};
use super::trace::Traced;
use crate::output::Output;
use crate::report::Reporter;
use crate::text;

/// Warnings that are known only after rendering.
pub(super) fn late_warnings(traced: &Traced, integrator: &IntegratorDesc) -> Vec<Warning> {
    let mut out = Vec::new();
    let mut warn = |message: String| out.push(Warning::new(WarningKind::Ignored, message));
    let bad = traced.renderer.film.non_finite;
    if let Some((y, x, sample)) = bad.first {
        let n = text::plural(bad.count, "non-finite sample");
        warn(format!(
            "{n} (NaN or infinite) omitted; the first is sample {sample} of the pixel in column {x}, row {y}"
        ));
    }
    let dropped = traced.renderer.stats.dropped;
    if dropped > 0 {
        let n = text::plural(dropped, "sample");
        let remedy = match integrator {
            IntegratorDesc::Classic(_) => ": raise `integrator.max_rays` or lower `max_depth`",
            _ => "",
        };
        warn(format!("the ray tree was truncated in {n}{remedy}"));
    }
    if let Some(fault) = traced.renderer.denoiser_fault() {
        warn(format!("the picture keeps its noise: {fault}"));
    }
    out
}

/// The closing line or event.
pub(super) struct Report<'a> {
    pub(super) traced: &'a Traced,
    pub(super) written: bool,
    pub(super) load_seconds: f64,
    pub(super) save_seconds: f64,
    pub(super) hash: &'a str,
    /// The checkpoint file that was written.
    pub(super) checkpoint: Option<&'a Path>,
}

impl Report<'_> {
    /// Prints the line or sends the event.
    pub(super) fn send(&self, output: &Output, reporter: &Reporter) {
        match reporter.events {
            Some(events) => events.send(self.event(output)),
            None => reporter.line(&self.line(output)),
        }
    }

    /// The file with the AOVs, if it is another one than the picture.
    fn aov_output(&self, output: &Output) -> Option<String> {
        let path = output.aov_path(&self.traced.renderer.prepared().view.film).filter(|_| self.written)?;
        Some(path.display().to_string())
    }

    /// Samples per pixel.
    fn samples(&self) -> f64 {
        let film = &self.traced.renderer.film;
        let pixels = f64::from(film.region.width) * f64::from(film.region.height);
        film.samples() as f64 / pixels.max(1.0)
    }

    /// Samples per pixel and further seconds that would halve the noise.
    fn halving(&self) -> (f64, f64) {
        halving(self.samples(), self.traced.seconds)
    }

    fn rays_per_second(&self) -> f64 {
        self.traced.renderer.stats.total() as f64 / self.traced.seconds.max(1e-9)
    }

    fn event(&self, output: &Output) -> serde_json::Value {
        let Traced { renderer, seconds, finished, interrupted, ended, noise, fault } = self.traced;
        let (more_samples, more_seconds) = self.halving();
        let Renderer { film: Film { crop, non_finite, .. }, stats, .. } = renderer;
        json!({
            "event": "done",
            "output": self.written.then(|| output.name()),
            "aov_output": self.aov_output(output),
            "width": crop.width,
            "height": crop.height,
            "camera": crate::camera::json(&renderer.prepared().view),
            "checkpoint": self.checkpoint.map(|path| path.to_string_lossy()),
            "complete": !interrupted && fault.is_none(),
            "finished": finished,
            "seconds": { "load": self.load_seconds, "render": seconds, "save": self.save_seconds },
            "rays": {
                "camera": stats.camera,
                "shadow": stats.shadow,
                "reflected": stats.reflected,
                "refracted": stats.refracted,
                "light": stats.light,
                "total": stats.total(),
            },
            "rays_per_second": self.rays_per_second(),
            "samples": renderer.film.samples(),
            "ended_by": ended.map(End::word),
            "denoised": renderer.denoises() && renderer.denoiser_fault().is_none(),
            "error_after_denoising": renderer.left_after_denoising(),
            "noise": noise.map(|noise| json!({
                "value": noise.value,
                "interval": noise.interval,
                "halving": { "samples_per_pixel": more_samples, "seconds": more_seconds },
            })),
            "non_finite": {
                "count": non_finite.count,
                "first": non_finite.first.map(|(y, x, sample)| json!({ "x": x, "y": y, "sample": sample })),
            },
            "scene_hash": self.hash,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// `scene.png: 640x480, 64 samples per pixel, 12.3 s`.
    fn line(&self, output: &Output) -> String {
        let Traced { renderer, seconds, finished, interrupted, fault, noise, .. } = self.traced;
        let film = &renderer.film;
        let name = if output.is_stdout() { "standard output".to_owned() } else { output.name() };
        let mut line = format!("{name}: {}x{}, ", film.crop.width, film.crop.height);
        if *interrupted || fault.is_some() {
            // Rounded down: an unfinished picture is never at 100 %.
            let percent = (finished * 100.0).floor();
            let why = if *interrupted { "interrupted" } else { "stopped by an error" };
            let kept = if self.written { "" } else { ", nothing written" };
            line += &format!("{why} at {percent} %{kept}, ");
        }
        let mean = self.samples();
        let samples = if mean.fract() == 0.0 { format!("{mean}") } else { format!("{mean:.1}") };
        let plural = if samples == "1" { "" } else { "s" };
        line += &format!("{samples} sample{plural} per pixel, {}", text::seconds(*seconds));
        if let Some(name) = self.aov_output(output) {
            line += &format!(", AOVs in {name}");
        }
        if let Some(noise) = noise {
            let is_denoised = renderer.denoises() && renderer.denoiser_fault().is_none();
            let of_raw = match renderer.left_after_denoising().filter(|_| is_denoised) {
                Some(left) => format!(" before denoising, about {} after", percent(left)),
                None if is_denoised => " before denoising".to_owned(),
                None => String::new(),
            };
            line += &format!(", noise {}{of_raw}", noise_text(noise));
            let (samples, seconds) = self.halving();
            let what = if is_denoised { "the first" } else { "it" };
            line += &format!("; {samples:.0} samples, {} more, would halve {what}", text::seconds(seconds));
        }
        if film.non_finite.count > 0 {
            line += &format!(", {}", text::plural(film.non_finite.count, "non-finite sample"));
        }
        line
    }
}
