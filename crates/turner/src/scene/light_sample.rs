//! A light sample.

use crate::color::Spectrum;
use crate::light::EnvironmentSample;
use crate::math::DVec3;
use crate::scene::RayOrigin;

/// A light sample: light from one direction at a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Towards the light. For a light at a finite distance it reaches to the light, so a shadow ray ends at t = 1.
    pub to_light: DVec3,
    /// Whether the light is at a finite distance.
    pub finite: bool,
    /// Radiance; for delta lights the irradiance of a surface that faces the light.
    pub radiance: Spectrum,
    /// Pdf per solid angle, including the choice of the light; for delta lights the probability of the choice.
    pub pdf: f64,
    /// Whether rays cannot hit the light.
    pub is_delta: bool,
    /// The index of the scene's light; [`NO_LIGHT`] for an emissive shape.
    pub light: u32,
    /// The index of the primitive of an emissive shape; [`NO_LIGHT`] for a light.
    pub primitive: u32,
    /// The part of the emissive shape: a triangle of a mesh, a side of a box.
    pub part: u32,
}

/// The index of no light.
pub const NO_LIGHT: u32 = u32::MAX;

impl LightSample {
    /// From a sample of an environment.
    #[inline]
    pub(crate) fn of_environment(s: EnvironmentSample, light: u32) -> LightSample {
        LightSample {
            to_light: s.direction,
            finite: false,
            radiance: s.radiance,
            pdf: s.pdf,
            is_delta: false,
            light,
            primitive: NO_LIGHT,
            part: 0,
        }
    }

    /// What a shadow ray ends before.
    #[inline]
    pub(crate) fn target(&self) -> RayOrigin {
        RayOrigin { primitive: self.primitive, part: self.part }
    }

    /// The same sample of a light that is chosen with this probability.
    #[inline]
    pub(crate) fn chosen(self, probability: f64) -> LightSample {
        LightSample { pdf: self.pdf * probability, ..self }
    }
}
