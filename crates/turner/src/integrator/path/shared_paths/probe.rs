//! The pilot run for shared paths: whether they reduce noise enough to pay for their shadow rays. A few paths with
//! fixed seeds measure it, so the result is the same on every run.

use super::{CELL, CLUSTER, SharedPaths, cluster};
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Off;
use crate::integrator::path::{CausticsStrategy, Context, PathDesc, SharedPathsMode};
use crate::integrator::probing::is_cheap;
use crate::integrator::{CameraSamples, Radiance, RayStats, Tracer, tasks};
use crate::sampler::SampleId;
use crate::view::{View, place_of, take_points};

/// Numbers of pixels that may share paths.
const SIZES: [u32; 3] = [4, 8, CLUSTER as u32];

/// Clusters that are measured, along the width and height of the image.
const SIDE: u32 = 8;

/// Cost of a shadow ray that joins two paths, in rays of paths with their shading: measured 0.1 to 0.43. Cost of sharing a
/// path, without those rays, relative to the path: 0.05 to 0.35.
const SHADOW_RAY_COST: f64 = 0.33;
const SHARING_COST: f64 = 0.14;

/// In dark clusters errors are relative to the median luminance: this fraction of its square is added.
const DARK: f64 = 0.1;

/// Maximum cost for the same noise, relative to separate paths. Costs near this limit were measured within a quarter of the
/// estimate; where sharing gains much, they were up to half as much again.
const MAX_COST: f64 = 0.97;

/// Passes over the image, each with other clusters, until the result is clear.
const OFFSETS: [[u32; 2]; 3] = [[4, 4], [0, 2], [2, 6]];

/// Costs that are in doubt: more clusters are traced.
const DOUBT: std::ops::Range<f64> = 0.85..1.15;

/// Samples per pixel, which are well distributed as those of a picture are: noise that they remove by themselves need not
/// be removed by sharing.
const SAMPLES: u32 = 4;

/// Seeds of the two estimates of each pixel.
const SEEDS: [u64; 2] = [0x51de, 0x9e37_79b9];

/// Clusters in a batch.
const TOGETHER: usize = 16;

/// Luminances of pixels, two estimates of each, and the number of rays traced.
#[derive(Default)]
struct PilotRun {
    clusters: Vec<Vec<[f64; 2]>>,
    rays: f64,
}

/// Decides whether paths are shared, and among how many pixels. If that gains more than optional light paths, it replaces
/// them. Returns the remaining light paths, and the number of pixels that share paths; 1 if they do not.
pub(in crate::integrator::path) fn decide(
    context: Context<'_>,
    desc: &PathDesc,
    strategy: Option<CausticsStrategy>,
) -> (Option<CausticsStrategy>, u32) {
    let Context { scene, view, settings, .. } = context;
    if !settings.shared_paths {
        return (strategy, 1);
    }
    let is_possible = SharedPaths::is_possible(scene, view);
    if desc.shared_paths == SharedPathsMode::Always {
        let shares_paths = is_possible && strategy.is_none();
        return (strategy, if shares_paths { CLUSTER as u32 } else { 1 });
    }
    let least = strategy.as_ref().map_or(Some(MAX_COST), |strategy| strategy.gain);
    // Scenes with expensive rays are not probed.
    let Some(least) = least.filter(|_| is_possible && is_cheap(scene, view)) else { return (strategy, 1) };
    match cheapest(context) {
        (cost, size) if cost < least.min(MAX_COST) => (None, size),
        _ => (strategy, 1),
    }
}

/// The number of pixels that share paths at the least cost for the same noise, and that cost relative to separate paths;
/// it is infinite where there is no noise.
fn cheapest(context: Context<'_>) -> (f64, u32) {
    let mut runs = [PilotRun::default(), PilotRun::default()];
    let mut least = (f64::INFINITY, 1);
    for offset in OFFSETS {
        trace(context, offset, &mut runs);
        let [separate, shared] = &runs;
        // The mean is that of a cluster: with a few samples of one pixel an outlier would dominate its own mean.
        let means: Vec<f64> =
            separate.clusters.iter().zip(&shared.clusters).map(|(a, b)| mean(a, b)).collect();
        let all = typical(&means);
        let squares: Vec<f64> = means.iter().map(|mean| mean * mean + DARK * all * all).collect();
        let joined = (shared.rays - separate.rays).max(0.0) / separate.rays;
        let (separate, shared) = (separate.noise(&squares), shared.noise(&squares));
        if separate > 0.0 && joined > 0.0 {
            let cost = |size| (cost(shared / separate, joined, size), size);
            least = SIZES.map(cost).into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(least);
        }
        if !DOUBT.contains(&least.0) {
            break;
        }
    }
    least
}

