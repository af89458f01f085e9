//! The error that is left after denoising, estimated without a reference.
//!
//! Let y be the noisy picture and D(y) its denoised one. If D(y) were the converged picture, y − D(y) would be the noise.
//! So the same kind of noise is added to D(y), and D is asked to remove it. How far it fails is known, because D(y) is:
//!
//! ```text
//!   noise'(pixel) = (y − D(y)) at a pixel near it, scaled by the ratio of their standard errors
//!   c = D(D(y) + noise') − D(y)
//!   error left = √2 · the relative |c| that 95 % of the pixels do not exceed
//! ```
//!
//! This is the bootstrap with residuals (Efron and Tibshirani 1993, "An Introduction to the Bootstrap", chapter 9). It
//! accounts for noise that is skewed, correlated between pixels, or smaller than that of independent samples. Detail that D
//! has smoothed away is missing from D(y), so that c is nearly the noise that is left alone. A denoiser that smooths as much as
//! pays has as much error by smoothing as by noise: hence √2. Light that no sample has found is not counted at all.
//!
//! The picture is denoised again in squares that are spread over it.

use super::{Buffers, Rgb, box_mean, luminance};

/// Side of a square in which the picture is denoised again.
const SIDE: usize = 112;

/// The border of a square that is not used: the reach of the denoiser.
const BORDER: usize = 16;

/// The fraction of the picture that is denoised again, unless that is less than the least number of squares.
const FRACTION: f64 = 0.1;

/// The least number of squares.
const LEAST_SQUARES: usize = 6;

/// Noise comes from the pixel as many columns and rows away: a multiple of the cells in which pixels share paths.
const AWAY: usize = 8;

/// The most by which noise is scaled up.
const MOST: f32 = 4.0;

/// Radius of the square over which variances are averaged.
const SMOOTH: usize = 3;

/// The least luminance that counts, as a fraction of the mean.
const DARK: f32 = 0.01;

/// The fraction of pixels that are as accurate.
const CONFIDENCE: f64 = 0.95;

/// The error with what smoothing hides, relative to that without.
const HIDDEN: f64 = std::f64::consts::SQRT_2;

/// The error that is left in `clean`, the picture that `denoise` makes of these buffers: the relative error of luminance that
/// 95 % of the pixels do not exceed. `None` if `denoise` fails.
pub fn left(
    buffers: &Buffers,
    clean: &[Rgb],
    threads: usize,
    denoise: &dyn Fn(&Buffers) -> Option<Vec<Rgb>>,
) -> Option<f64> {
    let noisy = buffers.colors(threads);
    let mean = clean.iter().map(|v| luminance(v).abs()).sum::<f32>() / clean.len().max(1) as f32;
    let least = (DARK * mean).max(f32::MIN_POSITIVE);
    let mut all = Vec::new();
    for [x, y] in squares(buffers.width, buffers.height) {
        let square = Square::new(buffers, x, y);
        let again = denoise(&square.buffers(&noisy, clean, threads))?;
        all.extend(square.inner().map(|j| {
            let own = luminance(&clean[square.index(j)]);
            (luminance(&again[j]) - own).abs() / own.abs().max(least)
        }));
    }
    let last = all.len().checked_sub(1)?;
    let (_, found, _) = all.select_nth_unstable_by((CONFIDENCE * last as f64) as usize, f32::total_cmp);
    Some(HIDDEN * f64::from(*found))
}

/// The corners of squares, spread over the picture.
fn squares(width: usize, height: usize) -> Vec<[usize; 2]> {
    let pixels = (width * height) as f64;
    let count = (FRACTION * pixels / (SIDE * SIDE) as f64) as usize;
    let count = count.max(LEAST_SQUARES) as f64;
    let aspect = width as f64 / height as f64;
    let columns = ((count * aspect).sqrt().round() as usize).clamp(1, width.div_ceil(SIDE));
    let rows = ((count / columns as f64).round() as usize).clamp(1, height.div_ceil(SIDE));
    let place = |k: usize, of: usize, size: usize| {
        let middle = (2 * k + 1) * size / (2 * of);
        middle.saturating_sub(SIDE / 2).min(size.saturating_sub(SIDE))
    };
    (0..rows)
        .flat_map(|row| {
            (0..columns).map(move |column| [place(column, columns, width), place(row, rows, height)])
        })
        .collect()
}

/// A part of the picture that is denoised alone.
struct Square<'a> {
    whole: &'a Buffers,
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

