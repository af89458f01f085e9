//! Replays the paths of the probe and measures light, variance and cost, by kind of path, source and material.
//!
//! Let x_i be the luminance of sample i of a pixel and x_ik its contribution with key k. The part of k in the variance
//! is cov(x_k, x) = 1/(n − 1) Σ_i (x_ik − mean x_k)(x_i − mean x). As x_i = Σ_k x_ik, the parts sum to the variance.
//! All are divided by m² + 0.01, which makes them relative like relMSE; m is the mean without the largest sample.

use std::collections::BTreeMap;

use super::grid::Pixel;
use super::kind::{Contribution, LightBounds, PathKind, Source, contributions};
use super::{Options, threads};
use crate::doctor::subject::Subject;
use crate::integrator::path::{End, Passage, PathRecord, replay_at};
use crate::math::DVec3;
use crate::scene::Scene;
use crate::schema::MaterialId;
use crate::view::place_of;

/// The maximum number of vertices and shadow casters per pixel, so that no pixel takes too long.
const MAX_WORK: u64 = 20_000;

/// The key of a contribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    pub(super) kind: PathKind,
    pub(super) source: Source,
    pub(super) material: Option<MaterialId>,
}

/// The statistics of the contributions with one key.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ContributionStats {
    /// The mean luminance over the pixel's samples.
    pub(super) light: f64,
    /// The part of the relative variance of one sample.
    pub(super) variance: f64,
    /// The part of the relative variance due to BSDF-sampled rays that hit the light.
    pub(super) bsdf_sampled: f64,
}

/// The statistics of one pixel.
#[derive(Clone, Debug, Default)]
pub(super) struct PixelPaths {
    pub(super) samples: u32,
    /// Number of vertices and shadow casters.
    pub(super) work: u64,
    /// Mean luminance and mean colour.
    pub(super) mean: f64,
    pub(super) color: [f64; 3],
    pub(super) alpha: f64,
    /// The relative variance of one sample: var / (mean² + 0.01), with the mean without the largest sample.
    pub(super) variance: f64,
    /// The same with the effect of stratification: the relative variance of the mean of eight samples, times eight.
    pub(super) stratified_variance: f64,
    /// The fraction of the variance due to the largest sample.
    pub(super) spike: f64,
    pub(super) contributions: BTreeMap<Key, ContributionStats>,
    pub(super) non_finite: u32,
    pub(super) ends: BTreeMap<&'static str, u32>,
    /// Number of paths that a depth limit ended although their throughput was not 0.
    pub(super) cut: u32,
    pub(super) vertices: u64,
    pub(super) passed: u64,
    pub(super) longest: u32,
    pub(super) shadow_rays: u64,
    /// Number of vertices by primitive, with the primitive's material.
    pub(super) by_primitive: BTreeMap<u32, (u64, MaterialId)>,
    /// Light samples that transmissive objects block: unshadowed luminance by light and material.
    pub(super) behind_glass: BTreeMap<(Source, MaterialId), f64>,
    /// Blocked light samples: unshadowed luminance.
    pub(super) shadowed: f64,
    /// Points at which lights can be sampled, with the normal on the side that the path came from.
    pub(super) points: Vec<(DVec3, DVec3)>,
    /// Number of transparent surfaces that paths passed, by material.
    pub(super) holes: BTreeMap<MaterialId, u64>,
}

/// Traces the paths of all pixels. `exposure` is the factor from radiance to displayed values. `None` for pixels that
/// were not started before `stop` returned true.
pub(super) fn trace(
    scene: &Subject,
    pixels: &[Pixel],
    samples: u32,
    exposure: f64,
    options: &Options<'_>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Option<PixelPaths>> {
    let light_bounds = LightBounds::new(scene);
    threads::map(pixels, options.threads, stop, |pixel| {
        trace_pixel(scene, &light_bounds, pixel, samples, exposure)
    })
}

