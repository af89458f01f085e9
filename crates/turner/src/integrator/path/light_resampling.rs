//! Several lights that are looked at where a surface reflects one direction more than others, of which one is followed: resampled importance
//! sampling (Talbot, Cline and Egbert 2005, "Importance Resampling for Global Illumination").
//!
//! Lights are chosen by what they may bring and their places without regard to the BSDF; of [`CANDIDATES`] of them one is taken in
//! proportion to what it brings unshadowed, which follows the product of light and BSDF, for one shadow ray. Their density is that of all
//! together, [`CANDIDATES`] times that of one, and so is the weight against lights that rays find by chance. Only at the first surface, where
//! the rays of the camera are dearer than candidates.

use super::LightSampling;
use super::path_batch::{Path, PathBatch};
use super::record::Record;
use crate::light::Receiver;
use crate::scene::LightBatch;

/// How many lights are looked at.
pub(super) const CANDIDATES: usize = 8;

/// The sets of random numbers from here on are theirs, one for each vertex.
const SETS: u32 = 1 << 31;

/// Lobes from so many times the rest of the surface's reflection on.
const PEAK: f32 = 100.0;

impl<R: Record> PathBatch<'_, R> {
    /// How many more lights than one are looked at where a path has arrived.
    #[inline]
    pub(super) fn more_lights(&self, path: &Path, at: &Receiver) -> u32 {
        let glossy = at.lobe.peak >= PEAK;
        let first = path.bounces.total == 0;
        let specular_bounce = self.strategy.is_none() && self.settings.light_sampling != LightSampling::Bsdf;
        if glossy && first && specular_bounce { CANDIDATES as u32 - 1 } else { 0 }
    }

    /// Asks for light where a path has arrived; gives the number under which there is an answer.
    #[inline]
    pub(super) fn ask(&self, path: &Path, at: Receiver, lights: &mut LightBatch) -> u32 {
        let number = lights.ask(at, |candidate| {
            let [u0, u1, u2, _] = match at.extra_candidates {
                0 => path.numbers.first(),
                extra_candidates => {
                    path.sampler.part(candidate, extra_candidates + 1).four(SETS + path.vertex)
                }
            };
            [u0, u1, u2]
        });
        number as u32
    }
}

/// Which of several lights a number takes, by the luminance that each brings, and how many times that counts; `None` where none brings any.
pub(super) fn pick(brought: &[f32], u: f64) -> Option<(usize, f32)> {
    let sum: f64 = brought.iter().map(|b| f64::from(*b)).sum();
    if !sum.is_finite() {
        // Counted as what it is.
        return brought.iter().position(|b| !b.is_finite()).map(|i| (i, 1.0));
    }
    let target = u * sum;
    let mut passed = 0.0;
    let mut taken = None;
    for (i, b) in brought.iter().enumerate().filter(|(_, b)| **b > 0.0) {
        // The last that is not 0, should rounding leave the target beyond them.
        if taken.is_none() || target >= passed {
            taken = Some((i, (sum / f64::from(*b)) as f32));
        }
        passed += f64::from(*b);
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_kept() {
        let brought = [0.5, 0.0, 2.0, 1.5f32];
        let mut sums = [0.0; 4];
        let n = 1 << 14;
        for i in 0..n {
            let u = (f64::from(i) + 0.5) / f64::from(n);
            let (taken, counts) = pick(&brought, u).unwrap();
            sums[taken] += f64::from(brought[taken] * counts) / f64::from(n);
        }
        for (sum, b) in sums.iter().zip(brought) {
            assert!((sum - f64::from(b)).abs() < 1e-3, "{sums:?}");
        }
    }

    #[test]
    fn nothing_and_too_much() {
        assert_eq!(pick(&[0.0; 4], 0.3), None);
        assert_eq!(pick(&[], 0.3), None);
        assert_eq!(pick(&[1.0, f32::INFINITY, 0.0], 0.3), Some((1, 1.0)));
        assert_eq!(pick(&[1.0, 0.0, f32::NAN], 0.3), Some((2, 1.0)));
        assert_eq!(pick(&[0.0, 1e-40, 0.0], 0.999), Some((1, 1.0)));
    }
}
