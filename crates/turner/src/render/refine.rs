//! More camera rays for the denoiser: where the edges of lamps and objects are noisy.
//!
//! A pixel at the edge of a lamp shows the fraction of its few samples that met the lamp, and no neighbour tells a denoiser
//! the true fraction. Camera rays are cheap: they need no light. So pixels whose emission or guides are noisy get up to
//! [`MOST`] more, each followed over glass and mirrors to the surface that guides the denoiser:
//!
//! ```text
//!   emission noisy, here or beside ──► 64, 32, …, 4 rays for each, as many as the picture's share allows
//!   guides noisy                   ──► what is left of the share
//!   mean of n samples, mean of m rays ──► (n · mean + m · mean of rays) / (n + m), and its variance
//! ```
//!
//! The rays are those of sample indices that no film holds, so the result depends on the film alone. The picture's
//! colours and its raw layer stay as they are.

use super::Renderer;
use crate::denoise::{Buffers, Rgb, around, luminance};
use crate::film::{Developed, strips};
use crate::integrator::{CameraSamples, CaughtLight, DenoisingSample, Radiance, RayStats};
use crate::sampler::SampleId;
use crate::view::{place, take_points};

/// The first sample index of these rays. It is a multiple of [`MOST`], so that they are evenly distributed.
const FIRST: u32 = 1 << 30;

/// The most rays of a pixel.
const MOST: u32 = 64;

/// Fewer rays than this change too little.
const LEAST: u32 = 4;

/// The most rays of other pixels than those at the edges of lamps.
const MOST_WEAK: u32 = 16;

/// Rays for each pixel of the picture, at most.
const SHARE: u64 = 2;

/// Samples of a pixel are left out if it has this many times as many rays.
const OUTNUMBER: f32 = 4.0;

/// Pixels whose rays are traced together: as many rays as a tile has pixels.
const BATCH: usize = 4096;

/// A standard error of emission relative to its luminance: more than this is at the edge of a lamp, and beside one.
const STRONG: f32 = 0.1;

/// Emission that differs as much as this from that of a neighbour, relative to the brighter of them, is at an edge.
const CONTRAST: f32 = 0.5;

/// Emission with a smaller standard error than this part of its luminance is without noise.
const EMISSION_NOISE: f32 = 0.01;

/// Emission darker than this part of the mean counts as this bright.
const DARK: f32 = 0.01;

/// Guides with a smaller variance are without noise.
const GUIDE_NOISE: f32 = 1e-4;

/// The rays of a pixel.
#[derive(Clone, Copy, Default)]
struct Rays {
    pixel: u32,
    count: u32,
}

/// Means over the rays of a pixel.
#[derive(Clone, Copy, Default)]
struct Means {
    count: f32,
    emission: Rgb,
    /// Of the squared luminance.
    emission_square: f32,
    guides: [f32; 7],
    /// Of the squares of albedo, normal and distance, each summed over its components.
    guide_squares: [f32; 3],
    /// The fraction that met a shadow catcher, and what is behind it.
    caught: f32,
    behind: Rgb,
    /// Whether another surface was met behind a shadow catcher: its light is not known.
    is_unclear: bool,
}

impl Means {
    fn add(&mut self, sample: &DenoisingSample, caught: Option<&CaughtLight>, clamp: impl Fn(&DenoisingSample) -> f32) {
        let light = sample.emission * clamp(sample);
        self.count += 1.0;
        if caught.is_some_and(|caught| caught.is_caught) {
            self.caught += 1.0;
            add(&mut self.behind, &light.to_array());
            self.is_unclear |= sample.is_hit;
        } else {
            add(&mut self.emission, &light.to_array());
        }
        self.emission_square += light.luminance() * light.luminance();
        let [r, g, b] = sample.albedo.to_array();
        let [x, y, z] = sample.normal;
        let distance = sample.log_distance;
        add(&mut self.guides, &[r, g, b, x, y, z, distance]);
        add(&mut self.guide_squares, &[r * r + g * g + b * b, x * x + y * y + z * z, distance * distance]);
    }

