//! Surfaces that coincide with the boundary of a medium: a box of fog that stands on a floor or fills a room.
//!
//! ```text
//!   \   fog
//!    \               The ray reaches both at the same distance, but for rounding. It must meet the floor, still in
//!  ===x=========     the fog: behind the boundary it would start below the floor.
//!   floor, and boundary of the fog
//! ```
//!
//! Of equally near hits, one on an opaque surface comes before one on a boundary ([`Scene::keep_nearer_before`]). Hits that
//! differ by rounding are compared here.

use super::ray_batch::RayBatch;
use crate::interaction::Hit;
use crate::material::ShadowKind;
use crate::math::Ray;
use crate::scene::Scene;

/// Maximum number of hits compared at one place.
const MAX_COMPARED: usize = 8;

impl Scene {
    /// Where an opaque surface coincides with the boundary of a medium that a ray hits, replaces the hit by that on the surface.
    pub(crate) fn prefer_surfaces(&self, rays: &RayBatch, hits: &mut [Option<Hit>]) {
        if !self.volumes.as_ref().is_some_and(|volumes| volumes.bounded) {
            return;
        }
        for (i, hit) in hits.iter_mut().enumerate() {
            if let Some(boundary) = hit.filter(|hit| self.material_at(hit).is_boundary())
                && let Some(ray) = rays.get(i)
                && let Some(surface) = self.opaque_at(&ray, &boundary)
            {
                *hit = Some(surface);
            }
        }
    }

    /// The hit on an opaque surface at a boundary, if there is one within the errors of both.
    fn opaque_at(&self, ray: &Ray, boundary: &Hit) -> Option<Hit> {
        let end = self.beyond(ray, boundary, &self.surface(ray, boundary));
        let mut near = Ray { t_max: ray.t_max.min(end), ..*ray };
        let mut last = *boundary;
        for _ in 0..MAX_COMPARED {
            near.t_min = last.shape.t.next_up();
            last = self.intersect(&near)?;
            let material = self.material_at(&last);
            if !material.is_boundary() && matches!(material.shadow(), ShadowKind::Opaque) {
                return Some(last);
            }
        }
        None
    }
}
