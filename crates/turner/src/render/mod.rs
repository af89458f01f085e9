//! Rendering: passes over tiles, in parallel.
//!
//! A pass covers a range of sample indices over a set of tiles ([`PassRange`]). It has four steps:
//!
//! 1. `schedule` finds what the film lacks: for each tile the missing sample indices, and the missing light
//!    paths.
//! 2. `order` sorts the tiles by their cost in the last pass.
//! 3. `work` hands tiles and batches of light paths to threads, one after another, from an atomic counter.
//! 4. `tile` traces the samples of a tile and adds their sums to the film, once per tile.
//!
//! Samples are deterministic and the film's sums are exact, so the picture does not depend on threads, order or
//! passes. A cancel is checked between sample indices; finished samples stay in the film.

mod adaptive;
#[cfg(test)]
mod adaptive_sampling_tests;
mod aovs;
mod center_aovs;
mod coarse;
mod cryptomatte;
#[cfg(test)]
mod error_tests;
mod extend;
#[cfg(test)]
mod firefly_tests;
mod light;
mod mix;
mod order;
#[cfg(test)]
mod part_tests;
mod pass;
mod pixel;
mod pixel_aovs;
#[cfg(test)]
mod pixel_tests;
#[cfg(test)]
mod reconstruction_tests;
mod refine;
#[cfg(test)]
mod refine_tests;
#[cfg(test)]
mod resume_tests;
mod schedule;
mod single;
mod tile;
mod tile_aovs;
#[cfg(test)]
mod vignetting_tests;
mod work;

pub use aovs::{AovChannel, AovValues, label_name};
pub use center_aovs::{CenterAov, center_aovs};
pub use pixel::{MAX_LISTED, PixelRecord, SampleRecord, Square, pixel};
pub use pixel_aovs::{PixelAov, pixel_aovs};
pub use schedule::{PassRange, TileSet};
pub use single::{pixel_samples, sample};

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use order::TileOrder;

use crate::denoise::{Buffers, DenoiseOptions, Denoiser, denoise, denoise_fast, left};
use crate::film::{Antialias, Denoise, Developed, Film, Picture};
use crate::integrator::{Prepared, RayStats};
use crate::schema::{ErrorCode, SceneError};

/// How a pass runs. Nothing here changes the picture.
#[derive(Clone, Copy)]
pub struct PassOptions<'a> {
    /// Number of threads; 0 uses all available ones.
    pub threads: usize,
    /// Set it to true to stop rendering. Workers check it at least once per sample index of a tile. Finished
    /// samples stay in the film.
    pub cancel: &'a AtomicBool,
    /// Called with (tasks done, tasks of this pass) from any thread, without a lock held. Tasks are tiles and
    /// batches of light paths.
    pub progress: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

/// Renders a prepared scene into a film, pass by pass.
pub struct Renderer {
    prepared: Prepared,
    /// The film with all samples so far.
    pub film: Film,
    /// Rays traced so far.
    pub stats: RayStats,
    order: TileOrder,
    /// Removes the noise for [`Denoise::Oidn`], and why it could not.
    denoiser: Option<Arc<dyn Denoiser>>,
    fault: OnceLock<String>,
    /// The error that the denoiser has left in the last picture.
    left: Mutex<Option<f64>>,
}

/// Whether films of this scene and view estimate their error: where samples are random and there are several.
fn estimates_error(prepared: &Prepared) -> bool {
    let film = &prepared.view.film;
    prepared.view.sobol && film.antialias == Antialias::MonteCarlo && film.samples > 1
}

/// Whether films of this scene and view distribute their samples by the noise.
fn is_adaptive(prepared: &Prepared) -> bool {
    prepared.view.film.adaptive_sampling && estimates_error(prepared)
}

impl Renderer {
    /// A renderer with an empty film.
    ///
    /// Errors: those of [`Film::new`].
    pub fn new(prepared: Prepared) -> Result<Renderer, SceneError> {
        let mut film = Film::new(&prepared.view.film)?;
        if estimates_error(&prepared) {
            film.estimate_error()?;
        }
        if is_adaptive(&prepared) {
            film.sample_adaptively();
        }
        film.take_light(prepared.integrator.light_paths())?;
        film.note_cluster(prepared.integrator.cluster());
        let order = TileOrder::new(film.tiles().count());
        let (stats, fault) = (RayStats::default(), OnceLock::new());
        Ok(Renderer { prepared, film, stats, order, denoiser: None, fault, left: Mutex::default() })
    }

