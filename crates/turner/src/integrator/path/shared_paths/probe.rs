//! The pilot run for shared paths: whether they reduce noise enough to pay for their shadow rays. A few paths with
//! fixed seeds measure it, so the result is the same on every run.

use super::{CELL, CLUSTER, SharedPaths, cluster};
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Off;
use crate::integrator::path::{CausticsStrategy, Context, PathDesc, SharedPathsMode};
use crate::integrator::probing::is_cheap;
use crate::integrator::{CameraSamples, RayStats, Tracer};
use crate::sampler::SampleId;
use crate::view::{place_of, take_points};

/// Clusters that are measured, along the width and height of the image.
const SIDE: u32 = 8;

/// Cost of a shadow ray that joins two paths, in rays of paths with their shading. Measured.
const SHADOW_RAY_COST: f64 = 0.4;

/// In dark clusters errors are relative to the median luminance: this fraction of its square is added.
const DARK: f64 = 0.1;

/// Maximum cost for the same noise, relative to separate paths. The estimate is too low where little noise is indirect: 0.44
/// instead of 0.79 in S3, 0.65 instead of 0.99 in a model in the studio. In rooms it is right within 0.2.
const MAX_COST: f64 = 0.65;

/// Passes over the image, each with other clusters, until the result is clear.
const OFFSETS: [[u32; 2]; 2] = [[4, 4], [0, 2]];

/// Samples per pixel, which are well distributed as those of a picture are: noise that they remove by themselves need not
/// be removed by sharing.
const SAMPLES: u32 = 4;

/// A result within this factor of `MAX_COST` is in doubt: more clusters are traced.
const DOUBT: f64 = 1.25;

/// Luminances of pixels, two estimates of each, and the number of rays traced.
#[derive(Default)]
struct PilotRun {
    clusters: Vec<Vec<[f64; 2]>>,
    rays: f64,
}

/// Decides whether paths are shared. If that gains more than optional light paths, it replaces them. Returns the
/// remaining light paths, and whether paths are shared.
pub(in crate::integrator::path) fn decide(
    context: Context<'_>,
    desc: &PathDesc,
    strategy: Option<CausticsStrategy>,
) -> (Option<CausticsStrategy>, bool) {
    let Context { scene, view, settings, .. } = context;
    if !settings.shared_paths {
        return (strategy, false);
    }
    let is_possible = SharedPaths::is_possible(scene, view);
    if desc.shared_paths == SharedPathsMode::Always {
        let shares_paths = is_possible && strategy.is_none();
        return (strategy, shares_paths);
    }
    let least = strategy.as_ref().map_or(Some(MAX_COST), |strategy| strategy.gain);
    // Scenes with expensive rays are not probed.
    let gains = |least: f64| is_cheap(scene, view) && gain(context) < least.min(MAX_COST);
    match is_possible && least.is_some_and(gains) {
        true => (None, true),
        false => (strategy, false),
    }
}

/// Cost for the same noise relative to separate paths; infinite where there is no noise.
fn gain(context: Context<'_>) -> f64 {
    let (mut separate, mut shared) = (PilotRun::default(), PilotRun::default());
    let mut gain = f64::INFINITY;
    for offset in OFFSETS {
        separate.add(context, offset, false);
        shared.add(context, offset, true);
        // The mean is that of a cluster: with a few samples of one pixel an outlier would dominate its own mean.
        let means: Vec<f64> =
            separate.clusters.iter().zip(&shared.clusters).map(|(a, b)| mean(a, b)).collect();
        let all = typical(&means);
        let squares: Vec<f64> = means.iter().map(|mean| mean * mean + DARK * all * all).collect();
        let joined = (shared.rays - separate.rays).max(0.0) / separate.rays;
        let (separate, shared) = (separate.noise(&squares), shared.noise(&squares));
        gain =
            if separate > 0.0 { shared * (1.0 + SHADOW_RAY_COST * joined) / separate } else { f64::INFINITY };
        if joined == 0.0 || !(MAX_COST / DOUBT..MAX_COST * DOUBT).contains(&gain) {
            break;
        }
    }
    gain
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

    /// Measures clusters all over the image, offset by `offset` in eighths of their distance.
    fn add(&mut self, context: Context<'_>, offset: [u32; 2], shared: bool) {
        let view = context.view;
        let film = &view.film;
        let mut batch = PathBatch::new(Context { shares_paths: shared, ..context }, Off);
        for cell in 0..SIDE * SIDE {
            let corner = |n: u32, offset: u32, size: u32| {
                let at = (u64::from(size) * u64::from(8 * n + offset) / u64::from(8 * SIDE)) as u32;
                at - at % CELL
            };
            let x = corner(cell % SIDE, offset[0], film.width);
            let y = corner(cell / SIDE, offset[1], film.height);
            let [first, second] = [0x51de, 0x9e37_79b9].map(|seed| {
                let mut sums = [0.0; CLUSTER];
                let mut count = 0;
                for index in 0..SAMPLES {
                    let id = SampleId { x, y, index, seed: seed + u64::from(offset[0]) };
                    let mut samples = CameraSamples::default();
                    let points = cluster(view, id).map(|id| (id, place_of(view, &id).into()));
                    take_points(view, &mut samples, points);
                    let (mut out, mut stats) = (Vec::new(), RayStats::default());
                    batch.radiance(&samples, &mut out, &mut stats);
                    self.rays += stats.total() as f64;
                    count = out.len().min(CLUSTER);
                    for (sum, radiance) in sums.iter_mut().zip(&out) {
                        let value = f64::from(radiance.color.luminance()) / f64::from(SAMPLES);
                        *sum += if value.is_finite() { value } else { 0.0 };
                    }
                }
                sums[..count].to_vec()
            });
            self.clusters.push(first.into_iter().zip(second).map(|(a, b)| [a, b]).collect());
        }
    }
}
