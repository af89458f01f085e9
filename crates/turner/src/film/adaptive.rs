//! Adaptive sampling: which samples the tiles of a film are to have.
//!
//! An adaptive film holds for each [`Half`] of a tile a set of samples of its own, and a goal: the number of samples that
//! it is to have. Passes trace what is missing up to the goals. Once all goals are reached, [`Film::allot`] raises them:
//!
//! ```text
//! n  ∝  σ / √c      σ: standard deviation of one sample;  c: rays of one sample
//! ```
//!
//! This minimizes the mean squared error for a given number of rays (Neyman allocation). Errors are relative to
//! the pixel's luminance to the power of 3/4: between those of scene values, which noise in bright pixels dominates, and
//! relative ones, which dark pixels dominate. Each goal lies between a quarter and sixteen times the mean.
//!
//! **Without bias.** A pixel would be too dark if its own samples decided on their number: where a rare bright sample is
//! found early, many more follow and its weight falls; where it is not, the tile ends early. So σ of one half of a tile is
//! estimated from the pixels of the *other* half, whose samples are independent. The samples within a pixel keep
//! equal weights, so nothing else in the film changes.
//!
//! **Filters.** Where a sample counts in several pixels by weight, different numbers of samples on both sides of an edge
//! would shift the edge. Such films get even goals.
//!
//! **Same bytes.** Goals are raised when all goals are reached and the mean is 8, 12, 16, 24, 32, … samples per pixel. They
//! depend on the film at that moment alone, and the film stores them. So threads, passes, interrupts and merges do not
//! change them.

use super::{Film, Half, SampleSet};

/// Samples per pixel before the first decision.
const FIRST: u32 = 8;

/// Each goal is at least the mean divided by this.
const LEAST: f64 = 4.0;

/// Each goal is at most the mean multiplied by this.
pub(super) const MOST: u32 = 16;

/// Added to the luminance to which errors are relative, as a fraction of the mean of the picture.
const DARK: f64 = 0.1;

/// Weight of the neighbouring tiles in σ.
const NEIGHBOURS: f64 = 0.5;

/// What an adaptive film holds for a tile in addition.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct AdaptiveTile {
    /// The samples of the odd half.
    pub(super) odd: SampleSet,
    /// The samples that the halves are to have.
    pub(super) goals: [u32; 2],
    /// Rays of the samples with an index above 0: those of index 0 may come from a preview.
    pub(super) rays: u64,
}

/// Half of a tile, as a decision sees it.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    /// Number of pixels.
    area: u64,
    /// The goal so far.
    goal: u32,
    /// σ from its own pixels; `None` without pixels.
    deviation: Option<f64>,
    /// Rays of one sample.
    rays: f64,
}

impl Film {
    /// Makes a film adaptive that estimates its error and holds at most sample 0 of each pixel. The first goals are 8
    /// samples per pixel.
    pub(crate) fn sample_adaptively(&mut self) {
        self.identity.adaptive = true;
        self.step = FIRST.min(self.identity.samples);
        for band in &mut self.bands {
            let tile = |held: &SampleSet| AdaptiveTile { odd: held.clone(), goals: [self.step; 2], rays: 0 };
            band.adaptive = band.held.iter().map(tile).collect();
        }
    }

    /// The samples of half of a tile. Both halves hold the same ones if the film is not adaptive.
    pub fn held_half(&self, tile: usize, half: Half) -> &SampleSet {
        let columns = self.tiles().columns();
        self.bands[tile / columns].held_half(tile % columns, half)
    }

    /// Samples per pixel that half of a tile is to have, in the finished picture or before the next decision.
    pub(crate) fn goal(&self, tile: usize, half: Half) -> u64 {
        let columns = self.tiles().columns();
        let adaptive = self.bands[tile / columns].adaptive.get(tile % columns);
        u64::from(adaptive.map_or(self.identity.samples, |a| a.goals[half as usize]))
    }

    /// One more than the largest sample index that passes may trace now: of an adaptive film the largest goal, of others
    /// the samples per pixel.
    pub(crate) fn index_goal(&self) -> u32 {
        let goals = self.bands.iter().flat_map(|band| &band.adaptive).flat_map(|tile| tile.goals);
        goals.max().unwrap_or(self.identity.samples)
    }

    /// The samples per pixel that an adaptive film is to have before the next decision, on average.
    pub fn mean_goal(&self) -> u32 {
        self.step
    }

