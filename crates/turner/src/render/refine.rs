//! More camera rays for the denoiser: where the edges of lamps and objects are noisy.
//!
//! A pixel at the edge of a lamp shows the fraction of its few samples that met the lamp, and no neighbour tells a denoiser
//! the true fraction. Camera rays are cheap: they need no light. So pixels whose emission or guides are noisy get up to
//! [`MOST`] more, each followed over glass and mirrors to the surface that guides the denoiser:
//!
//! ```text
//!   emission noisy, here or beside ──► 2 to 64 rays for each pixel, as many as the share of the picture allows
//!   guides noisy                   ──► 2 to 16, from what is left of the share
//!   n samples, m rays              ──► the mean of all, or of the rays alone if they outnumber the samples
//!   reflected light                ──► times new albedo / old albedo: the fraction of the pixel that a surface covers
//! ```
//!
//! The rays are those of sample indices that no film holds, and their number follows from counts of rays, so the result
//! depends on the film and the scene alone. The colours of the film and the raw layer stay as they are.

use std::ops::Range;

use super::Renderer;
use crate::denoise::{Buffers, Rgb, around, luminance};
use crate::film::{Developed, strips};
use crate::integrator::{CameraSamples, CaughtLight, DenoisingSample, Radiance, RayStats};
use crate::material::Material;
use crate::sampler::SampleId;
use crate::view::{camera_ray, place, place_of, take_points};

/// The first sample index of these rays. It is a multiple of [`MOST`], so that they are evenly distributed.
const FIRST: u32 = 1 << 30;

/// The most rays of a pixel.
const MOST: u32 = 64;

/// Fewer rays than this change too little.
const LEAST: u32 = 2;

/// The most rays of other pixels than those at the edges of lamps.
const MOST_WEAK: u32 = 16;

/// The most rays for each pixel of the picture, continued rays included.
const SHARE: f64 = 2.0;

/// Pixels that tell how many rays continue a camera ray.
const TRIALS: usize = 1024;

/// A pixel's own light tells of a surface if its samples met at least this part of what the rays met.
const KNOWN: f32 = 0.25;

/// The most by which reflected light grows with the albedo.
const GROWTH: f32 = 4.0;

/// Added to albedos where they are divided.
const BLACK: f32 = 0.005;

/// Evaluating the colours of a thin film takes as long as this many rays.
const THIN_FILM: f64 = 7.0;

/// Pixels with noisy guides among nine, where glass splits its light.
const SPLIT: usize = 3;

/// Samples of a pixel are left out if it has this many times as many rays.
const OUTNUMBER: f32 = 2.0;

/// Rays that are traced together.
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

/// A pixel before it got more rays.
struct Own {
    samples: f32,
    guides: [f32; 7],
}

/// Means over the rays of a pixel.
#[derive(Clone, Copy, Default)]
pub(super) struct Means {
    count: f32,
    pub(super) emission: Rgb,
    /// Of the squared luminance.
    emission_square: f32,
    pub(super) guides: [f32; 7],
    /// Of the squares of albedo, normal and distance, each summed over its components.
    guide_squares: [f32; 3],
    /// What is behind the shadow catchers that they met.
    behind: Rgb,
    /// Whether another surface was met behind a shadow catcher: its light is not known.
    is_unclear: bool,
}

