//! The error of a picture, estimated from its own samples.
//!
//! The film of a random picture holds five more sums for each pixel, of the luminance l and the weight w of each
//! sample:
//!
//! ```text
//! Σ w²l²   Σ w²l   Σ w²     the spread of the samples: what the error would be if they were independent
//! Σ' wl    Σ' w             the same pixel from about half of the samples: how much better, or worse, they are together
//! ```
//!
//! Σ' runs over the samples whose index has an odd number of binary digits: 1, 4 to 7, 16 to 31, …. These octaves of the
//! sequence are complete digital nets, and so are those between them. The sums do not depend on the order of samples or on the final number of
//! them, so they can be split and merged like the others.
//!
//! 1. For each pixel the spread gives a standard error s, as if samples were independent. Part of it comes from the
//!    neighbouring pixels: few samples may all miss what is rare.
//! 2. d = (mean of one part − mean of the other) · √(W'·W''/W²) has that same standard error if samples are independent,
//!    and a smaller one if they are stratified. In a region of 48 x 48 pixels, |d| / s is distributed nearly like
//!    |error of the picture| / s. So its 95th percentile replaces the 1.96 of a normal distribution: it accounts for
//!    stratification, for rare bright samples, and for shared paths.
//! 3. The whole is slightly more accurate than the difference of its parts suggests, the more the better stratified:
//!    [`whole_from_parts`]. Where neighbouring pixels share paths, their sequences together are better stratified still:
//!    [`SHARED`].
//!
//! Half-width = percentile · factor · s. Light paths that are splatted have an error of their own, from Σ splat².

use std::ops::Range;

use super::{Film, Fixed96, Half, PixelRect, TILE, strips};
use crate::color::Spectrum;

/// Sums per pixel.
pub(super) const ERROR_SUMS: usize = 5;

/// Samples per pixel that an estimate needs.
const LEAST_SAMPLES: u64 = 4;

/// The fraction of pixels that an interval covers.
const CONFIDENCE: f64 = 0.95;

/// The 97.5th percentile of a normal distribution.
const NORMAL: f64 = 1.959_964;

/// About the number of pixels of a strip.
const STRIP_PIXELS: u32 = 1 << 21;

/// The least rows of tiles of a strip: those around it are looked at, too.
const LEAST_TILE_ROWS: u32 = 6;

/// Tiles whose regions a thread looks at in one go.
const TILES_AT_ONCE: usize = 64;

/// Weight of the neighbours in the spread of a pixel's samples. With a filter wider than the pixel neighbours share
/// samples, so that more of them are needed.
const NEIGHBOURS: [f64; 2] = [0.4, 0.7];

/// The same in the spread of its light paths, of which fewer arrive.
const LIGHT_NEIGHBOURS: f64 = 0.5;

/// Whether a sample belongs to the odd octaves.
#[inline]
fn is_in_half(index: u32) -> bool {
    (u32::BITS - index.leading_zeros()) % 2 == 1
}

/// The error of the whole relative to what the difference of its parts suggests, for a percentile of |d| / s. Samples
/// that are independent have 1.96, and 1. The slope is that of ten small scenes, whose true errors were measured from
/// 200 renders each: factors of 0.90 to 0.95 for percentiles of 1.3 to 1.6.
fn whole_from_parts(percentile: f64) -> f64 {
    (1.0 - 0.13 * (NORMAL - percentile)).clamp(0.9, 1.0)
}

/// The same, where neighbouring pixels share paths: a pixel's light then is from the paths of a cluster, whose samples
/// together are well distributed when they are complete. Two rooms, one of them Lambertian only, with 8 to 64 samples
/// and three filters have 0.80 to 1.0.
const SHARED: f64 = 0.93;

/// A sample's part of the sums.
pub(super) struct ErrorSample {
    luminance: f64,
    is_in_half: bool,
}

impl ErrorSample {
    #[inline]
    pub(super) fn new(color: Spectrum, index: u32) -> ErrorSample {
        ErrorSample { luminance: f64::from(color.luminance()), is_in_half: is_in_half(index) }
    }