    /// Samples per pixel, the mean over all pixels.
    pub fn mean_samples(&self) -> f64 {
        let all: u64 = self.bands.iter().map(super::band::Band::held_samples).sum();
        all as f64 / self.region.area() as f64
    }

    /// Whether all tiles of an adaptive film have the samples that they are to have, and the picture the light paths.
    pub fn has_reached_goals(&self) -> bool {
        let reached = |tile, half| self.held_half(tile, half).first_missing() >= self.goal(tile, half);
        let light = self.identity.light_paths * u64::from(self.step);
        let has_light = self.splats.as_ref().is_none_or(|splats| splats.held().first_missing() >= light);
        has_light && (0..self.tiles().count()).all(|tile| Half::BOTH.iter().all(|half| reached(tile, *half)))
    }

    /// Raises the goals of an adaptive film that has reached them. Returns false if they are those of the finished
    /// picture. With `evenly`, and with filters that reach beyond the pixel, all pixels get the same number of samples.
    pub(crate) fn allot(&mut self, evenly: bool, threads: usize) -> bool {
        let last = self.identity.samples;
        if self.step >= last {
            return false;
        }
        self.step = after(self.step).min(last);
        let goals = if evenly || self.identity.weighted {
            vec![[self.step; 2]; self.tiles().count()]
        } else {
            goals(&self.shares(threads), self.tiles().columns(), self.step)
        };
        let tiles = self.bands.iter_mut().flat_map(|band| &mut band.adaptive);
        tiles.zip(goals).for_each(|(tile, goals)| tile.goals = goals);
        true
    }

    /// The halves of all tiles.
    fn shares(&self, threads: usize) -> Vec<[Share; 2]> {
        let rows = self.tiles().rows();
        let mut out = vec![[Share::default(); 2]; self.tiles().count()];
        let (columns, dark) = (self.tiles().columns(), DARK * self.mean_luminance());
        let chunk = rows.div_ceil(threads.max(1)) * columns;
        turner_host::thread::scope(|scope| {
            for (i, shares) in out.chunks_mut(chunk).enumerate() {
                scope.spawn(move || {
                    for (k, share) in shares.iter_mut().enumerate() {
                        *share = self.share_of(i * chunk + k, dark);
                    }
                });
            }
        });
        out
    }

    /// The mean luminance of every fourth pixel of every fourth row.
    fn mean_luminance(&self) -> f64 {
        let region = &self.region;
        let (mut sum, mut count) = (0.0, 0.0);
        for y in (region.y..region.y + region.height).step_by(4) {
            for x in (region.x..region.x + region.width).step_by(4) {
                sum += self.spread(x, y).luminance.abs();
                count += 1.0;
            }
        }
        sum / count
    }

    /// The halves of a tile. Errors are relative to the pixel's luminance, at least `dark`.
    fn share_of(&self, tile: usize, dark: f64) -> [Share; 2] {
        let (rect, columns) = (self.tiles().rect(tile), self.tiles().columns());
        let (mut sums, mut areas) = ([0.0; 2], [0; 2]);
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                let (half, spread) = (Half::of(x, y) as usize, self.spread(x, y));
                areas[half] += 1;
                let luminance = spread.luminance.abs() + dark;
                sums[half] += spread.difference / (luminance * luminance.sqrt());
            }
        }
        let held = Half::BOTH.map(|half| self.held_half(tile, half).len());
        let traced: u64 = (0..2).map(|half| areas[half] * held[half].saturating_sub(1)).sum();
        let adaptive = self.bands[tile / columns].adaptive.get(tile % columns);
        let rays = adaptive.map_or(0.0, |a| a.rays as f64 / traced.max(1) as f64);
        Half::BOTH.map(|half| {
            let half = half as usize;
            let mean = (sums[half] / areas[half].max(1) as f64).sqrt();
            Share {
                area: areas[half],
                goal: adaptive.map_or(0, |a| a.goals[half]),
                deviation: (areas[half] > 0).then(|| mean * (held[half] as f64).sqrt()),
                rays,
            }
        })
    }
}

/// The next number of samples per pixel at which goals are raised: 8, 12, 16, 24, 32, ….
fn after(step: u32) -> u32 {
    let octave = 1 << step.max(FIRST).ilog2();
    if step < FIRST {
        FIRST
    } else if step < octave / 2 * 3 {
        octave / 2 * 3
    } else {
        octave.saturating_mul(2)
    }
}

