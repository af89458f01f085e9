//! Pilot runs: a few paths with fixed seeds, traced with several settings, tell which of them has the least noise. The
//! result is the same on every run.

use super::path_batch::PathBatch;
use super::record::Off;
use super::{CELL, Context, cluster};
use crate::integrator::{CameraSamples, Radiance, RayStats, Tracer, tasks};
use crate::sampler::SampleId;
use crate::view::{View, place_of, take_points};

/// Clusters that are measured, along the width and height of the image.
const SIDE: u32 = 8;

/// In dark clusters errors are relative to the median luminance: this fraction of its square is added.
const DARK: f64 = 0.1;

/// Passes over the image, each with other clusters, until the result is clear.
pub(super) const OFFSETS: [[u32; 2]; 3] = [[4, 4], [0, 2], [2, 6]];

/// Samples per pixel, which are well distributed as those of a picture are: noise that they remove by themselves need not
/// be removed by sharing.
const SAMPLES: u32 = 4;

/// Seeds of the two estimates of each pixel.
const SEEDS: [u64; 2] = [0x51de, 0x9e37_79b9];

/// Clusters in a batch.
const TOGETHER: usize = 16;

/// Pixels all over the image, traced with several settings.
pub(super) struct PilotRun<'a> {
    modes: &'a [Context<'a>],
    /// Number of pixels of a cluster.
    size: u32,
    /// What each setting found.
    found: Vec<Found>,
}

/// What was found with one setting: for each pixel of each cluster two estimates of its luminance, and the number of rays.
#[derive(Clone, Default)]
struct Found {
    clusters: Vec<Vec<[f64; 2]>>,
    rays: f64,
}

/// The result of tracing one sample of each pixel in some clusters: their luminances, and the number of rays.
struct Traced {
    clusters: Vec<Vec<f64>>,
    rays: u64,
}

impl<'a> PilotRun<'a> {
    /// A pilot run before its first ray. `size` is the number of pixels in a cluster: at least the number of pixels that share
    /// paths.
    pub(super) fn new(modes: &'a [Context<'a>], size: u32) -> PilotRun<'a> {
        PilotRun { modes, size, found: vec![Found::default(); modes.len()] }
    }

    /// The number of rays that a setting took so far.
    pub(super) fn rays(&self, mode: usize) -> f64 {
        self.found[mode].rays
    }

    /// For each setting the sum over all pixels of the squared difference of the two estimates, relative to the square of
    /// the luminance of their cluster.
    pub(super) fn noises(&self) -> Vec<f64> {
        let clusters = self.found.first().map_or(0, |found| found.clusters.len());
        // The mean is that of a cluster: with a few samples of one pixel an outlier would dominate its own mean.
        let means: Vec<f64> = (0..clusters)
            .map(|i| {
                let all = || self.found.iter().flat_map(|found| found.clusters[i].iter().flatten());
                all().sum::<f64>() / all().count().max(1) as f64
            })
            .collect();
        let all = typical(&means);
        let squares: Vec<f64> = means.iter().map(|mean| mean * mean + DARK * all * all).collect();
        let noise = |found: &Found| {
            let of_cluster =
                |cluster: &[[f64; 2]]| cluster.iter().map(|[a, b]| (a - b) * (a - b)).sum::<f64>();
            let terms = found.clusters.iter().zip(&squares).filter(|(_, square)| **square > 0.0);
            terms.map(|(cluster, square)| of_cluster(cluster) / square).sum()
        };
        self.found.iter().map(noise).collect()
    }

    /// Traces clusters all over the image, offset by `offset` in eighths of their distance, with each setting.
    pub(super) fn trace(&mut self, offset: [u32; 2]) {
        let Some(Context { view, threads, .. }) = self.modes.first().copied() else { return };
        let corners = corners(view, offset);
        let parts: Vec<&[[u32; 2]]> = corners.chunks(TOGETHER).collect();
        // All samples of a batch have the same index: within one index, a pixel belongs to one cluster.
        let of_mode = parts.len() * (SEEDS.len() * SAMPLES as usize);
        let worker = || self.modes.iter().map(|&mode| PathBatch::new(mode, Off)).collect::<Vec<_>>();
        let traced = tasks::map(self.modes.len() * of_mode, threads, worker, |batches, i| {
            let (mode, i) = (i / of_mode, i % of_mode);
            let (sample, part) = (i / parts.len(), parts[i % parts.len()]);
            let seed = SEEDS[sample / SAMPLES as usize] + u64::from(offset[0]);
            let id = SampleId { x: 0, y: 0, index: sample as u32 % SAMPLES, seed };
            one_sample(view, &mut batches[mode], part, id, self.size)
        });
        for (found, traced) in self.found.iter_mut().zip(traced.chunks(of_mode)) {
            found.rays += traced.iter().map(|traced| traced.rays as f64).sum::<f64>();
            for (i, _) in corners.iter().enumerate() {
                let of_seed = |seed: usize| {
                    let samples = traced.chunks(parts.len());
                    let samples = samples.skip(seed * SAMPLES as usize).take(SAMPLES as usize);
                    let clusters =
                        samples.filter_map(|parts| parts.get(i / TOGETHER)?.clusters.get(i % TOGETHER));
                    let mut sums = Vec::new();
                    for values in clusters {
                        sums.resize(values.len(), 0.0);
                        sums.iter_mut()
                            .zip(values)
                            .for_each(|(sum, value)| *sum += value / f64::from(SAMPLES));
                    }
                    sums
                };
                found.clusters.push(of_seed(0).into_iter().zip(of_seed(1)).map(|(a, b)| [a, b]).collect());
            }
        }
    }
}

