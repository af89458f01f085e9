//! The film that settles: exactly the samples of `turner render`, in slices short enough to be shown and stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use turner::film::{Aov, Denoise};
use turner::integrator::Prepared;
use turner::render::AovValues;
use turner::schema::SceneError;
use turner::{PassOptions, Renderer};

use super::Stage;
use super::develop::{self, Shown};

/// Time of a slice of the first pass.
const SLICE: Duration = Duration::from_millis(250);

/// Moments after the film began, in seconds, when it is shown; later ones are 1.5 times apart.
const MOMENTS: [f64; 4] = [0.5, 1.0, 1.5, 2.5];

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
        let due = self.seconds() >= self.next && self.renderer.is_covered();
        if due {
            let later = MOMENTS.into_iter().find(|moment| *moment > self.seconds());
            self.next = later.unwrap_or(self.seconds() * 1.5);
        }
        Ok(if due || self.is_complete() { Step::Show } else { Step::More })
    }

    /// The picture so far. Until the film is complete, a denoiser removes its noise.
    pub(super) fn picture(&mut self, mix: &[(String, f32)], threads: usize) -> Shown {
        let complete = self.is_complete();
        let mode = match () {
            () if complete => self.wanted,
            () if !self.renderer.denoises() => Denoise::Off,
            () if self.seconds() < THOROUGH => Denoise::Fast,
            () => Denoise::On,
        };
        let mut picture = self.renderer.develop_as(mode, threads);
        let film = &self.renderer.prepared().view.film;
        let mut transform = picture.transform(film);
        if mix.iter().any(|(_, factor)| *factor != 1.0) {
            let linear = self.mixed(mix, &picture.linear, threads);
            let size = [picture.width, picture.height];
            (picture, transform) = develop::picture(self.renderer.prepared(), size, linear, threads);
        }
        let noise = self.renderer.film.noise(threads).map(|noise| noise.value);
        let samples = self.samples().0;
        let stage = match complete {
            true => Stage::Settled,
            false => Stage::Film { samples, denoised: mode != Denoise::Off },
        };
        Shown { picture, transform, stage, noise }
    }

    /// The picture with each light group times its factor: the sum of the film's channels of light groups.
    fn mixed(&self, mix: &[(String, f32)], whole: &[[f32; 4]], threads: usize) -> Vec<[f32; 4]> {
        let mut linear = whole.to_vec();
        let names = self.renderer.prepared().scene.light_groups.names();
        let aovs = self.renderer.develop_aovs(threads);
        let channels: Vec<&AovValues> =
            aovs.iter().filter(|c| c.aov == Aov::LightGroups).map(|c| &c.values).collect();
        for (name, factor) in mix {
            let Some(group) = names.iter().position(|own| own == name) else { continue };
            for color in 0..3 {
                let Some(AovValues::Float(values)) = channels.get(group * 3 + color) else { continue };
                for (pixel, value) in linear.iter_mut().zip(values) {
                    pixel[color] += (factor - 1.0) * value;
                }
            }
        }
        linear
    }
}