    /// A renderer that continues a film of the same picture: a saved or merged one.
    ///
    /// Errors: the film belongs to another picture ([`ErrorCode::Conflict`]). The fingerprint of the scene is not
    /// compared.
    pub fn resume(prepared: Prepared, film: Film) -> Result<Renderer, SceneError> {
        prepared.choose(1);
        let mut renderer = Renderer::new(prepared)?;
        let mut own = renderer.film.identity().clone();
        own.scene = film.identity().scene;
        let own_film = &renderer.film;
        let channels = (film.channels() != own_film.channels() || film.labels() != own_film.labels())
            .then(|| "it has other channels (`aovs`, `denoise`) than this picture".to_owned());
        match own.difference(film.identity()).or(channels) {
            Some(difference) => {
                let message = format!("the film is of another picture; {difference}");
                let help = "take a film of this scene with the same settings, or give the scene the settings of the film";
                Err(SceneError::new(ErrorCode::Conflict, message).help(help))
            }
            None => {
                renderer.film = film;
                Ok(renderer)
            }
        }
    }

    /// The prepared scene.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Samples per pixel of the finished picture. Adaptive subdivision counts as one.
    pub fn samples_per_pixel(&self) -> u32 {
        self.prepared.view.film.samples_per_pixel()
    }

    /// Gives the denoiser for [`Denoise::Oidn`]. Without one, Turner's own takes its place.
    pub fn denoise_with(&mut self, denoiser: Arc<dyn Denoiser>) {
        self.denoiser = Some(denoiser);
    }

