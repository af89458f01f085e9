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
use crate::light::{NO_CELL, Receiver};
use crate::material::{Gloss, GlossyLobe, Material};
use crate::math::DVec3;
use crate::scene::{LightBatch, SurfaceInteraction};

/// How a surface faces a ray: its normals, the direction of the ray, and the gloss of the material.
pub(super) struct Facing {
    pub(super) gloss: Option<Gloss>,
    pub(super) ng: DVec3,
    pub(super) ns: DVec3,
    pub(super) direction: DVec3,
}

/// No light is requested.
pub(super) const NONE: u32 = u32::MAX;

/// Number of candidates, M.
pub(super) const CANDIDATES: usize = 8;

/// Sets of random numbers from here on are for candidates, one per vertex.
const CANDIDATE_SETS: u32 = 1 << 31;

/// A lobe whose peak is at least this multiple of the diffuse reflection counts as glossy.
const PEAK: f32 = 100.0;

impl<R: Record> PathBatch<'_, R> {
    /// Whether a light is sampled at a receiver. Under a uniform sky only where its directions are cosine-weighted.
    #[inline]
    pub(super) fn samples_light(&self, at: &Receiver) -> bool {
        self.settings.light_sampling != LightSampling::Bsdf
            && (!self.settings.by_cosine || at.cosine_normal().is_some())
    }

    /// The density with which the light samples of a path's last vertex have a direction. `light_pdf` is that of one sample by
    /// luminance.
    #[inline]
    pub(super) fn pdf_of_samples(&self, path: &Path, direction: DVec3, light_pdf: f64) -> f64 {
        let one = if self.settings.by_cosine { path.origin.cosine_pdf(direction) } else { light_pdf };
        one * path.origin.candidates()
    }

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
        let (ng, ns) = (surface.ng, surface.ns);
        let gloss = match self.scene.material_at(&surface.hit) {
            Material::OpenPbr(m) => m.side(),
            _ => None,
        };
        self.of_vertex(
            sample,
            number,
            self.scene.receiver_of(gloss, surface.p, ng, ns, direction),
            Facing { gloss, ng, ns, direction },
        )
    }

    /// Completes the receiver at the `number`th vertex of a path: the normal for cosine-weighted directions to a uniform
    /// environment, or the cell of the adaptive environment if it has none yet.
    #[inline]
    pub(super) fn of_vertex(&self, sample: u32, number: u32, at: Receiver, facing: Facing) -> Receiver {
        if self.settings.by_cosine {
            let Facing { gloss, ng, ns, direction } = facing;
            let first = !self.paths[sample as usize].any_nonspecular;
            let is_metal = gloss.is_some_and(|gloss| gloss.hides_base());
            return if first && !is_metal { at.by_cosine(-ns * ng.dot(direction).signum()) } else { at };
        }
        let at = match self.adaptive {
            Some(adaptive) if at.cell == NO_CELL => at.in_cell(adaptive.cell(at.p)),
            _ => at,
        };
        // Lights that are sampled for several first vertices must not depend on one of them.
        if self.is_second(sample, number) { at.with_lobe(GlossyLobe::default()) } else { at }
    }

    /// Requests light samples for a vertex; returns the index of the request, or [`NONE`].
    #[inline]
    pub(super) fn request_light(&self, path: &Path, at: Receiver, lights: &mut LightBatch) -> u32 {
        if !self.samples_light(&at) {
            return NONE;
        }
        let at = at.at_time(path.time);
        let index = if at.extra_candidates == 0 {
            let [u0, u1, u2, _] = path.numbers.first();
            lights.ask(at, [u0, u1, u2])
        } else {
            lights.ask_for_candidates(at, &path.sampler, CANDIDATE_SETS + path.vertex)
        };
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
