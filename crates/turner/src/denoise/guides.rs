//! Guides without noise: where they are noisy, out of focus, in motion or behind glass, they are averaged with similar
//! neighbours.

use super::{Buffers, GUIDES, around, box_mean};
use crate::film::strips;

/// Radius of the window.
const RADIUS: usize = 4;

/// The least variance that counts as noise.
const NOISE: f32 = 1e-4;

/// Of the nine variances around a pixel as many as this may be below, so that edges of one pixel stay as they are.
const QUIET: usize = 2;

/// The components of each group of guides that share a variance.
const GROUPS: [std::ops::Range<usize>; 3] = [0..3, 3..6, 6..7];

/// The guides of each pixel.
pub(super) fn filtered(buffers: &Buffers, threads: usize) -> Vec<[f32; GUIDES]> {
    let (width, height) = (buffers.width, buffers.height);
    let (raw, variances) = (&buffers.guides, &buffers.guide_variances);
    let count = width * height;
    let is_noisy = strips::map(count, threads, |i| {
        (0..GROUPS.len()).any(|k| {
            let quiet = around(width, height, i, 1).filter(|j| variances[*j][k] <= NOISE).count();
            quiet <= QUIET
        })
    });
    if !is_noisy.contains(&true) {
        return raw.clone();
    }
    let smooth: [Vec<f32>; 3] =
        std::array::from_fn(|k| box_mean(width, height, 1, threads, |i| variances[i][k]));
    strips::map(count, threads, |i| {
        if !is_noisy[i] {
            return raw[i];
        }
        let (mut sums, mut total) = ([0.0f32; GUIDES], 0.0f32);
        for j in around(width, height, i, RADIUS) {
            let mut distance = 0.0f32;
            for (group, variance) in GROUPS.into_iter().zip(&smooth) {
                let apart = group.map(|c| (raw[i][c] - raw[j][c]) * (raw[i][c] - raw[j][c])).sum::<f32>();
                let (own, other) = (variance[i], variance[j]);
                distance = distance.max((apart - own - own.min(other)) / (1e-4 + own + other));
            }
            let near = (1.0 - 0.25 * distance).max(0.0);
            let weight = (near * near) * (near * near);
            total += weight;
            sums.iter_mut().zip(&raw[j]).for_each(|(sum, v)| *sum += weight * v);
        }
        sums.map(|sum| sum / total)
    })
}