impl Means {
    fn add(&mut self, sample: &DenoisingSample, caught: Option<&CaughtLight>, by: f32) {
        let light = sample.emission * by;
        self.count += 1.0;
        if caught.is_some_and(|caught| caught.is_caught) {
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
        self.emission_square *= by;
        self
    }
}

fn add<const N: usize>(sum: &mut [f32; N], values: &[f32; N]) {
    sum.iter_mut().zip(values).for_each(|(sum, v)| *sum += if v.is_finite() { *v } else { 0.0 });
}

impl Renderer {
    /// What a denoiser needs, like [`Renderer::denoising_buffers`], with more camera rays where emission and guides are
    /// noisy: at the edges of lamps and objects, out of focus, behind glass. It takes about as long as two samples of each
    /// pixel without their light.
    pub fn refined_buffers(&self, picture: &Developed<'_>, threads: usize) -> Option<Buffers> {
        let mut buffers = self.denoising_buffers(picture, threads)?;
        if self.prepared.view.film.weights_samples() {
            return Some(buffers);
        }
        self.prepared.choose(threads);
        let kinds = kinds(&buffers, threads);
        let mut left = SHARE * kinds.len() as f64;
        let mut refined = Vec::new();
        for (kind, most) in [(STRONG_EMISSION, MOST), (WEAK_EMISSION, MOST_WEAK), (GUIDES_ALONE, MOST_WEAK)] {
            let pixels: Vec<u32> = (0..kinds.len() as u32).filter(|i| kinds[*i as usize] == kind).collect();
            if pixels.is_empty() {
                continue;
            }
            // The rays of some pixels tell how many rays continue a camera ray, for example through glass.
            let some: Vec<u32> = pixels.iter().copied().step_by(pixels.len().div_ceil(TRIALS)).collect();
            let (_, traced) = self.guide_means(&some, FIRST..FIRST + 1, threads);
            let films = some.iter().filter(|pixel| self.shows_thin_film(**pixel)).count() as f64;
            let factor = 1.0 + THIN_FILM * films / some.len() as f64;
            let cost = factor * traced as f64 / some.len() as f64;
            left -= factor * traced as f64;
            let affordable = left / (pixels.len() as f64 * cost.max(1.0));
            let count = if affordable < f64::from(LEAST) { 0 } else { most.min(affordable as u32) };
            if kind == STRONG_EMISSION {
                buffers.uncertain = uncertain(&buffers, &kinds, threads);
            }
            if count == 0 {
                continue;
            }
            let (means, traced) = self.guide_means(&pixels, FIRST..FIRST + count, threads);
            left -= factor * traced as f64;
            for (pixel, means) in pixels.into_iter().zip(means) {
                let (x, y) = self.position(pixel);
                let samples = self.film.count_and_splats(x, y).map_or(0.0, |(count, _)| count as f32);
                if means.count > 0.0 && samples > 0.0 {
                    let own = Own { samples, guides: buffers.guides[pixel as usize] };
                    buffers.take_rays(pixel as usize, &own, &means);
                    refined.push((pixel, own));
                }
            }
        }
        buffers.follow_albedo(&refined);
        Some(buffers)
    }

    /// The position of a pixel of the crop in the picture.
    fn position(&self, pixel: u32) -> (u32, u32) {
        let crop = self.film.crop;
        (crop.x + pixel % crop.width, crop.y + pixel / crop.width)
    }

    /// Whether the camera sees a thin film in a pixel.
    fn shows_thin_film(&self, pixel: u32) -> bool {
        let p = &self.prepared;
        let (x, y) = self.position(pixel);
        let id = SampleId { x, y, index: FIRST, seed: u64::from(p.view.film.seed) };
        let hit = camera_ray(&p.view, id, place_of(&p.view, &id))
            .and_then(|ray| p.scene.intersect_from_camera(&ray));
        hit.is_some_and(|hit| match p.scene.material_at(&hit) {
            Material::OpenPbr(m) => m.desc.has_thin_film(),
            Material::Mix(_) | Material::Classic(_) | Material::Principled(..) => false,
        })
    }