fn trace_pixel(
    scene: &Subject,
    light_bounds: &LightBounds,
    pixel: &Pixel,
    samples: u32,
    exposure: f64,
) -> PixelPaths {
    let mut out = PixelPaths::default();
    let mut totals: Vec<f64> = Vec::new();
    let mut by_key: BTreeMap<Key, (Vec<f64>, Vec<f64>)> = BTreeMap::new();
    let mut work = 0;
    for index in 0..samples {
        if work > MAX_WORK && index >= 2 {
            break;
        }
        let id = pixel.sample(scene, index);
        let Ok(path) = replay_at(&scene.prepared, id, place_of(&scene.prepared.view, &id)) else { break };
        work += record(&mut out, scene, light_bounds, &path);
        out.work = work;
        out.samples += 1;
        out.alpha += f64::from(path.radiance.alpha);
        let color = path.radiance.color;
        if !color.is_finite() {
            out.non_finite += 1;
            continue;
        }
        for (sum, v) in out.color.iter_mut().zip(color.to_array()) {
            *sum += f64::from(v);
        }
        let number = totals.len();
        totals.push(exposure * f64::from(color.luminance()));
        contributions(
            scene,
            light_bounds,
            &path,
            |Contribution { kind, source, material, is_bsdf_sampled, value }| {
                let (all, bsdf_sampled) = by_key.entry(Key { kind, source, material }).or_default();
                for (list, counts) in [(all, true), (bsdf_sampled, is_bsdf_sampled)] {
                    list.resize(number + 1, 0.0);
                    if let (Some(last), true) = (list.last_mut(), counts) {
                        *last += exposure * value;
                    }
                }
            },
        );
    }
    let n = totals.len() as f64;
    if n == 0.0 {
        return out;
    }
    let mean = totals.iter().sum::<f64>() / n;
    out.mean = mean / exposure;
    out.color = out.color.map(|c| c / n);
    out.alpha /= f64::from(out.samples);
    // The mean without the largest sample: a firefly raises the mean and would hide its own relative variance.
    let largest = totals.iter().copied().fold(0.0, f64::max);
    let usual = if n > 2.0 { (mean * n - largest) / (n - 1.0) } else { mean };
    let scale = 1.0 / ((n - 1.0).max(1.0) * (usual * usual + 0.01));
    let squares = |list: &[f64]| -> f64 {
        let padded = list.iter().chain(std::iter::repeat(&0.0)).zip(&totals);
        let part = list.iter().sum::<f64>() / n;
        padded.map(|(a, x)| (a - part) * (x - mean)).sum::<f64>() * scale
    };
    out.variance = squares(&totals);
    out.stratified_variance = blocks(&totals, mean) / (usual * usual + 0.01);
    let largest = totals.iter().map(|x| (x - mean) * (x - mean)).fold(0.0, f64::max);
    out.spike = if out.variance > 0.0 { largest * scale / out.variance } else { 0.0 };
    for (key, (all, bsdf_sampled)) in by_key {
        let light = all.iter().sum::<f64>() / n / exposure;
        out.contributions.insert(
            key,
            ContributionStats { light, variance: squares(&all), bsdf_sampled: squares(&bsdf_sampled) },
        );
    }
    out
}

/// The variance of the means of blocks of eight successive samples, times eight. Without stratification it equals the
/// variance of a sample. With fewer than two blocks, the variance of the samples.
fn blocks(totals: &[f64], mean: f64) -> f64 {
    const SIZE: usize = 8;
    let size = if totals.len() >= 2 * SIZE { SIZE } else { 1 };
    let blocks = totals.chunks_exact(size);
    let count = blocks.len() as f64;
    let squares = blocks.map(|b| b.iter().sum::<f64>() / size as f64 - mean).map(|d| d * d);
    squares.sum::<f64>() * size as f64 / (count - 1.0).max(1.0)
}

/// Adds the statistics of one path. Returns its work.
fn record(out: &mut PixelPaths, scene: &Scene, light_bounds: &LightBounds, path: &PathRecord) -> u64 {
    let mut work = path.vertices.len() as u64 + 1;
    *out.ends.entry(path.end.word()).or_default() += 1;
    let carried = path.vertices.last().is_some_and(|v| !v.throughput.is_black());
    out.cut += u32::from(path.end == End::Depth && carried);
    out.longest = out.longest.max(path.vertices.len() as u32);
    let mut seen = false;
    for v in &path.vertices {
        out.vertices += 1;
        if v.passage != Passage::Medium {
            let entry = out.by_primitive.entry(v.primitive).or_insert((0, v.material));
            let steps = v.walk.map_or(0, |walk| u64::from(walk.steps));
            entry.0 += 1 + steps;
            work += steps;
        }
        match v.passage {
            Passage::Surface => {}
            Passage::Hole | Passage::Pane => {
                out.passed += 1;
                *out.holes.entry(v.material).or_default() += 1;
            }
            Passage::Hidden | Passage::Interface | Passage::Medium | Passage::Exit => {}
        }
        // The first surface of the path at which lights can be sampled.
        let rough = v.scatter.as_ref().is_none_or(|s| !s.lobe.is_delta) || !v.lights.is_empty();
        if !seen && v.passage == Passage::Surface && rough && out.points.len() < 3 {
            seen = true;
            out.points.push((v.p, if v.outside { v.ng } else { -v.ng }));
        }
        for light in &v.lights {
            let Some(visible) = light.visible else { continue };
            out.shadow_rays += 1;
            work += light.casters.len() as u64;
            let lost = f64::from(light.unshadowed.luminance());
            if visible.is_black() && lost.is_finite() {
                out.shadowed += lost;
                if let Some(caster) =
                    light.casters.first().filter(|c| super::kind::casts_caustics(scene, c.material))
                {
                    let source = light_bounds.source_of(scene, v, light);
                    *out.behind_glass.entry((source, caster.material)).or_default() += lost;
                }
            }
        }
    }
    work
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_see_how_evenly_samples_are_spread() {
        // Each block of eight has the same mean: no variance.
        let even: Vec<f64> = (0..32).map(|i| f64::from(i % 8)).collect();
        assert!(blocks(&even, 3.5) < 1e-20);
        // Blocks of equal samples are no better than single samples.
        let lumps: Vec<f64> = (0..32).map(|i| f64::from(i / 8 % 2)).collect();
        assert!((blocks(&lumps, 0.5) - 8.0 / 3.0).abs() < 1e-12);
        assert!((blocks(&[0.0, 1.0], 0.5) - 0.5).abs() < 1e-12);
        assert_eq!(blocks(&[], 0.0), 0.0);
    }
}
