//! Rays that wait to be traced.

use crate::math::{DVec3, Ray};
use crate::scene::{RayBatch, RayOrigin, SurfaceInteraction};

/// The rays of one round, and the sample of each.
#[derive(Default)]
pub(super) struct RayQueue {
    pub(super) rays: RayBatch,
    pub(super) samples: Vec<u32>,
}

impl RayQueue {
    /// Removes all rays.
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.samples.clear();
    }

    /// Adds a ray that leaves a surface.
    pub(super) fn push(&mut self, sample: u32, from: &SurfaceInteraction, direction: DVec3) {
        self.rays.push_from(&Ray::new(from.leave(direction), direction), from);
        self.samples.push(sample);
    }

    /// Adds a ray with its origin already offset.
    #[inline]
    pub(super) fn push_ray(&mut self, sample: u32, ray: &Ray, from: RayOrigin) {
        self.rays.push_leaving(ray, from);
        self.samples.push(sample);
    }

    /// Adds a ray that leaves a point in a medium.
    pub(super) fn push_from_medium(&mut self, sample: u32, from: DVec3, direction: DVec3) {
        self.rays.push(&Ray::new(from, direction));
        self.samples.push(sample);
    }

    /// A ray and its sample.
    pub(super) fn get(&self, i: usize) -> Option<(Ray, u32)> {
        self.rays.get(i).zip(self.samples.get(i).copied())
    }

    /// Removes a ray.
    pub(super) fn remove(&mut self, i: usize) {
        self.rays.remove(i);
    }
}