/// The corners of the cells that are measured.
fn corners(view: &View, offset: [u32; 2]) -> Vec<[u32; 2]> {
    let film = &view.film;
    let mut corners: Vec<[u32; 2]> = Vec::new();
    for cell in 0..SIDE * SIDE {
        let corner = |n: u32, offset: u32, size: u32| {
            let at = (u64::from(size) * u64::from(8 * n + offset) / u64::from(8 * SIDE)) as u32;
            at - at % CELL
        };
        let corner =
            [corner(cell % SIDE, offset[0], film.width), corner(cell / SIDE, offset[1], film.height)];
        // The cells of small pictures coincide.
        if !corners.contains(&corner) {
            corners.push(corner);
        }
    }
    corners
}

/// The median, or the mean where the median is 0. A visible window may be a hundred times brighter than the room, so the
/// noise of the room is small relative to the mean luminance of the image.
fn typical(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    sorted.get(values.len() / 2).copied().filter(|median| *median > 0.0).unwrap_or(mean)
}

/// Traces one sample of each pixel of a cluster in each of the cells with these corners.
fn one_sample(
    view: &View,
    batch: &mut PathBatch<'_>,
    corners: &[[u32; 2]],
    id: SampleId,
    size: u32,
) -> Traced {
    let of_cluster = |&[x, y]: &[u32; 2]| cluster(view, SampleId { x, y, ..id }, size);
    let mut samples = CameraSamples::default();
    take_points(
        view,
        &mut samples,
        corners.iter().flat_map(of_cluster).map(|id| (id, place_of(view, &id).into())),
    );
    let (mut out, mut stats) = (Vec::new(), RayStats::default());
    batch.radiance(&samples, &mut out, &mut stats);
    let value = |radiance: &Radiance| f64::from(radiance.color.luminance());
    let mut values = out.iter().map(value).map(|value| if value.is_finite() { value } else { 0.0 });
    let clusters = corners.iter().map(|corner| values.by_ref().take(of_cluster(corner).count()).collect());
    Traced { clusters: clusters.collect(), rays: stats.total() }
}