    fn scaled(mut self) -> Means {
        let by = 1.0 / self.count.max(1.0);
        for v in self.emission.iter_mut().chain(&mut self.behind).chain(&mut self.guides) {
            *v *= by;
        }
        self.guide_squares.iter_mut().for_each(|v| *v *= by);
        (self.emission_square, self.caught) = (self.emission_square * by, self.caught * by);
        self
    }
}

fn add<const N: usize>(sum: &mut [f32; N], values: &[f32; N]) {
    sum.iter_mut().zip(values).for_each(|(sum, v)| *sum += if v.is_finite() { *v } else { 0.0 });
}

impl Renderer {
    /// What a denoiser needs, like [`Renderer::denoising_buffers`], with more camera rays where emission and guides are
    /// noisy: at the edges of lamps and objects, out of focus, behind glass. It takes about as long as a sample of each
    /// pixel without its light.
    pub fn refined_buffers(&self, picture: &Developed<'_>, threads: usize) -> Option<Buffers> {
        let mut buffers = self.denoising_buffers(picture, threads)?;
        let film = &self.prepared.view.film;
        if film.weights_samples() || buffers.width == 0 {
            return Some(buffers);
        }
        self.prepared.choose();
        let rays = chosen(&buffers, threads);
        let means = self.guide_means(&rays, threads);
        for (Rays { pixel, .. }, means) in rays.iter().zip(means) {
            let (x, y) = self.position(*pixel);
            let count = self.film.count_and_splats(x, y).map_or(0.0, |(count, _)| count as f32);
            if means.count > 0.0 && count > 0.0 {
                buffers.take_rays(*pixel as usize, count, &means);
            }
        }
        Some(buffers)
    }

    /// The position of a pixel of the crop in the picture.
    fn position(&self, pixel: u32) -> (u32, u32) {
        let crop = self.film.crop;
        (crop.x + pixel % crop.width, crop.y + pixel / crop.width)
    }

    /// Traces rays; without any mean where the integrator knows no guides.
    fn guide_means(&self, rays: &[Rays], threads: usize) -> Vec<Means> {
        let p = &self.prepared;
        let film = &p.view.film;
        let mut starts = vec![0];
        let mut sum = 0;
        for (i, rays) in rays.iter().enumerate() {
            sum += rays.count as usize;
            if sum >= BATCH {
                starts.push(i + 1);
                sum = 0;
            }
        }
        starts.push(rays.len());
        let batches: Vec<&[Rays]> = starts.windows(2).map(|ends| &rays[ends[0]..ends[1]]).collect();
        let filter = film.placement();
        let state = || {
            let tracer = p.integrator.guide_tracer(&p.scene, &p.view);
            (tracer, CameraSamples::default(), Vec::<Radiance>::new(), RayStats::default())
        };
        let means = strips::with(batches.len(), threads, state, |(tracer, samples, radiance, stats), batch| {
            let Some(tracer) = tracer else { return vec![Means::default(); batches[batch].len()] };
            samples.clear();
            let points = batches[batch].iter().flat_map(|rays| {
                let (x, y) = self.position(rays.pixel);
                let seed = u64::from(film.seed);
                (FIRST..FIRST + rays.count).map(move |index| SampleId { x, y, index, seed })
            });
            take_points(&p.view, samples, points.map(|id| (id, place(&p.view, &filter, &id))));
            tracer.radiance(samples, radiance, stats);
            let details = tracer.details();
            let mut next = 0;
            let of_pixel = |rays: &Rays| {
                let mut means = Means::default();
                for i in next..next + rays.count as usize {
                    let is_ray = samples.rays.get(i).is_some_and(|ray| ray.t_max >= 0.0);
                    let none = DenoisingSample::default();
                    let sample = details.denoising.get(i).filter(|_| is_ray).unwrap_or(&none);
                    means.add(sample, details.caught.get(i), |s| film.clamp_factor(s.emission));
                }
                next += rays.count as usize;
                means.scaled()
            };
            batches[batch].iter().map(of_pixel).collect()
        });
        means.into_iter().flatten().collect()
    }
}