    /// The picture so far as rows, without noise if the film's `denoise` asks for it and the picture has at most 16
    /// million pixels. `threads` of 0 uses all. Debug views are not told apart.
    pub fn developed(&self, threads: usize) -> Developed<'_> {
        self.developed_as(self.prepared.view.film.denoise, threads)
    }

    /// The same by the denoiser `mode`. The film's `denoise` must not be [`Denoise::Off`]; else the picture keeps its noise.
    pub fn developed_as(&self, mode: Denoise, threads: usize) -> Developed<'_> {
        self.developed_unless_cancelled(mode, threads, None)
            .unwrap_or_else(|| self.film.developed(&self.prepared.view.film, threads))
    }

    /// [`Renderer::developed_as`] that returns `None` within milliseconds once `cancel` is set.
    fn developed_unless_cancelled(
        &self,
        mode: Denoise,
        threads: usize,
        cancel: Option<&AtomicBool>,
    ) -> Option<Developed<'_>> {
        let is_cancelled = || cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        let mut developed = self.film.developed(&self.prepared.view.film, threads);
        if mode == Denoise::Off {
            return Some(developed);
        }
        if is_cancelled() {
            return None;
        }
        let options = DenoiseOptions { threads, set: self.prepared.view.instruction_set, cancel };
        let buffers = match mode {
            Denoise::Fast => self.denoising_buffers(&developed, threads),
            Denoise::Off | Denoise::On | Denoise::Oidn => self.refined_buffers(&developed, threads),
        };
        if let Some(buffers) = buffers
            && let Some(colors) = self.denoised(mode, &buffers, &options)
        {
            if mode != Denoise::Fast {
                let left = left(&buffers, &colors, threads, &|b| self.denoised(mode, b, &options));
                *self.left.lock().unwrap_or_else(PoisonError::into_inner) = left;
            }
            developed.recolor(&colors);
        }
        (!is_cancelled()).then_some(developed)
    }

    /// The colours without noise; `None` if the denoiser fails or is cancelled.
    fn denoised(
        &self,
        mode: Denoise,
        buffers: &Buffers,
        options: &DenoiseOptions<'_>,
    ) -> Option<Vec<[f32; 3]>> {
        match (mode, &self.denoiser) {
            (Denoise::Off, _) => None,
            (Denoise::Oidn, Some(denoiser)) => match denoiser.denoise(buffers, options.threads) {
                Ok(colors) if colors.len() == buffers.width * buffers.height => Some(colors),
                other => {
                    let why = other.err().unwrap_or_else(|| "it gave a picture of another size".to_owned());
                    let _ = self.fault.set(why);
                    None
                }
            },
            (Denoise::Fast, _) => denoise_fast(buffers, options),
            (Denoise::On | Denoise::Oidn, _) => denoise(buffers, options),
        }
    }

    /// The error that the denoiser left in the picture that was developed last: the relative error of luminance that 95 % of
    /// the pixels do not exceed, estimated as in [`denoise::left`](crate::denoise::left). `None` with `denoise = "fast"`, and
    /// before a picture was denoised.
    pub fn left_after_denoising(&self) -> Option<f64> {
        *self.left.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Why the denoiser that was given failed, so that the picture kept its noise.
    pub fn denoiser_fault(&self) -> Option<&str> {
        self.fault.get().map(String::as_str)
    }

    /// What a denoiser needs, from the picture of this renderer's film. `None` without [`Renderer::denoises`].
    pub fn denoising_buffers(&self, picture: &Developed<'_>, threads: usize) -> Option<Buffers> {
        if self.denoises() { Buffers::of_film(&self.film, picture, threads) } else { None }
    }

    /// Whether [`Renderer::developed`] and [`Renderer::develop`] remove noise.
    pub fn denoises(&self) -> bool {
        self.prepared.view.film.denoise != Denoise::Off && Buffers::are_held(&self.film)
    }

    /// The name of the denoiser, if there is one: "turner", "turner fast" or that of the one that was given.
    pub fn denoiser(&self) -> Option<String> {
        self.denoises().then(|| match (self.prepared.view.film.denoise, &self.denoiser) {
            (Denoise::Oidn, Some(denoiser)) => denoiser.name(),
            (Denoise::Fast, _) => "turner fast".to_owned(),
            _ => "turner".to_owned(),
        })
    }

    /// The picture so far. Debug views replace display values as they need.
    pub fn develop(&self) -> Picture {
        self.develop_with(1)
    }

    /// Like [`Renderer::develop`], on `threads` threads; 0 uses all.
    pub fn develop_with(&self, threads: usize) -> Picture {
        self.develop_as(self.prepared.view.film.denoise, threads)
    }

    /// The same with another denoiser, as for [`Renderer::developed_as`].
    pub fn develop_as(&self, mode: Denoise, threads: usize) -> Picture {
        self.picture_unless_cancelled(mode, threads, None)
            .unwrap_or_else(|| self.film.develop(&self.prepared.view.film, threads))
    }

    /// [`Renderer::develop_as`] that returns `None` within milliseconds once `cancel` is set.
    pub fn develop_unless_cancelled(
        &self,
        mode: Denoise,
        threads: usize,
        cancel: &AtomicBool,
    ) -> Option<Picture> {
        self.picture_unless_cancelled(mode, threads, Some(cancel))
    }

    fn picture_unless_cancelled(
        &self,
        mode: Denoise,
        threads: usize,
        cancel: Option<&AtomicBool>,
    ) -> Option<Picture> {
        let mut picture = match self.denoises() {
            true => self.developed_unless_cancelled(mode, threads, cancel)?.into_picture(threads),
            false => self.film.develop(&self.prepared.view.film, threads),
        };
        self.prepared.integrator.show(&mut picture);
        Some(picture)
    }

    /// Whether every pixel of the picture shows something: a sample of its own, or the preview.
    pub fn is_covered(&self) -> bool {
        self.film.is_covered()
    }

    /// Whether all samples of all tiles are in the film.
    pub fn is_complete(&self) -> bool {
        match self.film.identity().adaptive {
            true => self.film.mean_goal() >= self.samples_per_pixel() && self.film.has_reached_goals(),
            false => self.film.first_missing() >= self.samples_per_pixel(),
        }
    }

    /// The number of rays of each tile in the last pass that completed it, row by row; 0 before.
    pub fn tile_costs(&self) -> &[u64] {
        self.order.costs()
    }
}