/// Cost for the same noise of clusters of `size` pixels, relative to separate paths. `noise` and `joined` are those of the
/// largest clusters, relative to separate paths: the noise, and the number of rays that join paths.
fn cost(noise: f64, joined: f64, size: u32) -> f64 {
    let (n, most) = (f64::from(size), CLUSTER as f64);
    // The part of the noise that is shared falls to 1/n.
    let falls = ((1.0 - noise) * most / (most - 1.0)).clamp(0.0, 1.0);
    let stays = (noise - falls / most).max(0.0);
    let time = 1.0 + SHARING_COST + SHADOW_RAY_COST * joined * (n - 1.0) / (most - 1.0);
    (stays + falls / n) * time
}

/// The median, or the mean where the median is 0. A visible window may be a hundred times brighter than the room, so the
/// noise of the room is small relative to the mean luminance of the image.
fn typical(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    sorted.get(values.len() / 2).copied().filter(|median| *median > 0.0).unwrap_or(mean)
}

/// Mean luminance of all samples of a cluster.
fn mean(separate: &[[f64; 2]], shared: &[[f64; 2]]) -> f64 {
    let sum: f64 = separate.iter().chain(shared).flatten().sum();
    sum / (2 * (separate.len() + shared.len())).max(1) as f64
}

impl PilotRun {
    /// Sum over all pixels of the squared difference of the two estimates, divided by the square of their cluster.
    fn noise(&self, squares: &[f64]) -> f64 {
        let of_cluster = |cluster: &[[f64; 2]]| cluster.iter().map(|[a, b]| (a - b) * (a - b)).sum::<f64>();
        let terms = self.clusters.iter().zip(squares).filter(|(_, square)| **square > 0.0);
        terms.map(|(cluster, square)| of_cluster(cluster) / square).sum()
    }
}

/// One sample of each pixel of some clusters: luminances, and the number of rays.
struct Traced {
    clusters: Vec<Vec<f64>>,
    rays: u64,
}

/// Measures clusters all over the image, offset by `offset` in eighths of their distance, with separate and with shared
/// paths.
fn trace(context: Context<'_>, offset: [u32; 2], runs: &mut [PilotRun; 2]) {
    let film = &context.view.film;
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
    let parts: Vec<&[[u32; 2]]> = corners.chunks(TOGETHER).collect();
    // Of a batch all samples have one index, because the place of a pixel tells its cluster.
    let of_mode = parts.len() * (SEEDS.len() * SAMPLES as usize);
    let worker = || [1, CLUSTER as u32].map(|cluster| PathBatch::new(Context { cluster, ..context }, Off));
    let traced = tasks::map(runs.len() * of_mode, context.threads, worker, |batches, i| {
        let (mode, i) = (i / of_mode, i % of_mode);
        let (sample, part) = (i / parts.len(), parts[i % parts.len()]);
        let seed = SEEDS[sample / SAMPLES as usize] + u64::from(offset[0]);
        one_sample(context.view, &mut batches[mode], part, sample as u32 % SAMPLES, seed)
    });
    for (run, traced) in runs.iter_mut().zip(traced.chunks(of_mode)) {
        run.rays += traced.iter().map(|traced| traced.rays as f64).sum::<f64>();
        for (i, _) in corners.iter().enumerate() {
            let of_seed = |seed: usize| {
                let samples = traced.chunks(parts.len()).skip(seed * SAMPLES as usize).take(SAMPLES as usize);
                let clusters =
                    samples.filter_map(|parts| parts.get(i / TOGETHER)?.clusters.get(i % TOGETHER));
                let mut sums = Vec::new();
                for values in clusters {
                    sums.resize(values.len(), 0.0);
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value / f64::from(SAMPLES));
                }
                sums
            };
            run.clusters.push(of_seed(0).into_iter().zip(of_seed(1)).map(|(a, b)| [a, b]).collect());
        }
    }
}

/// Traces one sample of each pixel of a cluster in each of the cells with these corners.
fn one_sample(view: &View, batch: &mut PathBatch<'_>, corners: &[[u32; 2]], index: u32, seed: u64) -> Traced {
    let of_cluster = |&[x, y]: &[u32; 2]| cluster(view, SampleId { x, y, index, seed }, CLUSTER as u32);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn cheapest_size(noise: f64, joined: f64) -> (f64, u32) {
        let all = SIZES.map(|size| (cost(noise, joined, size), size));
        all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    #[test]
    fn the_size_follows_noise_and_rays() {
        // All noise falls: to a quarter, an eighth, a sixteenth.
        for size in SIZES {
            let expected = (1.0 + SHARING_COST) / f64::from(size);
            assert!((cost(1.0 / 16.0, 0.0, size) - expected).abs() < 1e-12, "{size}");
        }
        assert_eq!(cheapest_size(0.1, 1.5).1, 16);
        assert_eq!(cheapest_size(0.4, 1.3).1, 8);
        assert_eq!(cheapest_size(0.7, 1.8).1, 4);
        // Sharing that removes no noise costs its rays, and more where it adds noise.
        assert!(cheapest_size(1.0, 1.0).0 > 1.0 && cheapest_size(1.5, 1.0).0 > 1.5);
    }
}
