//! The film that settles: exactly the samples of `turner render`, in slices short enough to be shown and stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use turner_host::time::Instant;

use turner::color::Spectrum;
use turner::film::Denoise;
use turner::integrator::Prepared;
use turner::schema::SceneError;
use turner::{PassOptions, Renderer};

use super::develop::{self, Shown};
use super::{Display, Look, Stage};

/// The film is first shown this many seconds after it began. Each later time is at least 1.5 times the one before.
const FIRST: f64 = 0.5;

/// The film replaces the preview at this many samples per pixel: from two samples the denoiser estimates the noise of a
/// pixel. After `PATIENCE`, in seconds, the film is shown with any number of samples, and also between samples.
const LEAST: u32 = 2;
const PATIENCE: f64 = 6.0;

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
    renderer: Arc<Renderer>,
    /// The denoiser of the description, which the settled picture has.
    wanted: Denoise,
    /// Time of all steps.
    spent: Duration,
    /// The earliest time at which the film is shown next, in seconds.
    next: f64,
    /// Samples per pixel of the film when it was last shown.
    shown: Option<u32>,
}

impl Settle {
    pub(super) fn new(prepared: &Prepared, wanted: Denoise) -> Result<Settle, SceneError> {
        let renderer = Renderer::new(prepared.clone())?;
        Ok(Settle { renderer: Arc::new(renderer), wanted, spent: Duration::ZERO, next: FIRST, shown: None })
    }

    /// Continues the film with a new preparation that differs only in how the picture is displayed. If the samples would
    /// be others, the error returns the film, unless it is already freed.
    pub(super) fn continued(self, to: &Prepared, wanted: Denoise) -> Result<Settle, Option<Settle>> {
        let from = self.renderer.prepared();
        let same = Arc::ptr_eq(&from.scene, &to.scene)
            && Arc::ptr_eq(&from.integrator, &to.integrator)
            && from.view.camera == to.view.camera
            && self.wanted == wanted;
        if !same || self.renderer.film.samples() == 0 {
            return Err(Some(self));
        }
        let Settle { renderer, wanted, spent, next, shown } = self;
        let settle = |renderer| Settle { renderer, wanted, spent, next, shown };
        // While the finished picture is denoised, the film is not free.
        let renderer = match Arc::try_unwrap(renderer) {
            Ok(renderer) => renderer,
            Err(renderer) => return Err(Some(settle(renderer))),
        };
        let resumed = Renderer::resume(to.clone(), renderer.film);
        resumed.map(|renderer| settle(Arc::new(renderer))).map_err(|_| None)
    }

    pub(super) fn is_complete(&self) -> bool {
        self.renderer.is_complete()
    }