/// The pixels that get more rays: first those at the edges of lamps, then those whose emission has some noise, then those
/// whose guides have.
fn chosen(buffers: &Buffers, threads: usize) -> Vec<Rays> {
    let (width, height) = (buffers.width, buffers.height);
    let count = width * height;
    let light = strips::map(count, threads, |i| luminance(&buffers.emission.mean[i]));
    let mean = light.iter().sum::<f32>() / count.max(1) as f32;
    let least = DARK * mean;
    let noise = |i: usize| buffers.emission.variance[i].max(0.0).sqrt() / light[i].max(least).max(f32::MIN_POSITIVE);
    let kinds = strips::map(count, threads, |i| {
        let (mut low, mut high, mut most) = (light[i], light[i], 0.0f32);
        for j in around(width, height, i, 1) {
            (low, high, most) = (low.min(light[j]), high.max(light[j]), most.max(noise(j)));
        }
        match () {
            _ if most > STRONG || high - low > CONTRAST * high && high > least => 1u8,
            _ if noise(i) > EMISSION_NOISE => 2,
            _ if buffers.guide_variances[i].iter().any(|v| *v > GUIDE_NOISE) => 3,
            _ => 0,
        }
    });
    let mut left = std::env::var("SHARE").ok().and_then(|v| v.parse().ok()).unwrap_or(SHARE) * count as u64;
    let mut rays = [0; 4];
    for (kind, most) in [(1, MOST), (2, MOST_WEAK), (3, MOST_WEAK)] {
        let pixels = kinds.iter().filter(|k| usize::from(**k) == kind).count() as u64;
        let affordable = left / pixels.max(1);
        rays[kind] = if affordable < u64::from(LEAST) { 0 } else { most.min(1 << affordable.ilog2()) };
        left -= pixels * u64::from(rays[kind]);
        eprintln!("kind {kind}: {pixels} pixels ({:.3}), {} rays", pixels as f64 / count as f64, rays[kind]);
    }
    let each = kinds.iter().enumerate().map(|(i, kind)| Rays { pixel: i as u32, count: rays[usize::from(*kind)] });
    each.filter(|rays| rays.count > 0).collect()
}

impl Buffers {
    /// Adds the means of rays to those of `n` samples of a pixel.
    fn take_rays(&mut self, i: usize, n: f32, rays: &Means) {
        let m = rays.count;
        // The pixel was chosen for what its samples show, so they are left out where rays outnumber them.
        let n = if m >= OUTNUMBER * n { 0.0 } else { n };
        let mixed = |own: f32, more: f32| (n * own + m * more) / (n + m);
        // E(v²) of both, then the variance of the mean.
        let spread = |variance: f32, before: f32, more: f32, after: f32| {
            let square = mixed(variance * (n - 1.0).max(0.0) + before, more);
            (square - after).max(0.0) / (n + m - 1.0)
        };
        let square = |v: &[f32]| v.iter().map(|v| v * v).sum::<f32>();
        let before = self.guides[i];
        let guides: [f32; 7] = std::array::from_fn(|k| mixed(before[k], rays.guides[k]));
        for (k, range) in [0..3, 3..6, 6..7].into_iter().enumerate() {
            let (own, new) = (square(&before[range.clone()]), square(&guides[range]));
            self.guide_variances[i][k] = spread(self.guide_variances[i][k], own, rays.guide_squares[k], new);
        }
        self.guides[i] = guides;
        let caught = self.caught.get(i).copied().unwrap_or_default();
        if caught.is_whole || rays.is_unclear {
            return;
        }
        let own = self.emission.mean[i];
        let own_light = luminance(&own) + luminance(&caught.behind);
        let emission: Rgb = std::array::from_fn(|c| mixed(own[c], rays.emission[c]));
        let behind: Rgb = std::array::from_fn(|c| mixed(caught.behind[c], rays.behind[c]));
        let light = luminance(&emission) + luminance(&behind);
        self.emission.variance[i] =
            spread(self.emission.variance[i], own_light * own_light, rays.emission_square, light * light);
        self.emission.mean[i] = emission;
        if let Some(caught) = self.caught.get_mut(i) {
            caught.behind = behind;
        }
    }
}
