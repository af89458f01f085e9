//! Preview pictures, and pictures from scene values.

use std::sync::atomic::AtomicBool;

use turner::Picture;
use turner::color::{ColorScale, Spectrum, heat};
use turner::film::{DisplayTransform, ErrorEstimate, auto_exposure};
use turner::integrator::Prepared;
use turner::math::elementary::ln;
use turner::preview::{Effort, Preview, PreviewOptions};
use turner::schema::SceneError;

use super::{Display, Stage};

/// A picture ready to show.
pub(super) struct Shown {
    pub(super) picture: Picture,
    pub(super) transform: DisplayTransform,
    pub(super) stage: Stage,
    pub(super) noise: Option<f64>,
    pub(super) scale: Option<ColorScale>,
}

/// How a preview frame is wanted.
pub(super) struct Ask<'a> {
    pub(super) size: [u32; 2],
    pub(super) moving: bool,
    pub(super) threads: usize,
    pub(super) stop: &'a AtomicBool,
}

/// Draws preview frames.
#[derive(Default)]
pub(super) struct Draft {
    preview: Preview,
    frame: u32,
    /// Whether the last frame was one of a moving view.
    moved: bool,
}

impl Draft {
    /// Whether further frames of the same picture are better than the first.
    pub(super) fn refines(&self, prepared: &Prepared) -> bool {
        self.moved || prepared.path().is_some()
    }

    /// Draws a frame; `None` if it was stopped.
    pub(super) fn draw(
        &mut self,
        prepared: &Prepared,
        ask: &Ask<'_>,
        display: Display,
    ) -> Result<Option<Shown>, SceneError> {
        let effort = if ask.moving { Effort::Moving } else { Effort::Still };
        let options = PreviewOptions {
            threads: ask.threads,
            cancel: ask.stop,
            effort,
            frame: self.frame,
            size: ask.size,
        };
        self.frame = self.frame.wrapping_add(1);
        if !self.preview.frame(prepared, &options)? {
            return Ok(None);
        }
        self.moved = ask.moving;
        let drawn = self.preview.picture();
        let values = drawn.color.iter().zip(&drawn.alpha);
        let linear = values.map(|(&[r, g, b], &alpha)| [r, g, b, alpha]).collect();
        let (mut picture, transform) = picture(prepared, [drawn.width, drawn.height], linear, ask.threads);
        let mut scale = prepared.integrator.scale(&picture);
        if display == Display::FalseColor {
            show_stops(&mut picture);
            scale = Some(scale_of_stops());
        }
        Ok(Some(Shown { picture, transform, stage: Stage::Preview, noise: None, scale }))
    }
}

/// A picture from scene values, with the display values that the film's settings and the integrator give it.
pub(super) fn picture(
    prepared: &Prepared,
    size: [u32; 2],
    linear: Vec<[f32; 4]>,
    threads: usize,
) -> (Picture, DisplayTransform) {
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

/// Stops of false colours, on each side of middle grey.
const STOPS: f64 = 5.0;

/// The scale of false colours.
pub(super) fn scale_of_stops() -> ColorScale {
    ColorScale::linear(-STOPS, STOPS, "stops around middle grey")
}

/// The scale of noise.
pub(super) fn scale_of_noise() -> ColorScale {
    ColorScale::linear(0.0, 100.0, "% error")
}

/// The colour map for values from 0 to 1, in 256 steps.
fn heats() -> Vec<[u8; 4]> {
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let color = |i: u16| {
        let [r, g, b] = heat(f32::from(i) / 255.0).to_array();
        [byte(r), byte(g), byte(b), 255]
    };
    (0..256).map(color).collect()
}

/// Shows luminance in stops around middle grey, at the picture's exposure.
pub(super) fn show_stops(picture: &mut Picture) {
    let heats = heats();
    let exposure = picture.exposure;
    for (shown, &[r, g, b, _]) in picture.display.iter_mut().zip(&picture.linear) {
        let luminance = f64::from(Spectrum::new(r, g, b).luminance());
        let stops = ln(luminance.max(1e-12) / 0.18) * std::f64::consts::LOG2_E + exposure;
        let place = ((stops / STOPS + 1.0) * 127.5).clamp(0.0, 255.0) as usize;
        *shown = heats[place];
    }
}

/// Shows the relative error of each pixel.
pub(super) fn show_noise(picture: &mut Picture, error: &ErrorEstimate) {
    let heats = heats();
    for (shown, (half, luminance)) in
        picture.display.iter_mut().zip(error.half_width.iter().zip(&error.luminance))
    {
        let relative = half / luminance.max(1e-6);
        *shown = heats[(relative.clamp(0.0, 1.0) * 255.0) as usize];
    }
}
