//! The denoiser: a clean picture from few samples, by regression with features.
//!
//! The light of a pixel changes with what is seen there: its albedo, normal and distance. These *guides* are nearly free of
//! noise. So around each pixel the noisy light is fitted by a linear function of the guides, and the fit replaces the
//! light (Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings"):
//!
//! ```text
//!   samples ──► film ──► emission and reflected light, each with its variance        [`Buffers`]
//!                   └──► guides: albedo, normal, distance, each with its variance
//!
//!   guides   ──► noisy ones are averaged with similar neighbours                      guides
//!   light    ──► divided by the albedo; single bright samples are limited             light
//!   each of the two kinds of light, and shadows on shadow catchers:
//!       weights of a window of 19 x 19 pixels, by the similarity of patches           weights
//!       weighted fit: light = a + b · (x, y, albedo, normal, distance)                fit
//!       the fits around a pixel, averaged with these weights, are its new light       tile
//! ```
//!
//! Where emission and guides are noisy, the renderer first traces more camera rays ([`Renderer::refined_buffers`]).
//!
//! [`Renderer::refined_buffers`]: crate::Renderer::refined_buffers
//!
//! Emission that is seen directly has no noise but at edges and out of focus. It has fits of its own, so that lamps do not
//! bleed into what is around them.
//!
//! A fit holds for its whole window, so not every pixel needs its own: every third pixel of every third row has one, and
//! further pixels where those around them are unlike.
//!
//! Tiles and the order of all sums are fixed, so the result has the same bytes for any number of threads and any
//! instruction set.

// Loops over columns, rows and channels that are the same in several arrays, so that they become SIMD instructions.
#![allow(clippy::needless_range_loop)]

mod fast;
mod fit;
mod guides;
mod left;
mod light;
mod lines;
mod picture;
#[cfg(test)]
mod tests;
mod tile;
mod weights;

use std::sync::atomic::{AtomicBool, Ordering};

use turner_bvh::InstructionSet;

use crate::film::strips;
pub use left::left;
use light::Light;
pub(crate) use light::luminance;

/// Red, green and blue, linear.
pub type Rgb = [f32; 3];

/// Albedo (3), normal (3), binary logarithm of the distance.
pub(crate) const GUIDES: usize = 7;

/// A kind of light of each pixel.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Its mean over the samples of a pixel, row by row.
    pub mean: Vec<Rgb>,
    /// The variance of the luminance of that mean.
    pub variance: Vec<f32>,
}

/// What the denoiser works on: a picture in parts, and its guides. All lists have `width` times `height` entries, row by
/// row, and finite values.
#[derive(Clone, Debug, Default)]
pub struct Buffers {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Emitters and background, seen directly or by way of glass and mirrors.
    pub emission: Part,
    /// All other light: what surfaces and media send on.
    pub reflected: Part,
    /// Means of albedo, normal and logarithmic distance.
    pub guides: Vec<[f32; GUIDES]>,
    /// Variances of the means of albedo, normal and logarithmic distance, each summed over its components.
    pub guide_variances: Vec<[f32; 3]>,
    /// The shadow catchers; empty without them.
    pub caught: Vec<Caught>,
    /// Pixels where glass shows emission in some samples, so that black ones may have missed it; empty for none.
    pub uncertain: Vec<bool>,
}

/// The shadow catchers of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Caught {
    /// What is behind them, without shadow, times their coverage. It is in neither kind of light.
    pub behind: Rgb,
    /// The fraction of the light that arrives at them, 0 to 1; in the pixels around unless `is_whole`.
    pub lit: f32,
    /// The variance of `lit`.
    pub variance: f32,
    /// Whether they cover the whole pixel.
    pub is_whole: bool,
}

/// A denoiser that is not Turner's, such as a library of another program. [`Denoise::Oidn`](crate::film::Denoise::Oidn) uses
/// it.
pub trait Denoiser: Send + Sync {
    /// Its name and version.
    fn name(&self) -> String;

    /// Returns the radiance of each pixel without noise, row by row; all values are finite. `threads` of 0 uses all.
    ///
    /// Errors: the reason in words. The picture keeps its noise then.
    fn denoise(&self, buffers: &Buffers, threads: usize) -> Result<Vec<Rgb>, String>;
}

/// How a denoiser works. Threads and instruction set do not change a bit.
#[derive(Clone, Copy, Debug)]
pub struct DenoiseOptions<'a> {
    /// 0 uses all.
    pub threads: usize,
    /// The widest instructions that may be used.
    pub set: InstructionSet,
    /// Once it is set, the denoiser returns nothing within milliseconds.
    pub cancel: Option<&'a AtomicBool>,
}

impl DenoiseOptions<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }

    /// `None` once the work is cancelled.
    fn go_on(&self) -> Option<()> {
        (!self.is_cancelled()).then_some(())
    }
}

/// The picture with less noise, in a tenth of the time: radiance of each pixel. `None` if it was cancelled. See
/// [`denoise`].
pub fn denoise_fast(buffers: &Buffers, options: &DenoiseOptions<'_>) -> Option<Vec<Rgb>> {
    fast::denoised(buffers, options)
}

