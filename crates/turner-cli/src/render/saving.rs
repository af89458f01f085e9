//! How long the end of a render takes, so that `--budget` ends in time: developing, encoding and writing the picture,
//! its noise, and the checkpoint.
//!
//! Encoding is measured: a small picture of noise with the same channels is encoded like the real one. Noise takes
//! longest.

use std::time::{Duration, Instant};

use turner::film::Picture;
use turner::render::Renderer;
use turner_io::image::{ExtraChannel, SampleKind};

use super::threads;
use crate::output::Output;

/// Opening, renaming and flushing files, and the end of the program.
const LEAST: Duration = Duration::from_millis(25);

/// Pixels of the small picture: enough for all threads.
const PIXELS: u32 = 1 << 16;

/// Seconds that one thread takes to develop the colour of a pixel.
const DEVELOPED: f64 = 40e-9;
/// Seconds that one thread takes to develop an additional channel of a pixel.
const CHANNEL: f64 = 20e-9;
/// Seconds that one thread takes to estimate the error of a pixel.
const ERROR: f64 = 200e-9;

/// Seconds that one thread takes to denoise a pixel.
const DENOISED: f64 = 2.8e-6;

/// Bytes per second to the disk.
const DISK: f64 = 600e6;

/// Bytes per second of freeing memory.
const FREED: f64 = 8e9;

/// How long the end of a render takes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SavingTime {
    /// The picture and its checkpoint.
    pub(super) files: Duration,
    /// Estimating the noise, if the picture has enough samples for that.
    pub(super) noise: Duration,
}

/// An estimate for the picture of `renderer`.
pub(super) fn saving_time(
    renderer: &Renderer,
    output: &Output,
    count: usize,
    keeps_checkpoint: bool,
) -> SavingTime {
    let film = &renderer.film;
    let pixels = film.crop.area() as f64;
    let channels = film.channels().len() as f64;
    let each = DEVELOPED + CHANNEL * channels;
    let noise = if film.identity().estimates_error { ERROR } else { 0.0 } * pixels / threads(count) as f64;
    let mut seconds = pixels * each / threads(count) as f64 + film.memory() as f64 / FREED;
    if renderer.denoises() {
        seconds += DENOISED * pixels / threads(count) as f64;
    }
    if keeps_checkpoint {
        seconds += film.memory() as f64 / DISK;
    }
    if !output.is_part() {
        let (encoding, bytes) = trial(renderer, output, count);
        seconds += pixels * (encoding + bytes / DISK);
    }
    SavingTime { files: LEAST + Duration::from_secs_f64(seconds), noise: Duration::from_secs_f64(noise) }
}

/// Seconds and bytes per pixel to encode a picture of noise.
fn trial(renderer: &Renderer, output: &Output, count: usize) -> (f64, f64) {
    let crop = renderer.film.crop;
    let width = crop.width.min(1024);
    let height = (PIXELS / width).clamp(1, crop.height);
    let pixels = (width * height) as usize;
    let noise = |i: usize| {
        let hash = (i as u32 + 1).wrapping_mul(0x9e37_79b9);
        (hash ^ hash >> 15).wrapping_mul(0x85eb_ca6b) as f32 / u32::MAX as f32
    };
    let film = &renderer.prepared().view.film;
    let linear = (0..pixels).map(|i| [noise(3 * i), noise(3 * i + 1), noise(3 * i + 2), 1.0]).collect();
    let (exposure, display) = (film.exposure, Vec::new());
    let mut picture = Picture { width, height, linear, display, has_alpha: false, missing: 0, exposure };
    let extra = |c: u64| {
        let values: Vec<f32> = (0..pixels).map(|i| noise(i + c as usize)).collect();
        ExtraChannel::new(format!("c{c}"), SampleKind::Float, values)
    };
    let channels: Vec<_> = (0..film.aov_values()).map(extra).collect();
    let start = Instant::now();
    picture.display = picture.transform(film).to_8_bits(&picture.linear, count);
    let bytes = output.encoded_size(&picture, renderer, channels, count);
    (start.elapsed().as_secs_f64() / pixels as f64, bytes as f64 / pixels as f64)
}
