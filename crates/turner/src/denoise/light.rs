//! One kind of light, ready to be fitted: divided by the albedo, without single bright samples, with a smooth variance.

use super::{Buffers, Part, Rgb, around, box_mean};
use crate::film::strips;

/// Added to the albedo that light is divided by, so that black surfaces do not amplify their noise.
const LEAST_ALBEDO: f32 = 0.05;

/// A pixel's standard error, relative to its luminance, from which on single samples may dominate it.
pub(super) const DOMINATED: f32 = 0.1;

/// The same for emission that is seen, where the edges of lamps have noise, too.
const DOMINATED_EMISSION: f32 = 0.4;

/// Neighbours within two pixels that may be as bright as such a pixel.
const AS_BRIGHT: usize = 6;

/// Standard deviations over its other neighbours that such a pixel may keep.
const KEPT: f32 = 8.0;

/// Radius of the wider square around a bright pixel.
const WIDE: usize = 5;

/// How much brighter than the mean of its other pixels a pixel may be.
const BRIGHTER: f32 = 3.0;

/// The same for emission. It is less, because small lamps raise the mean of the square around them.
const BRIGHTER_EMISSION: f32 = 0.5;

/// A pixel is no spike if this many pixels of the square are as bright. This does not hold for emission.
const WITNESSES: usize = 5;

/// The most that the emission of a pixel is multiplied by.
const GROWTH: f32 = 1.5;

/// Emission with a smaller standard error than this part of its luminance is without noise.
const LEAST_NOISE: f32 = 0.01;

/// For its variance, a black pixel counts as bright as at least this fraction of the mean of the square.
const BLACK: f32 = 0.3;

/// Radius of the square over which variances are averaged.
const SMOOTH: usize = 3;

/// Light of each pixel, to be fitted.
pub(super) struct Light {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Radiance over albedo.
    pub(super) values: Vec<Rgb>,
    /// Variance of the luminance of `values`, smoothed; 0 where there is no noise.
    pub(super) variance: Vec<f32>,
    divides: bool,
    /// The pixels that have this light; empty for all.
    known: Vec<bool>,
    /// Emission may become as bright as this, whatever it was; empty for nowhere.
    growth: Vec<f32>,
}

pub(crate) fn luminance(v: &Rgb) -> f32 {
    0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2]
}

fn factor(guide: &[f32; super::GUIDES]) -> Rgb {
    std::array::from_fn(|c| guide[c].clamp(0.0, 1.0) + LEAST_ALBEDO)
}

impl Light {
    /// `is_seen`: the light is that of emitters that are seen, which surfaces do not reflect.
    pub(super) fn new(
        buffers: &Buffers,
        part: &Part,
        guides: &[[f32; super::GUIDES]],
        is_seen: bool,
        threads: usize,
    ) -> Light {
        let (width, height) = (buffers.width, buffers.height);
        let count = width * height;
        let raw = over_albedo(part, guides, is_seen, threads);
        let bright: Vec<f32> = raw.iter().map(|(value, _)| luminance(value)).collect();
        // Lamps are bright pixels without noise. They stay as they are.
        let uncertain = |i: usize| is_seen && buffers.uncertain.get(i).is_some_and(|uncertain| *uncertain);
        let stays =
            |i: usize| is_seen && !has_noise(bright[i], raw[i].1) && !(uncertain(i) && bright[i] <= 0.0);
        let dominated = if is_seen { DOMINATED_EMISSION } else { DOMINATED };
        let around = box_mean(width, height, WIDE, threads, |i| bright[i]);
        let limited = strips::map(count, threads, |i| {
            let (value, variance) = raw[i];
            let is_noisy = variance.sqrt() > dominated * bright[i];
            let by = if is_noisy { limit(&bright, [width, height], i, around[i], is_seen) } else { 1.0 };
            (value.map(|v| v * by), variance * by * by)
        });
        let mut variance = smoothed(&limited, [width, height], threads);
        variance.iter_mut().enumerate().filter(|(i, _)| stays(*i)).for_each(|(_, v)| *v = 0.0);
        let values = limited.into_iter().map(|(value, _)| value).collect();
        let growth = if is_seen && !buffers.uncertain.is_empty() {
            strips::map(count, threads, |i| if uncertain(i) { BRIGHTER * around[i] } else { 0.0 })
        } else {
            Vec::new()
        };
        Light { width, height, values, variance, divides: !is_seen, known: Vec::new(), growth }
    }

    /// A kind of light with all its noise: neither limited nor smoothed.
    pub(super) fn plain(buffers: &Buffers, part: &Part, is_seen: bool, threads: usize) -> Light {
        let (width, height) = (buffers.width, buffers.height);
        let raw = over_albedo(part, &buffers.guides, is_seen, threads);
        let (values, variance) = raw.into_iter().unzip();
        Light { width, height, values, variance, divides: !is_seen, known: Vec::new(), growth: Vec::new() }
    }