    /// The terms of the sums if the weight of the sample is 1.
    #[inline(always)]
    pub(super) fn terms(&self) -> [f64; ERROR_SUMS] {
        let (l, half) = (self.luminance, if self.is_in_half { 1.0 } else { 0.0 });
        [l * l, l, 1.0, half * l, half]
    }
}

/// How far the pixels of a picture may be from the converged picture.
#[derive(Clone, Debug)]
pub struct ErrorEstimate {
    /// Columns of the crop.
    pub width: u32,
    /// Rows of the crop.
    pub height: u32,
    /// The luminance of each pixel, row by row.
    pub luminance: Vec<f32>,
    /// Half the width of the interval of each pixel's luminance that covers the converged value with a probability of
    /// 95 %.
    pub half_width: Vec<f32>,
}

/// The noise of a picture: the relative half-width that 95 % of its pixels do not exceed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The estimate: half-width over luminance.
    pub value: f64,
    /// The interval of the estimate, 95 %.
    pub interval: [f64; 2],
}

/// A pixel before its region is known.
#[derive(Clone, Copy, Default)]
pub(super) struct Spread {
    pub(super) luminance: f64,
    /// s², of independent samples.
    variance: f64,
    /// d².
    pub(super) difference: f64,
    /// Variance of the light paths.
    splats: f64,
}

impl Film {
    /// The error of each pixel of the crop. `None` if the film holds no estimate, or a tile fewer than four samples.
    ///
    /// Estimates need no reference. They are of the luminance of scene values, and reliable from about 16 samples per
    /// pixel on. `threads` of 0 uses all.
    pub fn error(&self, threads: usize) -> Option<ErrorEstimate> {
        let PixelRect { width, height, .. } = self.crop;
        let mut out = ErrorEstimate { width, height, luminance: Vec::new(), half_width: Vec::new() };
        for rows in self.error_strips()? {
            let strip = self.error_strip(rows, threads);
            if strip.height == height {
                return Some(strip);
            }
            out.luminance.extend(strip.luminance);
            out.half_width.extend(strip.half_width);
        }
        Some(out)
    }

    /// The noise of the picture, like [`ErrorEstimate::noise`]. A large picture is looked at strip by strip, so that no
    /// memory of its size is needed.
    pub fn noise(&self, threads: usize) -> Option<Noise> {
        let strips = self.error_strips()?;
        if let [all] = &strips[..] {
            return Some(self.error_strip(all.clone(), threads).noise());
        }
        let sums = strips.iter().flat_map(|rows| {
            let PixelRect { x, y, width, .. } = self.crop;
            let sums = strips::map(rows.len(), threads, |row| {
                let pixels = (x..x + width).map(|x| self.spread(x, y + rows.start + row as u32));
                pixels.map(|spread| f64::from(spread.luminance as f32).abs()).sum::<f64>()
            });
            sums.into_iter()
        });
        let mut parts = Parts::new(sums.sum::<f64>() / self.crop.area().max(1) as f64);
        for rows in strips {
            parts.add(&self.error_strip(rows.clone(), threads), rows.start);
        }
        Some(parts.noise())
    }

    /// The rows of the crop in strips of whole tiles; `None` if there is no estimate.
    fn error_strips(&self) -> Option<Vec<Range<u32>>> {
        let grid = self.tiles();
        let least = |tile| Half::BOTH.map(|half| self.held_half(tile, half).len()).into_iter().min();
        let fewest = (0..grid.count()).filter_map(least).min().unwrap_or(0);
        if !self.identity.estimates_error || fewest < LEAST_SAMPLES {
            return None;
        }
        let PixelRect { width, height, .. } = self.crop;
        let rows = (STRIP_PIXELS / width.max(1) / TILE).max(LEAST_TILE_ROWS) * TILE;
        Some((0..height).step_by(rows as usize).map(|y| y..(y + rows).min(height)).collect())
    }