/// The picture without noise: radiance of each pixel. `None` if it was cancelled.
pub fn denoise(buffers: &Buffers, options: &DenoiseOptions<'_>) -> Option<Vec<Rgb>> {
    let guides = guides::filtered(buffers, options.threads);
    let mut out = vec![[0.0; 3]; buffers.width * buffers.height];
    for (part, is_seen) in [(&buffers.emission, true), (&buffers.reflected, false)] {
        let clean = clean(buffers, part, &guides, is_seen, options)?;
        for (to, clean) in out.iter_mut().zip(clean) {
            to.iter_mut().zip(clean).for_each(|(to, v)| *to += v);
        }
    }
    if !buffers.caught.is_empty() {
        let light = Light::of_caught(buffers, options.threads);
        let lit = tile::fitted(&light, &guides, options)?;
        buffers.add_caught(&lit, &mut out);
    }
    Some(out)
}

/// A part of the picture's light without noise, such as that of a light group: radiance of each pixel. Its noise relative
/// to its light is taken to be that of the picture. `is_seen`: it is emission that is seen. `None` if it was cancelled.
pub fn denoise_part(
    buffers: &Buffers,
    values: &[Rgb],
    is_seen: bool,
    options: &DenoiseOptions<'_>,
) -> Option<Vec<Rgb>> {
    let (emission, reflected) = (&buffers.emission, &buffers.reflected);
    let variance = |(i, value): (usize, &Rgb)| {
        let all = luminance(&emission.mean[i]) + luminance(&reflected.mean[i]);
        let of_all = emission.variance[i] + reflected.variance[i];
        let share = if all > 0.0 { (luminance(value) / all).clamp(0.0, 1.0) } else { 1.0 };
        of_all * share * share
    };
    let part = Part { mean: values.to_vec(), variance: values.iter().enumerate().map(variance).collect() };
    let guides = guides::filtered(buffers, options.threads);
    clean(buffers, &part, &guides, is_seen, options)
}

/// A kind of light without noise.
fn clean(
    buffers: &Buffers,
    part: &Part,
    guides: &[[f32; GUIDES]],
    is_seen: bool,
    options: &DenoiseOptions<'_>,
) -> Option<Vec<Rgb>> {
    options.go_on()?;
    let light = Light::new(buffers, part, guides, is_seen, options.threads);
    let fitted = tile::fitted(&light, guides, options)?;
    let factors = light.factors(guides);
    Some(strips::map(fitted.len(), options.threads, |i| {
        let (new, factor) = (light.fitted(i, fitted[i]), factors(i));
        std::array::from_fn(|c| new[c] * factor[c])
    }))
}

impl Buffers {
    /// The picture with its noise: radiance of each pixel.
    pub fn colors(&self, threads: usize) -> Vec<Rgb> {
        strips::map(self.width * self.height, threads, |i| {
            let caught = self.caught.get(i).map_or([0.0; 3], |caught| caught.behind.map(|v| v * caught.lit));
            std::array::from_fn(|c| self.emission.mean[i][c] + self.reflected.mean[i][c] + caught[c])
        })
    }

    /// Adds what is behind shadow catchers. `lit`: the fraction of the light that arrives at them, without noise. Pixels that
    /// show other objects, too, get that of the pixels around.
    fn add_caught(&self, lit: &[Option<Rgb>], out: &mut [Rgb]) {
        let clean = |i: usize| lit[i].map_or(self.caught[i].lit, |lit| lit[0].clamp(0.0, 1.0));
        for (i, caught) in self.caught.iter().enumerate().filter(|(_, caught)| caught.behind != [0.0; 3]) {
            let near = |radius: usize| {
                let (mut sum, mut count) = (0.0, 0.0);
                for j in around(self.width, self.height, i, radius).filter(|j| self.caught[*j].is_whole) {
                    sum += clean(j);
                    count += 1.0;
                }
                (count > 0.0).then(|| sum / count)
            };
            let lit = match caught.is_whole {
                true => clean(i),
                false => near(1).or_else(|| near(2)).unwrap_or(caught.lit),
            };
            out[i].iter_mut().zip(caught.behind).for_each(|(to, v)| *to += v * lit);
        }
    }
}

/// The mean over a square of `2 · radius + 1` pixels, as far as it lies in the picture.
fn box_mean(
    width: usize,
    height: usize,
    radius: usize,
    threads: usize,
    of: impl Fn(usize) -> f32 + Sync,
) -> Vec<f32> {
    let along = strips::rows(width, height, threads, |y, row: &mut [f32]| {
        let values: Vec<f32> = (0..width).map(|x| of(y * width + x)).collect();
        for (x, mean) in row.iter_mut().enumerate() {
            let near = &values[x.saturating_sub(radius)..(x + radius + 1).min(width)];
            *mean = near.iter().sum::<f32>() / near.len() as f32;
        }
    });
    strips::rows(width, height, threads, |y, row: &mut [f32]| {
        let near = y.saturating_sub(radius)..(y + radius + 1).min(height);
        let scale = 1.0 / near.len() as f32;
        for line in near {
            row.iter_mut().zip(&along[line * width..(line + 1) * width]).for_each(|(sum, v)| *sum += v);
        }
        row.iter_mut().for_each(|v| *v *= scale);
    })
}

/// The indices of the pixels within `radius` of a pixel, itself included.
pub(crate) fn around(width: usize, height: usize, i: usize, radius: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (i % width, i / width);
    let columns = x.saturating_sub(radius)..(x + radius + 1).min(width);
    (y.saturating_sub(radius)..(y + radius + 1).min(height))
        .flat_map(move |y| columns.clone().map(move |x| y * width + x))
}
