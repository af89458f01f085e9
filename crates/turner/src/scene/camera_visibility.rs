//! Objects that the camera does not see as other rays do: shadow catchers, and objects that are hidden from it.

use crate::color::Spectrum;
use crate::math::Ray;
use crate::scene::{Hit, RayBatch, Scene};

/// The most surfaces hidden from the camera that one of its rays passes.
const MAX_PASSED: u32 = 4096;

/// A set of primitives.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrimitiveSet {
    /// Ranges of primitive IDs: first, and one beyond the last; ascending.
    ranges: Vec<(u32, u32)>,
}

impl PrimitiveSet {
    /// Whether it is empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Whether a primitive is in it, by its ID.
    pub fn contains(&self, primitive: u32) -> bool {
        let behind = self.ranges.partition_point(|(first, _)| *first <= primitive);
        behind.checked_sub(1).and_then(|i| self.ranges.get(i)).is_some_and(|(_, end)| primitive < *end)
    }

    /// Adds a primitive that is behind all others.
    pub(crate) fn add(&mut self, primitive: u32) {
        match self.ranges.last_mut() {
            Some((_, end)) if *end == primitive => *end += 1,
            _ => self.ranges.push((primitive, primitive + 1)),
        }
    }
}

impl Scene {
    /// Whether a hit is on a shadow catcher.
    #[inline]
    pub fn is_shadow_catcher(&self, hit: &Hit) -> bool {
        !self.shadow_catchers.is_empty() && self.shadow_catchers.contains(self.primitive_id(hit))
    }

    /// Whether a hit is on an object that is hidden from the camera.
    #[inline]
    pub fn is_hidden_from_camera(&self, hit: &Hit) -> bool {
        !self.hidden_from_camera.is_empty() && self.hidden_from_camera.contains(self.primitive_id(hit))
    }

    /// The nearest hit of a ray from the camera.
    pub fn intersect_from_camera(&self, ray: &Ray) -> Option<Hit> {
        self.seen_by_camera(ray, self.intersect(ray))
    }

    /// What a ray from the camera sees, whose nearest hit is `hit`: the first hit behind objects that are hidden from the
    /// camera.
    #[inline]
    pub fn seen_by_camera(&self, ray: &Ray, hit: Option<Hit>) -> Option<Hit> {
        match hit {
            Some(hit) if self.is_hidden_from_camera(&hit) => self.behind_hidden(ray, hit),
            hit => hit,
        }
    }

    #[cold]
    fn behind_hidden(&self, ray: &Ray, mut hit: Hit) -> Option<Hit> {
        let mut ray = *ray;
        for _ in 0..MAX_PASSED {
            ray.t_min = self.beyond(&ray, &hit, &self.surface(&ray, &hit));
            hit = self.intersect(&ray)?;
            if !self.is_hidden_from_camera(&hit) {
                return Some(hit);
            }
        }
        None
    }

    /// Transmittance between a surface and the camera, which objects that are hidden from it do not reduce.
    pub(crate) fn transmittance_to_camera(&self, ray: &Ray) -> Spectrum {
        let mut ray = *ray;
        let mut through = Spectrum::WHITE;
        for _ in 0..MAX_PASSED {
            let Some(hit) = self.intersect(&ray) else { return through };
            let beyond = self.beyond(&ray, &hit, &self.surface(&ray, &hit));
            if !self.is_hidden_from_camera(&hit) {
                // The tint of this surface alone.
                through = through * self.transmittance(&Ray { t_max: beyond, ..ray });
            }
            if through.is_black() {
                return through;
            }
            ray.t_min = beyond;
        }
        Spectrum::BLACK
    }

    /// Replaces the hits of rays from the camera by what these see.
    pub fn look_past_hidden(&self, rays: &RayBatch, hits: &mut [Option<Hit>]) {
        if self.hidden_from_camera.is_empty() {
            return;
        }
        for (i, hit) in hits.iter_mut().enumerate() {
            if let Some(ray) = rays.get(i) {
                *hit = self.seen_by_camera(&ray, *hit);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_primitives_are_one_range() {
        let mut catchers = PrimitiveSet::default();
        assert!(catchers.is_empty() && !catchers.contains(0));
        [2, 3, 4, 9].into_iter().for_each(|id| catchers.add(id));
        assert_eq!(catchers.ranges, [(2, 5), (9, 10)]);
        assert_eq!((0..12).filter(|id| catchers.contains(*id)).collect::<Vec<_>>(), [2, 3, 4, 9]);
    }
}