    /// The error of the pixels of these rows of the crop, which begin with a row of tiles.
    pub(crate) fn error_strip(&self, rows: Range<u32>, threads: usize) -> ErrorEstimate {
        let PixelRect { width, height, .. } = self.crop;
        // The tiles above and below, and the neighbours of their pixels.
        let top = rows.start.saturating_sub(TILE + 1);
        let bottom = (rows.end + TILE + 1).min(height);
        let count = ((bottom - top) * width) as usize;
        let spreads = strips::map(count, threads, |i| {
            let (x, y) = (i as u32 % width, i as u32 / width);
            self.spread(self.crop.x + x, self.crop.y + top + y)
        });
        let shared = if self.identity.cluster > 1 { SHARED } else { 1.0 };
        let neighbours = NEIGHBOURS[usize::from(self.identity.weighted)];
        let smooth = smoothed(&spreads, width as usize, neighbours, threads, |s| s.variance);
        let light = match self.splats {
            Some(_) => smoothed(&spreads, width as usize, LIGHT_NEIGHBOURS, threads, |s| s.splats),
            None => Vec::new(),
        };
        let standardized =
            strips::map(count, threads, |i| ratio(spreads[i].difference, smooth[i]).sqrt() as f32);
        let columns = width.div_ceil(TILE);
        let tiles = (columns * (rows.len() as u32).div_ceil(TILE)) as usize;
        let first_tile = rows.start / TILE;
        let regions = strips::filled(tiles, TILES_AT_ONCE, threads, |first, strip: &mut [f64]| {
            let mut pixels = Vec::new();
            for (tile, factor) in (first as u32..).zip(strip) {
                let place = [tile % columns, first_tile + tile / columns];
                pixels.clear();
                let around = region_pixels([width, height], top, place).map(|i| standardized[i]);
                pixels.extend(around.filter(|t| *t > 0.0));
                *factor = shared * factor_of(&mut pixels);
            }
        });
        let skipped = ((rows.start - top) * width) as usize;
        let own = rows.len() * width as usize;
        let half_width = strips::map(own, threads, |i| {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let factor = regions[(y / TILE * columns + x / TILE) as usize];
            let i = skipped + i;
            let light = light.get(i).map_or(0.0, |light| NORMAL * NORMAL * light);
            (factor * factor * smooth[i] + light).sqrt() as f32
        });
        let luminance = spreads[skipped..skipped + own].iter().map(|s| s.luminance as f32).collect();
        ErrorEstimate { width, height: rows.len() as u32, half_width, luminance }
    }

    /// The variance of the luminance of a pixel of the region, as if its samples were independent: the spread of their
    /// luminance over their number, and that of its light paths. 0 without at least two samples, or if the film holds no
    /// estimate of its error. Samples of Turner are stratified, so the true variance is lower; [`Film::error`] accounts
    /// for that.
    pub fn variance(&self, x: u32, y: u32) -> f32 {
        if !self.identity.estimates_error {
            return 0.0;
        }
        let spread = self.spread(x, y);
        (spread.variance + spread.splats) as f32
    }

    /// The number of samples of equal weight that would count as much as those of a pixel of the region, and the variance
    /// of the luminance of its light paths. `None` if the film holds no estimate of its error.
    pub(crate) fn count_and_splats(&self, x: u32, y: u32) -> Option<(f64, f64)> {
        let (band, i) = self.place(x, y).filter(|_| self.identity.estimates_error)?;
        let total = band.sum(i).weight();
        let [_, _, weights, _, _] = band.extra(i).last_chunk::<ERROR_SUMS>()?;
        let weights = Fixed96::from_words(*weights).mean(1.0);
        let splats = self.splats.as_ref().map_or(0.0, |s| s.luminance_and_variance(x, y).1);
        Some((total * total / weights.max(f64::MIN_POSITIVE), splats))
    }