    /// What counts as work on the film while it exists.
    pub(super) fn held(&self) -> impl Sized + Send + 'static + use<> {
        Arc::clone(&self.renderer)
    }

    /// Whether a thread works on the picture of [`Settle::finish`], or has not shown it yet.
    pub(super) fn is_being_denoised(&self) -> bool {
        Arc::strong_count(&self.renderer) > 1
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
    pub(super) fn step(
        &mut self,
        stop: &AtomicBool,
        threads: usize,
        slice: Duration,
    ) -> Result<Step, SceneError> {
        let started = Instant::now();
        // The photons of a sample index are traced before its camera samples, and lost if they are stopped: such a pass has
        // no slices. (Before the choice of the integrator nobody knows.)
        let integrator = Arc::clone(&self.renderer.prepared().integrator);
        let slices = integrator.has_chosen() && !integrator.finds_photons();
        let in_time = |_: usize, _: usize| {
            if slices && started.elapsed() >= slice {
                stop.store(true, Ordering::SeqCst);
            }
        };
        let options = PassOptions { threads, cancel: stop, progress: Some(&in_time) };
        let Some(renderer) = Arc::get_mut(&mut self.renderer) else { return Ok(Step::More) };
        renderer.pass(1, &options)?;
        self.spent += started.elapsed();
        // The preview is better than the first samples of a path tracer.
        let is_previewed = self.renderer.prepared().path().is_some();
        let least = if is_previewed && self.seconds() < PATIENCE { LEAST } else { 0 };
        let samples = self.samples().0;
        let is_new = self.shown != Some(samples) || self.seconds() >= PATIENCE;
        let enough = self.renderer.is_covered() && samples >= least && is_new;
        let due = self.seconds() >= self.next && enough;
        if due {
            (self.next, self.shown) = (self.seconds() * 1.5, Some(samples));
        }
        Ok(if due || self.is_complete() { Step::Show } else { Step::More })
    }

    /// The names of the layers of light that the film holds apart for the mixer. The scene may ask for other AOVs of light,
    /// too, which hold the same light once more.
    pub(super) fn layers(&self, look: &Look) -> Vec<String> {
        self.renderer.light_layers_of(&look.layers.aovs())
    }

    /// The thorough denoiser of a finished picture takes up to a second: this does it, in any thread, until it is cancelled.
    /// `None` if the picture has no such denoiser, or shows something else.
    pub(super) fn finish(
        &self,
        look: &Look,
    ) -> Option<impl FnOnce(usize, &AtomicBool) -> Option<Shown> + Send + 'static + use<>> {
        let is_plain = look.display == Display::Picture && look.mix.iter().all(|(_, factor)| *factor == 1.0);
        if !self.is_complete() || !self.is_thorough() || !is_plain {
            return None;
        }
        let (renderer, wanted) = (Arc::clone(&self.renderer), self.wanted);
        Some(move |threads, cancel: &AtomicBool| {
            let picture = renderer.develop_unless_cancelled(wanted, threads, cancel)?;
            let transform = picture.transform(&renderer.prepared().view.film);
            let noise = renderer.film.noise(threads).map(|noise| noise.value);
            Some(Shown { picture, transform, stage: Stage::Settled, noise, scale: None })
        })
    }

    /// Whether the picture of the description is denoised thoroughly.
    fn is_thorough(&self) -> bool {
        matches!(self.wanted, Denoise::On | Denoise::Oidn) && self.renderer.denoises()
    }

    /// The picture so far. Until the film is complete, the fast denoiser removes its noise. `None` if `cancel` was set
    /// meanwhile: then the picture is still to be shown. See also [`Settle::finish`].
    pub(super) fn picture(&mut self, look: &Look, threads: usize, cancel: &AtomicBool) -> Option<Shown> {
        let complete = self.is_complete();
        let changed = look.mix.iter().any(|(_, factor)| *factor != 1.0);
        let waits = complete && self.is_thorough();
        let mode = match () {
            () if complete && !waits => self.wanted,
            () if !self.renderer.denoises() => Denoise::Off,
            () => Denoise::Fast,
        };
        let layers = if changed { self.layers(look) } else { Vec::new() };
        let mut picture = if layers.is_empty() {
            self.renderer.develop_unless_cancelled(mode, threads, cancel)?
        } else {
            let factor =
                |layer: &String| look.mix.iter().find(|(name, _)| name == layer).map_or(1.0, |(_, f)| *f);
            let mix: Vec<(&str, Spectrum)> =
                layers.iter().map(|layer| (layer.as_str(), Spectrum::grey(factor(layer)))).collect();
            self.renderer.mixed(&mix, threads)
        };
        let transform = picture.transform(&self.renderer.prepared().view.film);
        let noise = self.renderer.film.noise(threads).map(|noise| noise.value);
        let mut scale = self.renderer.prepared().integrator.scale(&picture);
        match look.display {
            Display::Picture => {}
            Display::FalseColor => {
                develop::show_stops(&mut picture);
                scale = Some(develop::scale_of_stops());
            }
            Display::Noise => {
                if let Some(error) = self.renderer.film.error(threads) {
                    develop::show_noise(&mut picture, &error);
                    scale = Some(develop::scale_of_noise());
                }
            }
        }
        let samples = self.samples().0;
        let denoised = mode != Denoise::Off && layers.is_empty();
        let is_plain = layers.is_empty() && look.display == Display::Picture;
        let stage = match complete && !(waits && is_plain) {
            true => Stage::Settled,
            false => Stage::Film { samples, denoised },
        };
        Some(Shown { picture, transform, stage, noise, scale })
    }
}