impl Square<'_> {
    fn new(whole: &Buffers, x: usize, y: usize) -> Square<'_> {
        let (width, height) = (SIDE.min(whole.width - x), SIDE.min(whole.height - y));
        Square { whole, x, y, width, height }
    }

    /// The index of a pixel in the whole picture.
    fn index(&self, j: usize) -> usize {
        (self.y + j / self.width) * self.whole.width + self.x + j % self.width
    }

    /// The pixels far enough from the border, unless that is the border of the picture.
    fn inner(&self) -> impl Iterator<Item = usize> {
        let (width, whole) = (self.width, self.whole.width);
        let along = |at: usize, size: usize, all: usize| {
            let first = if at == 0 { 0 } else { BORDER };
            let last = if at + size == all { size } else { size - BORDER };
            first..last.max(first)
        };
        let (left, top) = (self.x, self.y);
        let columns = along(left, width, whole);
        along(top, self.height, self.whole.height)
            .flat_map(move |y| columns.clone().map(move |x| y * width + x))
    }

    /// Its buffers, with other noise on the clean picture.
    fn buffers(&self, noisy: &[Rgb], clean: &[Rgb], threads: usize) -> Buffers {
        let whole = self.whole;
        let indices: Vec<usize> = (0..self.width * self.height).map(|j| self.index(j)).collect();
        fn taken<T: Clone>(of: &[T], indices: &[usize]) -> Vec<T> {
            if of.is_empty() { Vec::new() } else { indices.iter().map(|i| of[*i].clone()).collect() }
        }
        let part = |part: &super::Part| super::Part {
            mean: taken(&part.mean, &indices),
            variance: taken(&part.variance, &indices),
        };
        let mut out = Buffers {
            width: self.width,
            height: self.height,
            emission: part(&whole.emission),
            reflected: part(&whole.reflected),
            guides: taken(&whole.guides, &indices),
            guide_variances: taken(&whole.guide_variances, &indices),
            caught: taken(&whole.caught, &indices),
            uncertain: taken(&whole.uncertain, &indices),
        };
        let behind =
            |i: usize| whole.caught.get(i).filter(|c| c.is_whole).map_or(0.0, |c| luminance(&c.behind));
        let spread = |i: usize| {
            let caught = whole.caught.get(i).map_or(0.0, |caught| caught.variance);
            whole.emission.variance[i] + whole.reflected.variance[i] + behind(i) * behind(i) * caught
        };
        let spreads = box_mean(self.width, self.height, SMOOTH, threads, |j| spread(indices[j]).max(0.0));
        // Of the pixels to the left, right, above and below, that with the most similar noise.
        let donor = |j: usize| {
            let (x, y) = (j % self.width, j / self.width);
            let left = x.checked_sub(AWAY).map(|x| [x, y]);
            let up = y.checked_sub(AWAY).map(|y| [x, y]);
            let right = (x + AWAY < self.width).then_some([x + AWAY, y]);
            let down = (y + AWAY < self.height).then_some([x, y + AWAY]);
            let places = [right, down, left, up].into_iter().flatten().map(|[x, y]| y * self.width + x);
            let unlike = |k: usize| {
                let (a, b) = (spreads[j].max(f32::MIN_POSITIVE), spreads[k].max(f32::MIN_POSITIVE));
                (a / b).max(b / a)
            };
            places.min_by(|a, b| unlike(*a).total_cmp(&unlike(*b))).unwrap_or(j)
        };
        for (j, i) in indices.iter().copied().enumerate() {
            let from = donor(j);
            let by = (spreads[j] / spreads[from].max(f32::MIN_POSITIVE)).sqrt().min(MOST);
            let from = indices[from];
            let new: Rgb = std::array::from_fn(|c| clean[i][c] + by * (noisy[from][c] - clean[from][c]));
            if behind(i) > 0.0 {
                out.caught[j].lit = (luminance(&new) / behind(i)).clamp(0.0, 1.0);
                continue;
            }
            // The noise is that of the kind of light that has most of it.
            let more: Rgb = std::array::from_fn(|c| new[c] - noisy[i][c]);
            let is_seen = whole.emission.variance[i] > whole.reflected.variance[i];
            let part = if is_seen { &mut out.emission } else { &mut out.reflected };
            part.mean[j].iter_mut().zip(more).for_each(|(v, more)| *v += more);
            part.variance[j] = by * by * spread(from).max(0.0);
        }
        out
    }
}