    /// Traces the rays with these sample indices for each pixel. Returns their means, and the number of rays with all that
    /// follow them. The means are of nothing where the integrator knows no guides.
    pub(super) fn guide_means(
        &self,
        pixels: &[u32],
        indices: Range<u32>,
        threads: usize,
    ) -> (Vec<Means>, u64) {
        let count = indices.len();
        let p = &self.prepared;
        let film = &p.view.film;
        let filter = film.placement();
        let batches: Vec<&[u32]> = pixels.chunks((BATCH / count.max(1)).max(1)).collect();
        let state = || {
            let tracer = p.integrator.guide_tracer(&p.scene, &p.view);
            (tracer, CameraSamples::default(), Vec::<Radiance>::new())
        };
        let means = strips::with(batches.len(), threads, state, |(tracer, samples, radiance), batch| {
            let pixels = batches[batch];
            let Some(tracer) = tracer else { return (vec![Means::default(); pixels.len()], 0) };
            samples.clear();
            let ids = pixels.iter().flat_map(|pixel| {
                let ((x, y), seed) = (self.position(*pixel), u64::from(film.seed));
                indices.clone().map(move |index| SampleId { x, y, index, seed })
            });
            take_points(&p.view, samples, ids.map(|id| (id, place(&p.view, &filter, &id))));
            let mut stats = RayStats::default();
            tracer.radiance(samples, radiance, &mut stats);
            let details = tracer.details();
            let mean = |pixel: usize| {
                let mut means = Means::default();
                for i in pixel * count..(pixel + 1) * count {
                    let is_ray = samples.rays.get(i).is_some_and(|ray| ray.t_max >= 0.0);
                    let none = DenoisingSample::default();
                    let weight = samples.weight(i);
                    let sample = details.denoising.get(i).filter(|_| is_ray).unwrap_or(&none);
                    means.add(
                        sample,
                        details.caught.get(i),
                        weight * film.clamp_factor(sample.emission * weight),
                    );
                }
                means.scaled()
            };
            ((0..pixels.len()).map(mean).collect(), stats.total())
        });
        let traced = means.iter().map(|(_, traced)| traced).sum();
        (means.into_iter().flat_map(|(means, _)| means).collect(), traced)
    }
}

/// A pixel at the edge of a lamp, or in glass that shows one in some samples.
const STRONG_EMISSION: u8 = 1;
/// A pixel whose emission has some noise.
const WEAK_EMISSION: u8 = 2;
/// A pixel whose guides have noise.
const GUIDES_ALONE: u8 = 3;

/// Which pixels get more rays: their kinds, 0 for none.
fn kinds(buffers: &Buffers, threads: usize) -> Vec<u8> {
    let (width, height) = (buffers.width, buffers.height);
    let count = width * height;
    let light = strips::map(count, threads, |i| luminance(&buffers.emission.mean[i]));
    let mean = light.iter().sum::<f32>() / count.max(1) as f32;
    let least = DARK * mean;
    let noise = strips::map(count, threads, |i| {
        buffers.emission.variance[i].max(0.0).sqrt() / light[i].max(least).max(f32::MIN_POSITIVE)
    });
    strips::map(count, threads, |i| {
        let (mut low, mut high, mut most) = (light[i], light[i], 0.0f32);
        for j in around(width, height, i, 1) {
            (low, high, most) = (low.min(light[j]), high.max(light[j]), most.max(noise[j]));
        }
        match () {
            _ if most > STRONG || high - low > CONTRAST * high && high > least => STRONG_EMISSION,
            _ if noise[i] > EMISSION_NOISE => WEAK_EMISSION,
            _ if is_guide_noisy(buffers, i) => GUIDES_ALONE,
            _ => 0,
        }
    })
}

fn is_guide_noisy(buffers: &Buffers, i: usize) -> bool {
    buffers.guide_variances[i].iter().any(|v| *v > GUIDE_NOISE)
}

/// The pixels that may have missed their emission: where glass splits its light, so that guides nearby are noisy, too.
fn uncertain(buffers: &Buffers, kinds: &[u8], threads: usize) -> Vec<bool> {
    let (width, height) = (buffers.width, buffers.height);
    strips::map(width * height, threads, |i| {
        let noisy = || around(width, height, i, 1).filter(|j| is_guide_noisy(buffers, *j)).count();
        kinds[i] == STRONG_EMISSION && noisy() >= SPLIT
    })
}

impl Buffers {
    /// Adds the means of rays to those of the samples of a pixel.
    fn take_rays(&mut self, i: usize, own: &Own, rays: &Means) {
        let (n, m) = (own.samples, rays.count);
        // The pixel was chosen because of its samples, which biases them: many rays replace them.
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

    /// Lets the reflected light of pixels follow their new albedo: what shows a surface in three of eight samples but in a
    /// quarter of the rays is darker. Where hardly any sample met the surface, the pixel takes the light of the neighbour with the
    /// brightest albedo.
    fn follow_albedo(&mut self, refined: &[(u32, Own)]) {
        let mut places = vec![u32::MAX; self.guides.len()];
        (0..).zip(refined).for_each(|(k, (pixel, _))| places[*pixel as usize] = k);
        let albedo = |buffers: &Buffers, i: usize| -> Rgb {
            let own = refined.get(places[i] as usize).map(|(_, own)| &own.guides);
            let guides = own.unwrap_or(&buffers.guides[i]);
            [guides[0], guides[1], guides[2]].map(|v| v.max(0.0))
        };
        let changes: Vec<(usize, Rgb, f32)> = (refined.iter())
            .map(|(pixel, _)| {
                let i = *pixel as usize;
                let [r, g, b, ..] = self.guides[i];
                let new: Rgb = [r, g, b].map(|v| v.max(0.0));
                let brightest = |a: &usize, b: &usize| {
                    luminance(&albedo(self, *a)).total_cmp(&luminance(&albedo(self, *b)))
                };
                let known = luminance(&albedo(self, i)) >= KNOWN * luminance(&new);
                let from = match known {
                    true => i,
                    false => around(self.width, self.height, i, 1).max_by(brightest).unwrap_or(i),
                };
                let old = albedo(self, from);
                let by: Rgb = std::array::from_fn(|c| ((new[c] + BLACK) / (old[c] + BLACK)).min(GROWTH));
                let mean = std::array::from_fn(|c| self.reflected.mean[from][c] * by[c]);
                let square = luminance(&by) * luminance(&by);
                (i, mean, self.reflected.variance[from] * square)
            })
            .collect();
        for (i, mean, variance) in changes {
            (self.reflected.mean[i], self.reflected.variance[i]) = (mean, variance);
        }
    }
}
