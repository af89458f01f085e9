//! Scattering functions that are not made of OpenPBR's layers.

use super::disney::Disney;
use super::hair::Hair;
use super::measured::Measured;
use super::{BsdfSample, Rgb};
use crate::math::DVec3;

/// One of them, instead of all layers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Unlayered<'m> {
    /// A hair.
    Hair(Hair),
    /// Disney's principled BSDF.
    Disney(Disney),
    /// A measured BRDF.
    Measured(&'m Measured),
}

impl Unlayered<'_> {
    /// f and pdf; `wo` is above the surface, and `wi` not along it.
    #[inline]
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        match self {
            Unlayered::Hair(hair) => hair.eval(wo, wi),
            Unlayered::Disney(disney) => disney.eval(wo, wi),
            Unlayered::Measured(tables) => tables.eval(wo, wi),
        }
    }

    /// Samples a direction; `u` as for [`Bsdf::sample`](super::Bsdf::sample).
    #[inline]
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        match self {
            Unlayered::Hair(hair) => hair.sample(wo, u),
            Unlayered::Disney(disney) => disney.sample(wo, u),
            Unlayered::Measured(tables) => tables.sample(wo, u),
        }
    }

    /// Roughness: 0 is a mirror, 1 is diffuse.
    pub(super) fn roughness(&self) -> f64 {
        match self {
            Unlayered::Hair(hair) => hair.roughness(),
            Unlayered::Disney(disney) => disney.roughness(),
            Unlayered::Measured(tables) => tables.roughness(),
        }
    }

    /// Approximate fraction of light from straight above that is scattered.
    pub(super) fn albedo(&self) -> Rgb {
        match self {
            Unlayered::Hair(hair) => hair.albedo(),
            Unlayered::Disney(disney) => disney.albedo(),
            Unlayered::Measured(tables) => tables.albedo(),
        }
    }

    /// Whether it can be evaluated from any wo on its side: that of a hair depends on where the ray hit it.
    pub(super) fn is_for_any_wo(&self) -> bool {
        match self {
            Unlayered::Hair(_) => false,
            Unlayered::Disney(_) | Unlayered::Measured(_) => true,
        }
    }
}