    /// The sums of the error estimate of a pixel.
    pub(super) fn spread(&self, x: u32, y: u32) -> Spread {
        let Some((band, i)) = self.place(x, y) else { return Spread::default() };
        let (sum, extra) = (band.sum(i), band.extra(i));
        let total = sum.weight();
        let Some([square, linear, weights, half, half_weights]) = extra.last_chunk() else {
            return Spread::default();
        };
        let [square, linear, weights, half, half_weights] =
            [square, linear, weights, half, half_weights].map(|words| Fixed96::from_words(*words).mean(1.0));
        let Some([r, g, b, _]) = sum.mean().filter(|_| total > 0.0) else { return Spread::default() };
        let mean = f64::from(Spectrum::new(r, g, b).luminance());
        let (light, splats) = self.splats.as_ref().map_or((0.0, 0.0), |s| s.luminance_and_variance(x, y));
        let residual = (square - 2.0 * mean * linear + mean * mean * weights).max(0.0);
        // The number of samples of equal weight that would count as much.
        let count = total * total / weights.max(f64::MIN_POSITIVE);
        let unbiased = if count > 1.0 { count / (count - 1.0) } else { 1.0 };
        let other = total - half_weights;
        let difference = if half_weights > 0.0 && other > 0.0 {
            let apart = half / half_weights - (mean * total - half) / other;
            apart * apart * half_weights * other / (total * total)
        } else {
            0.0
        };
        Spread {
            luminance: mean + light,
            variance: unbiased * residual / (total * total),
            difference,
            splats,
        }
    }
}

/// `a / b`, and 0 where both vanish.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

/// The least luminance of a pixel as a fraction of a neighbour's, where their variances are mixed.
const DARKEST: f64 = 0.01;

/// A variance of each pixel, mixed with the mean over its 3 x 3 neighbours. Those of pixels that are certainly brighter
/// count relative to their luminance: what is next to a lamp is not as noisy as the lamp's edge.
fn smoothed(
    spreads: &[Spread],
    width: usize,
    neighbours: f64,
    threads: usize,
    of: impl Fn(&Spread) -> f64 + Sync,
) -> Vec<f64> {
    let height = spreads.len() / width.max(1);
    let around = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
    // Lower bounds of the luminance.
    let least =
        strips::map(spreads.len(), threads, |i| spreads[i].luminance.abs() - NORMAL * of(&spreads[i]).sqrt());
    strips::map(spreads.len(), threads, |i| {
        let (x, y) = (i % width, i / width);
        let own = spreads[i].luminance.abs();
        let (mut sum, mut count) = (0.0, 0.0);
        for ny in around(y, height) {
            for nx in around(x, width) {
                let other = ny * width + nx;
                let (variance, bright) = (of(&spreads[other]), least[other]);
                let scale = if bright > own { (own / bright).max(DARKEST) } else { 1.0 };
                sum += scale * scale * variance;
                count += 1.0;
            }
        }
        (1.0 - neighbours) * of(&spreads[i]) + neighbours * sum / count
    })
}

/// The 95th percentile of |d| / s, as a factor of s for the whole.
fn factor_of(pixels: &mut [f32]) -> f64 {
    if pixels.len() < 2 {
        return NORMAL;
    }
    let n = ((pixels.len() - 1) as f64 * CONFIDENCE) as usize;
    let percentile = f64::from(*pixels.select_nth_unstable_by(n, f32::total_cmp).1);
    percentile * whole_from_parts(percentile)
}

/// The pixels of the 3 x 3 tiles around a tile, in a strip that begins with row `top` of the picture.
fn region_pixels(
    [width, height]: [u32; 2],
    top: u32,
    [column, row]: [u32; 2],
) -> impl Iterator<Item = usize> {
    let along = |tile: u32, size: u32| (tile.saturating_sub(1) * TILE)..((tile + 2) * TILE).min(size);
    let columns = along(column, width);
    along(row, height).flat_map(move |y| columns.clone().map(move |x| ((y - top) * width + x) as usize))
}

impl ErrorEstimate {
    /// The relative half-width that 95 % of the pixels do not exceed, with its own interval. Pixels darker than a
    /// hundredth of the mean count as bright as that: nobody sees their noise.
    pub fn noise(&self) -> Noise {
        let mean = self.luminance.iter().map(|l| f64::from(l.abs())).sum::<f64>();
        let mut parts = Parts::new(mean / self.luminance.len().max(1) as f64);
        parts.add(self, 0);
        parts.noise()
    }
}

/// Parts of the picture whose noise is compared.
const PARTS: usize = 8;

/// The least luminance that counts, as a fraction of the mean.
const DARK: f64 = 0.01;

/// Mantissa bits of a relative half-width that are dropped: bins are within a relative error of 2⁻¹².
const DROPPED: u32 = 12;

