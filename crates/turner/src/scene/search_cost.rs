//! Counts of the work that a ray's intersection search needs.

use crate::math::{DVec3, Ray};
use crate::scene::scene::{Bits, NO_TRANSFORM};
use crate::scene::{Hit, Scene};
use crate::shape::Shape;

/// The work of one ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SearchCost {
    /// BVH nodes whose boxes it enters.
    pub boxes: u64,
    /// Shapes and blocks of eight triangles to test.
    pub tests: u64,
}

impl Scene {
    /// The work of a ray up to its `t_max`: the minimum for a search that visits nearer objects first. It depends on
    /// the BVHs, which are the same for any number of threads, and not on the traversal.
    pub fn search_cost(&self, ray: &Ray) -> SearchCost {
        let mut cost = SearchCost::default();
        if let Some(world_mesh) = &self.world_mesh {
            cost.add(world_mesh.mesh().search_steps(&world_mesh.ray(ray)));
        }
        for i in self.bounded..self.gathered {
            self.add_primitive(i as u32, ray, &mut cost);
        }
        let Some(search) = self.frame.ray(ray) else { return cost };
        if let Some(culler) = &self.culler {
            Bits(culler.candidates(&search.ray)).for_each(|i| self.add_primitive(i, ray, &mut cost));
        } else {
            let nodes = self.bvh.steps(&search.ray, |leaf| {
                leaf.into_iter().for_each(|i| self.add_primitive(i, ray, &mut cost));
            });
            cost.boxes += nodes;
        }
        cost
    }

    /// Estimated number of shapes, blocks of eight triangles and points to test against a ray up to its `t_max`:
    /// those whose boxes it enters. Meshes and point clouds count with their mean, which does not depend on the
    /// quality of their BVHs; the scene's own BVH is always built in the same way.
    pub(crate) fn ray_tests(&self, ray: &Ray) -> f64 {
        let of = |i: u32| self.primitives.get(i as usize).map_or(0.0, |p| p.shape.tests_per_ray());
        let mut tests = self.world_mesh.as_ref().map_or(0.0, |world_mesh| world_mesh.mesh().tests_per_ray());
        tests += (self.bounded..self.gathered).map(|i| of(i as u32)).sum::<f64>();
        let Some(search) = self.frame.ray(ray) else { return tests };
        if let Some(culler) = &self.culler {
            Bits(culler.candidates(&search.ray)).for_each(|i| tests += of(i));
        } else {
            self.bvh.steps(&search.ray, |leaf| tests += leaf.map(of).sum::<f64>());
        }
        tests
    }

    fn add_primitive(&self, index: u32, ray: &Ray, cost: &mut SearchCost) {
        let Some(primitive) = self.primitives.get(index as usize) else { return };
        match &primitive.shape {
            Shape::Mesh(mesh) if primitive.transform == NO_TRANSFORM => cost.add(mesh.search_steps(ray)),
            Shape::Mesh(mesh) => {
                cost.add(
                    mesh.search_steps(&self.transforms[primitive.transform as usize].ray_to_object(ray)),
                );
            }
            _ => cost.tests += 1,
        }
    }

    /// The world-space corners of the triangle that was hit; `None` for other shapes.
    pub fn triangle_at(&self, hit: &Hit) -> Option<[DVec3; 3]> {
        let primitive = self.primitives.get(hit.primitive as usize)?;
        let Shape::Mesh(mesh) = &primitive.shape else { return None };
        Some(self.corners(hit.primitive, mesh, hit.shape.part)?.0)
    }

    /// Whether the hit is on an unbounded shape (a plane).
    pub fn is_unbounded(&self, hit: &Hit) -> bool {
        matches!(self.primitives.get(hit.primitive as usize).map(|p| &p.shape), Some(Shape::Plane(_)))
    }
}

impl SearchCost {
    fn add(&mut self, steps: turner_bvh::Steps) {
        self.boxes += steps.nodes;
        self.tests += steps.blocks;
    }
}
