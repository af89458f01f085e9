//! Many rays at once, for the meshes of a scene.

use super::faces::NO_FACES;
use super::scene::{Hit, NO_TRANSFORM, Scene};
use crate::math::Ray;
use crate::shape::{Shape, ShapeHit};

/// A tree above more primitives than this is searched ray by ray.
const MAX_PRIMITIVES: usize = 64;

impl Scene {
    /// The nearest hit of each ray: what [`Scene::intersect`] finds, bit for bit. In scenes of few objects, rays go through
    /// each mesh together, which takes less time than one by one.
    pub fn intersect_rays(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len());
        let is_mesh = |i: usize| {
            let primitive = &self.primitives[i];
            primitive.faces == NO_FACES && matches!(primitive.shape, Shape::Mesh(_))
        };
        if self.primitives.len() > MAX_PRIMITIVES || !(0..self.primitives.len()).any(is_mesh) {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.intersect(ray);
            }
            return;
        }
        hits.fill(None);
        // As far as the nearest hit so far.
        let mut left: Vec<Ray> = rays.to_vec();
        for i in (0..self.primitives.len()).filter(|i| !is_mesh(*i)) {
            for (ray, hit) in left.iter_mut().zip(hits.iter_mut()) {
                self.try_primitive(i as u32, ray, hit);
            }
        }
        let mut found: Vec<Option<ShapeHit>> = vec![None; rays.len()];
        let mut moved: Vec<Ray> = Vec::new();
        for (i, primitive) in self.primitives.iter().enumerate() {
            let Shape::Mesh(mesh) = &primitive.shape else { continue };
            if !is_mesh(i) {
                continue;
            }
            if primitive.transform == NO_TRANSFORM {
                mesh.intersect_batch(&left, &mut found);
            } else {
                let to_object = &self.transforms[primitive.transform as usize].to_object;
                moved.clear();
                moved.extend(left.iter().map(|ray| ray.transformed(to_object)));
                mesh.intersect_batch(&moved, &mut found);
            }
            for ((ray, hit), found) in left.iter_mut().zip(hits.iter_mut()).zip(&found) {
                if let Some(found) = found {
                    self.keep_nearer(i as u32, *found, ray, hit);
                }
            }
        }
    }
}