/// Relative half-widths below and above these powers of two count as these.
const EXPONENTS: [u32; 2] = [127 - 24, 127 + 24];

/// Bins of a part.
const BINS: usize = ((EXPONENTS[1] - EXPONENTS[0]) << (23 - DROPPED)) as usize + 1;

/// The distribution of relative half-widths in each part of a picture.
struct Parts {
    /// The least luminance that counts.
    least: f32,
    /// Numbers of pixels: the bins of each part.
    bins: Vec<u32>,
}

impl Parts {
    /// No pixels; `mean` is the mean luminance of the picture.
    fn new(mean: f64) -> Parts {
        Parts { least: (DARK * mean) as f32, bins: vec![0; PARTS * BINS] }
    }

    /// Adds the pixels of a strip whose first row is `top`.
    fn add(&mut self, strip: &ErrorEstimate, top: u32) {
        let (width, columns) = (strip.width as usize, strip.width.div_ceil(TILE) as usize);
        let rows = strip.half_width.chunks(width).zip(strip.luminance.chunks(width));
        for (y, (half_widths, luminances)) in (top..).zip(rows) {
            for (x, (half, luminance)) in half_widths.iter().zip(luminances).enumerate() {
                let part = ((y / TILE) as usize * columns + x / TILE as usize) % PARTS;
                let relative = if *half > 0.0 { half / luminance.abs().max(self.least) } else { 0.0 };
                self.bins[part * BINS + bin(relative)] += 1;
            }
        }
    }

    fn noise(&self) -> Noise {
        let parts: Vec<&[u32]> = self.bins.chunks(BINS).collect();
        let value = percentile(&parts).unwrap_or(0.0);
        let all: Vec<f64> = parts.iter().filter_map(|part| percentile(&[part])).collect();
        let n = all.len() as f64;
        let mean = all.iter().sum::<f64>() / n.max(1.0);
        let variance = all.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0).max(1.0);
        let half = NORMAL * (variance / n.max(1.0)).sqrt();
        Noise { value, interval: [(value - half).max(0.0), value + half] }
    }
}

/// The bin of a relative half-width.
fn bin(relative: f32) -> usize {
    let [low, high] = EXPONENTS.map(|e| e << 23);
    ((relative.to_bits().clamp(low, high) - low) >> DROPPED) as usize
}

/// The 95th percentile of the pixels in these bins together.
fn percentile(parts: &[&[u32]]) -> Option<f64> {
    let in_bin = |i: usize| parts.iter().map(|bins| u64::from(bins[i])).sum::<u64>();
    let count: u64 = (0..BINS).map(in_bin).sum();
    let (mut below, last) = (0, (CONFIDENCE * count as f64) as u64);
    let found = (0..BINS).find(|i| {
        below += in_bin(*i);
        below > last
    })?;
    // The middle of the bin; the first holds everything below, nearly always zeros.
    let bits = (EXPONENTS[0] << 23) + ((found as u32) << DROPPED) + (1 << (DROPPED - 1));
    Some(if found == 0 { 0.0 } else { f64::from(f32::from_bits(bits)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_octaves() {
        let half: Vec<u32> = (0..20).filter(|i| is_in_half(*i)).collect();
        assert_eq!(half, [1, 4, 5, 6, 7, 16, 17, 18, 19]);
    }

    #[test]
    fn the_noise_is_a_percentile_of_relative_half_widths() {
        let pixels = 64 * 64;
        let estimate = ErrorEstimate {
            width: 64,
            height: 64,
            luminance: vec![2.0; pixels],
            half_width: (0..pixels).map(|i| ((i * 7919) % 100) as f32 / 1000.0).collect(),
        };
        let Noise { value, interval: [low, high] } = estimate.noise();
        assert!((value - 0.0475).abs() < 1e-3, "{value}");
        assert!(low <= value && value <= high && high - low < 0.01, "{low} {high}");
        // Dark pixels do not count more than a hundredth of the mean.
        let dark = ErrorEstimate { luminance: vec![1e-9; pixels], ..estimate };
        assert!(dark.noise().value.is_finite());
    }
}
