//! The film that settles: exactly the samples of `turner render`, in slices short enough to be shown and stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use turner::color::Spectrum;
use turner::film::Denoise;
use turner::integrator::Prepared;
use turner::schema::SceneError;
use turner::{PassOptions, Renderer};

use super::develop::{self, Shown};
use super::{Display, Look, Stage};

/// Time of a slice of the first pass.
const SLICE: Duration = Duration::from_millis(250);

/// Moments after the film began, in seconds, when it is shown; later ones are 1.5 times apart.
const MOMENTS: [f64; 4] = [0.5, 1.0, 1.5, 2.5];

/// Samples per pixel with which the film replaces the preview, and the seconds after which any film does.
const LEAST: u32 = 4;
const PATIENCE: f64 = 6.0;

/// From this time on the thorough denoiser shows the picture, in seconds.
const THOROUGH: f64 = 8.0;

/// What a step is followed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// There is something new to show.
    Show,
    /// More steps come first.
    More,
}

/// A film while it settles.
pub(super) struct Settle {
    renderer: Renderer,
    /// The denoiser of the description, which the settled picture has.
    wanted: Denoise,
    /// Time of all steps.
    spent: Duration,
    /// When the film is shown next.
    next: f64,
}

impl Settle {
    pub(super) fn new(prepared: &Prepared, wanted: Denoise) -> Result<Settle, SceneError> {
        let renderer = Renderer::new(prepared.clone())?;
        Ok(Settle { renderer, wanted, spent: Duration::ZERO, next: MOMENTS[0] })
    }

    /// This film for another preparation, if only the display differs; `None` if its samples are those of another picture.
    pub(super) fn continued(self, to: &Prepared, wanted: Denoise) -> Option<Settle> {
        let from = self.renderer.prepared();
        let same = std::sync::Arc::ptr_eq(&from.scene, &to.scene)
            && std::sync::Arc::ptr_eq(&from.integrator, &to.integrator)
            && from.view.camera == to.view.camera
            && self.wanted == wanted;
        if !same || self.renderer.film.samples() == 0 {
            return None;
        }
        let renderer = Renderer::resume(to.clone(), self.renderer.film).ok()?;
        Some(Settle { renderer, ..self })
    }

    pub(super) fn is_complete(&self) -> bool {
        self.renderer.is_complete()
    }

    /// Whether all pixels show something.
    pub(super) fn is_covered(&self) -> bool {
        self.renderer.is_covered()
    }

    /// Samples per pixel that all pixels have, and those of the finished picture.
    pub(super) fn samples(&self) -> (u32, u32) {
        let all = self.renderer.samples_per_pixel();
        (self.renderer.film.first_missing().min(all), all)
    }

    pub(super) fn seconds(&self) -> f64 {
        self.spent.as_secs_f64()
    }

    /// Seconds left, by the pace so far.
    pub(super) fn left(&self) -> Option<f64> {
        let all = self.renderer.samples_per_pixel();
        let done = self.renderer.film.finished(&(0..all));
        (done > 0.001).then(|| self.seconds() * (1.0 - done).max(0.0) / done)
    }

    /// Traces for a slice of time, or until `stop` is set.
    pub(super) fn step(&mut self, stop: &AtomicBool, threads: usize) -> Result<Step, SceneError> {
        let started = Instant::now();
        // The photons of a sample index are traced before its camera samples, and lost if they are stopped: such a pass has
        // no slices. (Before the choice of the integrator nobody knows.)
        let integrator = &self.renderer.prepared().integrator;
        let slices = integrator.has_chosen() && !integrator.finds_photons();
        let in_time = |_: usize, _: usize| {
            if slices && started.elapsed() >= SLICE {
                stop.store(true, Ordering::SeqCst);
            }
        };
        let options = PassOptions { threads, cancel: stop, progress: Some(&in_time) };
        self.renderer.pass(1, &options)?;
        self.spent += started.elapsed();
        // The preview is better than the first samples of a path tracer.
        let is_previewed = self.renderer.prepared().path().is_some();
        let least = if is_previewed && self.seconds() < PATIENCE { LEAST } else { 0 };
        let enough = self.renderer.is_covered() && self.samples().0 >= least;
        let due = self.seconds() >= self.next && enough;
        if due {
            let later = MOMENTS.into_iter().find(|moment| *moment > self.seconds());
            self.next = later.unwrap_or(self.seconds() * 1.5);
        }
        Ok(if due || self.is_complete() { Step::Show } else { Step::More })
    }

    /// The names of the layers of light that the film holds apart.
    pub(super) fn layers(&self) -> Vec<String> {
        self.renderer.light_layers()
    }

    /// The picture so far. Until the film is complete, a denoiser removes its noise.
    pub(super) fn picture(&mut self, look: &Look, threads: usize) -> Shown {
        let complete = self.is_complete();
        let changed = look.mix.iter().any(|(_, factor)| *factor != 1.0);
        let mode = match () {
            () if complete => self.wanted,
            () if !self.renderer.denoises() => Denoise::Off,
            () if self.seconds() < THOROUGH => Denoise::Fast,
            () => Denoise::On,
        };
        let layers = if changed { self.layers() } else { Vec::new() };
        let mut picture = if layers.is_empty() {
            self.renderer.develop_as(mode, threads)
        } else {
            let factor =
                |layer: &String| look.mix.iter().find(|(name, _)| name == layer).map_or(1.0, |(_, f)| *f);
            let mix: Vec<(&str, Spectrum)> =
                layers.iter().map(|layer| (layer.as_str(), Spectrum::grey(factor(layer)))).collect();
            self.renderer.mixed(&mix, threads)
        };
        let transform = picture.transform(&self.renderer.prepared().view.film);
        let noise = self.renderer.film.noise(threads).map(|noise| noise.value);
        match look.display {
            Display::Picture => {}
            Display::FalseColor => develop::show_stops(&mut picture),
            Display::Noise => {
                if let Some(error) = self.renderer.film.error(threads) {
                    develop::show_noise(&mut picture, &error);
                }
            }
        }
        let samples = self.samples().0;
        let denoised = mode != Denoise::Off && layers.is_empty();
        let stage = match complete {
            true => Stage::Settled,
            false => Stage::Film { samples, denoised },
        };
        Shown { picture, transform, stage, noise }
    }
}
