//! The fast denoiser, for previews and pictures in motion. It has one fit for each block of 4 x 4 pixels.
//!
//! It is the regression of the full denoiser with blocks in place of pixels. The sums of a fit are made once per block, so
//! that a window of 20 x 20 pixels is the weighted sum of 25 blocks:
//!
//! ```text
//!   light ÷ albedo ──► mean and variance of each block; brighter pixels are limited           here
//!   each tile: products of terms, summed over each block                                      tile
//!       weights of 5 x 5 blocks, by how similar their means are ──► one fit per block
//!       four fits around a pixel, weighted by distance and similarity, are its new light
//! ```
//!
//! Emission that is seen changes only in pixels with noise.

mod tile;

use super::light::{DOMINATED, Light, has_noise, luminance};
use super::{Buffers, DenoiseOptions, Rgb};
use crate::film::strips;

/// Side of a block.
const BLOCK: usize = 4;

/// Blocks of a window on each side.
const REACH: usize = 2;

/// The most that a noisy pixel may have of the mean luminance of its window.
const BRIGHTER: f32 = 3.0;

/// The picture with less noise: radiance of each pixel. `None` if it was cancelled.
pub(super) fn denoised(buffers: &Buffers, options: &DenoiseOptions<'_>) -> Option<Vec<Rgb>> {
    let (guides, threads) = (&buffers.guides, options.threads);
    let mut out = vec![[0.0; 3]; buffers.width * buffers.height];
    for (part, is_seen) in [(&buffers.emission, true), (&buffers.reflected, false)] {
        options.go_on()?;
        let mut light = Light::plain(buffers, part, is_seen, threads);
        Blocks::new(&light, threads).limit(&mut light, threads);
        options.go_on()?;
        let blocks = Blocks::new(&light, threads).smoothed(threads);
        let fitted = tile::fitted(&light, &blocks, guides, options)?;
        let factors = light.factors(guides);
        let before = out;
        out = strips::map(before.len(), threads, |i| {
            let (own, factor) = (&light.values[i], factors(i));
            // Lamps have pixels with noise at their edges alone.
            let fit = fitted[i].filter(|_| !is_seen || has_noise(luminance(own), light.variance[i]));
            let new = light.fitted(i, fit);
            std::array::from_fn(|c| before[i][c] + new[c] * factor[c])
        });
    }
    if !buffers.caught.is_empty() {
        let light = Light::of_caught(buffers, threads);
        let blocks = Blocks::new(&light, threads).smoothed(threads);
        let lit = tile::fitted(&light, &blocks, guides, options)?;
        buffers.add_caught(&lit, &mut out);
    }
    Some(out)
}

/// Luminance of the blocks of a picture, row by row.
struct Blocks {
    columns: usize,
    rows: usize,
    /// Means over the known pixels of each block; 0 without any.
    mean: Vec<f32>,
    /// Variances of these means.
    variance: Vec<f32>,
}

impl Blocks {
    fn new(light: &Light, threads: usize) -> Blocks {
        let (columns, rows) = (light.width.div_ceil(BLOCK), light.height.div_ceil(BLOCK));
        let each = strips::map(columns * rows, threads, |block| mean_and_variance(light, block, columns));
        let (mean, variance) = each.into_iter().unzip();
        Blocks { columns, rows, mean, variance }
    }

    /// The mean of `of` over the blocks within `reach` of a block.
    fn around(&self, block: usize, reach: usize, of: impl Fn(usize) -> f32) -> f32 {
        let (mut sum, mut count) = (0.0, 0.0);
        for near in super::around(self.columns, self.rows, block, reach) {
            sum += of(near);
            count += 1.0;
        }
        sum / count
    }

    /// Scales down noisy pixels that are brighter than [`BRIGHTER`] times the mean of their window.
    fn limit(&self, light: &mut Light, threads: usize) {
        let most = strips::map(self.mean.len(), threads, |block| {
            BRIGHTER * self.around(block, REACH, |near| self.mean[near]).max(0.0) + 1e-6
        });
        light.values = strips::map(light.values.len(), threads, |i| {
            let (x, y) = (i % light.width, i / light.width);
            let (value, most) = (light.values[i], most[y / BLOCK * self.columns + x / BLOCK]);
            let own = luminance(&value);
            let is_noisy = light.variance[i].sqrt() > DOMINATED * own;
            if own > most && is_noisy { value.map(|v| v * (most / own)) } else { value }
        });
    }

    /// The same with variances that are means of those around; dark blocks beside bright ones get the relative variance.
    fn smoothed(self, threads: usize) -> Blocks {
        let square = |block: usize| self.mean[block] * self.mean[block];
        let variance = strips::map(self.mean.len(), threads, |block| {
            let absolute = self.around(block, 1, |near| self.variance[near]);
            let relative = self.around(block, 1, |near| self.variance[near] / (square(near) + 1e-12));
            absolute.min((square(block) + 1e-12) * relative)
        });
        Blocks { variance, ..self }
    }
}

/// The mean luminance of a block and its variance: from the variances of the pixels or from their spread, whichever is
/// less.
fn mean_and_variance(light: &Light, block: usize, columns: usize) -> (f32, f32) {
    let (left, top) = (block % columns * BLOCK, block / columns * BLOCK);
    let (mut count, mut sum, mut square, mut own) = (0.0f32, 0.0f32, 0.0f32, 0.0f32);
    for y in top..(top + BLOCK).min(light.height) {
        for x in left..(left + BLOCK).min(light.width) {
            let i = y * light.width + x;
            if light.is_known(i) {
                let bright = luminance(&light.values[i]);
                count += 1.0;
                sum += bright;
                square += bright * bright;
                own += light.variance[i];
            }
        }
    }
    if count < 1.5 {
        return (sum, own);
    }
    let mean = sum / count;
    let spread = (square / count - mean * mean).max(0.0) / (count - 1.0);
    (mean, spread.min(own / (count * count)))
}
