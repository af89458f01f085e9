//! Resampled importance sampling (RIS) of lights on glossy surfaces (Talbot, Cline and Egbert 2005, "Importance
//! Resampling for Global Illumination").
//!
//! Light sampling follows the power and the position of lights, not the BSDF, so on a glossy surface most samples fall
//! outside the lobe. RIS draws M = [`CANDIDATES`] light samples x_1 … x_M from the density p, evaluates the unshadowed
//! contribution w_i = f·|cos|·Le / (M·p(x_i)) of each (its luminance), and keeps sample i with probability w_i /
//! sum(w). The kept contribution is multiplied by
//!
//! ```text
//!  resampling weight = (w_1 + … + w_M) / w_i
//! ```
//!
//! so that the expectation over the choice is w_1 + … + w_M, the mean of M separate estimates: unbiased for any M. The
//! kept sample follows the product of light and BSDF, at the cost of one shadow ray and M light samples. MIS against
//! BSDF-sampled rays uses the density M·p. Used only at the first surface that is not specular, where the camera rays that
//! lead there cost more than candidates.
//!
//! At surfaces that are not glossy there is no resampling. Each of the M light samples gets a shadow ray, and their
//! contributions are added: w_1 + … + w_M. [`light_samples`](super::light_samples) chooses M.

use super::LightSampling;
use super::path_batch::{Path, PathBatch};
use super::record::Record;
use crate::light::Receiver;
use crate::material::GlossyLobe;
use crate::math::DVec3;
use crate::scene::{LightBatch, SurfaceInteraction};

/// Number of candidates, M.
pub(super) const CANDIDATES: usize = 8;

/// Sets of random numbers from here on are for candidates, one per vertex.
const CANDIDATE_SETS: u32 = 1 << 31;

/// A lobe whose peak is at least this multiple of the diffuse reflection counts as glossy.
const PEAK: f32 = 100.0;

impl<R: Record> PathBatch<'_, R> {
    /// Number of light samples beyond the first at a vertex: candidates if it [resamples].
    #[inline]
    pub(super) fn extra_light_samples(&self, path: &Path, at: &Receiver) -> u32 {
        // Light paths and later vertices know one sample.
        let is_one = path.any_nonspecular
            || self.strategy.is_some()
            || self.settings.light_sampling == LightSampling::Bsdf;
        match is_one {
            true => 0,
            false if is_glossy(at) => CANDIDATES as u32 - 1,
            false => self.settings.light_samples - 1,
        }
    }

    /// The receiver at the `number`th vertex of a path, hit by a ray of this direction.
    #[inline]
    pub(super) fn receiver(
        &self,
        sample: u32,
        number: u32,
        surface: &SurfaceInteraction,
        direction: DVec3,
    ) -> Receiver {
        self.of_vertex(sample, number, self.scene.receiver(surface, direction))
    }

    /// Completes the receiver at the `number`th vertex of a path by its cell of the adaptive environment.
    #[inline]
    pub(super) fn of_vertex(&self, sample: u32, number: u32, at: Receiver) -> Receiver {
        let at = match self.adaptive {
            Some(adaptive) => at.in_cell(adaptive.cell(at.p)),
            None => at,
        };
        // Lights that are sampled for several first vertices must not depend on one of them.
        if self.is_second(sample, number) { at.with_lobe(GlossyLobe::default()) } else { at }
    }

    /// Requests light samples for a vertex; returns the index of the request.
    #[inline]
    pub(super) fn request_light(&self, path: &Path, at: Receiver, lights: &mut LightBatch) -> u32 {
        let index = lights.ask(at.at_time(path.time), |candidate| {
            let [u0, u1, u2, _] = match at.extra_candidates {
                0 => path.numbers.first(),
                extra_candidates => {
                    path.sampler.part(candidate, extra_candidates + 1).four(CANDIDATE_SETS + path.vertex)
                }
            };
            [u0, u1, u2]
        });
        index as u32
    }
}

#[inline]
fn is_glossy(at: &Receiver) -> bool {
    at.lobe.peak >= PEAK
}

/// Whether one of the light samples at a receiver is chosen, instead of taking all.
#[inline]
pub(super) fn resamples(at: &Receiver) -> bool {
    at.extra_candidates > 0 && is_glossy(at)
}

/// Chooses a candidate by its luminance; returns its index and its resampling weight, or `None` if all contributions
/// are 0.
pub(super) fn resample(contributions: &[f32], u: f64) -> Option<(usize, f32)> {
    let sum: f64 = contributions.iter().map(|b| f64::from(*b)).sum();
    if !sum.is_finite() {
        // A non-finite contribution is kept, to be counted as such.
        return contributions.iter().position(|b| !b.is_finite()).map(|i| (i, 1.0));
    }
    let target = u * sum;
    let mut sum_before = 0.0;
    let mut chosen = None;
    for (i, b) in contributions.iter().enumerate().filter(|(_, b)| **b > 0.0) {
        // Rounding may leave the target beyond the last non-zero candidate, which is then taken.
        if chosen.is_none() || target >= sum_before {
            chosen = Some((i, (sum / f64::from(*b)) as f32));
        }
        sum_before += f64::from(*b);
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_kept() {
        let contributions = [0.5, 0.0, 2.0, 1.5f32];
        let mut sums = [0.0; 4];
        let n = 1 << 14;
        for i in 0..n {
            let u = (f64::from(i) + 0.5) / f64::from(n);
            let (chosen, weight) = resample(&contributions, u).unwrap();
            sums[chosen] += f64::from(contributions[chosen] * weight) / f64::from(n);
        }
        for (sum, b) in sums.iter().zip(contributions) {
            assert!((sum - f64::from(b)).abs() < 1e-3, "{sums:?}");
        }
    }

    #[test]
    fn zero_and_non_finite_contributions() {
        assert_eq!(resample(&[0.0; 4], 0.3), None);
        assert_eq!(resample(&[], 0.3), None);
        assert_eq!(resample(&[1.0, f32::INFINITY, 0.0], 0.3), Some((1, 1.0)));
        assert_eq!(resample(&[1.0, 0.0, f32::NAN], 0.3), Some((2, 1.0)));
        assert_eq!(resample(&[0.0, 1e-40, 0.0], 0.999), Some((1, 1.0)));
    }
}