    /// The fraction of the light that arrives at shadow catchers. Other pixels get the mean of the known ones of a patch
    /// around them, so that they do not keep patches from being alike.
    pub(super) fn of_caught(buffers: &Buffers, threads: usize) -> Light {
        let (width, height, caught) = (buffers.width, buffers.height, &buffers.caught);
        let mean = |of: &(dyn Fn(usize) -> f32 + Sync)| {
            box_mean(width, height, SMOOTH, threads, |i| if caught[i].is_whole { of(i) } else { 0.0 })
        };
        let coverage = mean(&|_| 1.0);
        let [lit, variance] = [mean(&|i| caught[i].lit), mean(&|i| caught[i].variance)];
        let light = |i: usize| {
            let scale = if coverage[i] > 0.0 { 1.0 / coverage[i] } else { 0.0 };
            let own = if caught[i].is_whole { caught[i].lit } else { lit[i] * scale };
            // Without a variance, patches around a narrow gap would never be alike.
            ([own; 3], variance[i] * scale)
        };
        let (values, variance) = strips::map(width * height, threads, light).into_iter().unzip();
        let known = caught.iter().map(|caught| caught.is_whole).collect();
        Light { width, height, values, variance, divides: false, known, growth: Vec::new() }
    }

    /// The new light of a pixel: its fit, if it has one. Small lamps and glints are brighter than their fits, and what is
    /// beside them is darker, so emission grows by a limited factor.
    pub(super) fn fitted(&self, i: usize, fit: Option<Rgb>) -> Rgb {
        let own = &self.values[i];
        let Some(fit) = fit.map(|fit| fit.map(|v| v.max(0.0))) else { return *own };
        let more = self.growth.get(i).copied().unwrap_or(0.0);
        let (most, new) = ((GROWTH * luminance(own)).max(more).max(0.0), luminance(&fit));
        if self.divides || new <= most { fit } else { fit.map(|v| v * (most / new)) }
    }

    /// Whether a pixel has this light.
    pub(super) fn is_known(&self, i: usize) -> bool {
        self.known.get(i).is_none_or(|known| *known)
    }

    /// What the values of a pixel are multiplied by to become radiance.
    pub(super) fn factors<'a>(&self, guides: &'a [[f32; super::GUIDES]]) -> impl Fn(usize) -> Rgb + 'a {
        let divides = self.divides;
        move |i| if divides { factor(&guides[i]) } else { [1.0; 3] }
    }
}

/// The light of each pixel, divided by the albedo unless it is emission that is seen, and the variance of its luminance.
fn over_albedo(
    part: &Part,
    guides: &[[f32; super::GUIDES]],
    is_seen: bool,
    threads: usize,
) -> Vec<(Rgb, f32)> {
    strips::map(part.mean.len(), threads, |i| {
        let by = if is_seen { [1.0; 3] } else { factor(&guides[i]) };
        let scale = 1.0 / luminance(&by);
        let value: Rgb = std::array::from_fn(|c| part.mean[i][c] / by[c]);
        (value, part.variance[i] * scale * scale)
    })
}

/// Whether emission of this luminance and variance has noise.
pub(super) fn has_noise(bright: f32, variance: f32) -> bool {
    variance.sqrt() > LEAST_NOISE * bright
}

/// The factor by which a pixel that a single bright sample dominates becomes about as bright as its neighbours. `mean`: of
/// the wider square around it, itself included.
fn limit(bright: &[f32], [width, height]: [usize; 2], i: usize, mean: f32, is_seen: bool) -> f32 {
    const PIXELS: f32 = ((2 * WIDE + 1) * (2 * WIDE + 1)) as f32;
    let own = bright[i];
    let others = (mean * PIXELS - own).max(0.0) / (PIXELS - 1.0);
    let most = if is_seen { BRIGHTER_EMISSION } else { BRIGHTER } * others + 1e-6;
    if own <= most {
        return 1.0;
    }
    let (mut near, mut count) = ([0.0f32; 24], 0);
    for j in around(width, height, i, 2).filter(|j| *j != i) {
        near[count] = bright[j];
        count += 1;
    }
    let near = &mut near[..count];
    if count <= AS_BRIGHT {
        return 1.0;
    }
    let (others, _, _) = near.select_nth_unstable_by(count - AS_BRIGHT, f32::total_cmp);
    // In a fixed order, whatever the selection did.
    others.sort_unstable_by(f32::total_cmp);
    let scale = 1.0 / others.len() as f32;
    let mean = others.iter().sum::<f32>() * scale;
    let spread = others.iter().map(|v| (v - mean) * (v - mean)).sum::<f32>() * scale;
    let mut most = most.max(mean + KEPT * spread.sqrt());
    if own > most && !is_seen {
        // Where few samples find the light, others as bright are near.
        let mut witnesses = [0.0f32; WITNESSES];
        for j in around(width, height, i, WIDE).filter(|j| *j != i) {
            let mut v = bright[j];
            for witness in &mut witnesses {
                if v > *witness {
                    std::mem::swap(witness, &mut v);
                }
            }
        }
        most = most.max(witnesses[WITNESSES - 1]);
    }
    if own > most { most / own } else { 1.0 }
}

/// Variances, averaged over a square; the dark pixels beside bright ones get the relative variance of the square at most.
fn smoothed(light: &[(Rgb, f32)], [width, height]: [usize; 2], threads: usize) -> Vec<f32> {
    let mean = box_mean(width, height, 1, threads, |i| luminance(&light[i].0));
    let wide = box_mean(width, height, SMOOTH, threads, |i| luminance(&light[i].0));
    let square = |i: usize| {
        let mean = mean[i].max(BLACK * wide[i]);
        mean * mean
    };
    let absolute = box_mean(width, height, SMOOTH, threads, |i| light[i].1);
    let relative = box_mean(width, height, SMOOTH, threads, |i| light[i].1 / (square(i) + 1e-12));
    strips::map(width * height, threads, |i| absolute[i].min(square(i) * relative[i]))
}
