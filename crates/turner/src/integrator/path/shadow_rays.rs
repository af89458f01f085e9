//! The shadow rays of a round.

use super::volume_light::ShadowRayMedia;
use crate::color::Spectrum;
use crate::math::Ray;
use crate::scene::{RayBatch, RayOrigin, SpectrumBlock};

/// The shadow rays of one round, with the radiance that each contributes to its sample if unoccluded.
#[derive(Default)]
pub(super) struct ShadowRays {
    pub(super) rays: RayBatch,
    pub(super) light: Vec<(u32, Spectrum)>,
    pub(super) through: Vec<SpectrumBlock>,
    /// In scenes with media: the media state of each ray.
    pub(super) media: Vec<ShadowRayMedia>,
}

impl ShadowRays {
    /// Adds a ray from a surface to a light.
    #[inline]
    pub(super) fn push(&mut self, ray: &Ray, [from, to]: [RayOrigin; 2], sample: u32, light: Spectrum) {
        self.rays.push_between(ray, from, to);
        self.light.push((sample, light));
    }

    /// Adds a ray from a point in a medium.
    pub(super) fn push_from_medium(
        &mut self,
        ray: &Ray,
        sample: u32,
        light: Spectrum,
        media: ShadowRayMedia,
    ) {
        self.rays.push(ray);
        self.light.push((sample, light));
        self.media.push(media);
    }

    /// Sets the media state of the next ray.
    pub(super) fn push_media(&mut self, media: ShadowRayMedia) {
        self.media.push(media);
    }
}
