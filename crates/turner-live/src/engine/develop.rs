//! Preview pictures: from the library's preview, or for other integrators a sample per pixel.

use std::sync::atomic::AtomicBool;

use turner::film::{DisplayTransform, FilmDesc, auto_exposure};
use turner::integrator::Prepared;
use turner::schema::SceneError;
use turner::{Picture, Renderer};

use super::Stage;

/// A picture ready to show.
pub(super) struct Shown {
    pub(super) picture: Picture,
    pub(super) transform: DisplayTransform,
    pub(super) stage: Stage,
    pub(super) noise: Option<f64>,
}

/// How a preview frame is wanted.
pub(super) struct Ask<'a> {
    pub(super) size: [u32; 2],
    pub(super) moving: bool,
    /// Number of the frame since the last change.
    pub(super) frame: u32,
    pub(super) threads: usize,
    pub(super) stop: &'a AtomicBool,
}

/// Draws preview frames.
#[derive(Default)]
pub(super) struct Draft {}

impl Draft {
    /// Whether further frames of the same picture are better than the first.
    pub(super) fn refines(&self, _: &Prepared) -> bool {
        false
    }

    /// Draws a frame; `None` if it was stopped.
    pub(super) fn draw(&mut self, prepared: &Prepared, ask: &Ask<'_>) -> Result<Option<Shown>, SceneError> {
        let _ = (ask.moving, ask.frame);
        let mut small = prepared.clone();
        small.view.film = FilmDesc { width: ask.size[0] / 2 + 1, height: ask.size[1] / 2 + 1, ..prepared.view.film.clone() };
        small.view.film.samples = 1;
        let mut renderer = Renderer::new(small)?;
        let options = turner::PassOptions { threads: ask.threads, cancel: ask.stop, progress: None };
        if !renderer.preview_pass(&options)? {
            return Ok(None);
        }
        let picture = renderer.develop_as(turner::film::Denoise::Off, ask.threads);
        let transform = picture.transform(&prepared.view.film);
        Ok(Some(Shown { picture, transform, stage: Stage::Preview, noise: None }))
    }
}

/// A picture from scene values, with the display values that the film's settings and the integrator give it.
pub(super) fn picture(prepared: &Prepared, size: [u32; 2], linear: Vec<[f32; 4]>, threads: usize) -> (Picture, DisplayTransform) {
    let film = &prepared.view.film;
    let automatic = if film.auto_exposure { auto_exposure(&linear) } else { 0.0 };
    let has_alpha = linear.iter().any(|pixel| pixel[3] != 1.0);
    let mut picture = Picture {
        width: size[0],
        height: size[1],
        linear,
        display: Vec::new(),
        has_alpha,
        missing: 0,
        exposure: film.exposure + automatic,
    };
    let transform = picture.transform(film);
    picture.display = transform.to_8_bits(&picture.linear, threads);
    prepared.integrator.show(&mut picture);
    (picture, transform)
}