/// The goals of the halves of all tiles, whose mean is at most `mean`.
fn goals(shares: &[[Share; 2]], columns: usize, mean: u32) -> Vec<[u32; 2]> {
    let rows = shares.len() / columns.max(1);
    let around = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
    let weights: Vec<[f64; 2]> = (0..shares.len())
        .map(|tile| {
            Half::BOTH.map(|half| {
                let other = half.other() as usize;
                let (mut sum, mut count) = (0.0, 0.0);
                for row in around(tile / columns, rows) {
                    for column in around(tile % columns, columns) {
                        if let Some(deviation) = shares[row * columns + column][other].deviation {
                            sum += deviation;
                            count += 1.0;
                        }
                    }
                }
                let neighbours = if count > 0.0 { sum / count } else { 0.0 };
                let own = shares[tile][other].deviation.unwrap_or(neighbours);
                let deviation = (1.0 - NEIGHBOURS) * own + NEIGHBOURS * neighbours;
                // Beyond its rays, a sample costs about as much as one ray.
                deviation / (1.0 + shares[tile][half as usize].rays).sqrt()
            })
        })
        .collect();
    let range = [f64::from(mean) / LEAST, f64::from(mean) * f64::from(MOST)];
    let goal = |share: &Share, weight: f64, scale: f64| {
        share.goal.max(rounded_down((scale * weight).clamp(range[0], range[1]) as u32))
    };
    let pairs = || shares.iter().flatten().zip(weights.iter().flatten());
    let total =
        |scale: f64| -> f64 { pairs().map(|(s, w)| s.area as f64 * f64::from(goal(s, *w, scale))).sum() };
    let area: f64 = pairs().map(|(share, _)| share.area as f64).sum();
    let largest = pairs().map(|(_, w)| *w).fold(0.0, f64::max);
    if !(largest > 0.0 && largest.is_finite()) {
        return vec![[mean; 2]; shares.len()];
    }
    // The largest scale whose goals are not more than the mean.
    let (mut low, mut high) = (range[0] / largest, range[1] / largest * 1e6);
    for _ in 0..40 {
        let middle = (low * high).sqrt();
        if total(middle) <= area * f64::from(mean) { low = middle } else { high = middle }
    }
    let of = |share: &[Share; 2], weight: &[f64; 2]| [0, 1].map(|half| goal(&share[half], weight[half], low));
    shares.iter().zip(&weights).map(|(share, weight)| of(share, weight)).collect()
}

/// Rounded down to a power of two: so many samples of an Owen-scrambled sequence are a digital net.
fn rounded_down(samples: u32) -> u32 {
    1 << samples.max(1).ilog2()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(deviation: f64) -> [Share; 2] {
        [Share { area: 128, goal: 8, deviation: Some(deviation), rays: 3.0 }; 2]
    }

    #[test]
    fn decisions_are_at_fixed_numbers() {
        let steps: Vec<u32> = std::iter::successors(Some(1), |s| Some(after(*s))).take(9).collect();
        assert_eq!(steps, [1, 8, 12, 16, 24, 32, 48, 64, 96]);
        assert_eq!([7, 8, 11, 13, 100, 128].map(rounded_down), [4, 8, 8, 8, 64, 128]);
    }

    #[test]
    fn goals_follow_the_deviation() {
        let mut shares = vec![share(0.0); 100];
        shares[44..47].fill(share(1.0));
        let found = goals(&shares, 10, 64);
        let mean = found.iter().flatten().sum::<u32>() as f64 / 200.0;
        assert!((45.0..=64.0).contains(&mean), "{mean}");
        assert_eq!(found[0], [16, 16]);
        assert!(found[45][0] > 5 * found[0][0], "{:?}", found[45]);
        // Even noise: even goals. None: too.
        assert_eq!(goals(&[share(0.3); 100], 10, 64), [[64; 2]; 100]);
        assert_eq!(goals(&[share(0.0); 100], 10, 64), [[64; 2]; 100]);
        // Goals never fall.
        shares[0][1].goal = 40;
        assert_eq!(goals(&shares, 10, 64)[0], [16, 40]);
    }

    #[test]
    fn the_other_half_decides() {
        let mut shares = vec![share(0.1); 100];
        shares[44][0].deviation = Some(5.0);
        let found = goals(&shares, 10, 64);
        assert!(found[44][1] >= 4 * found[44][0], "{:?}", found[44]);
        assert!(found[44][0] <= 64, "{:?}", found[44]);
    }
}
