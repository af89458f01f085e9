//! The boxes of a scene's BVHs by depth, for drawings.

use crate::math::Bounds;
use crate::scene::Scene;
use crate::shape::Shape;

impl Scene {
    /// The boxes of the BVH nodes at a depth, in world space at shutter open: those of the BVH over objects, then those of the
    /// static world mesh, then those of each mesh with its own BVH, where its objects are placed (a box that is turned is
    /// enclosed by one that is not). In each BVH, depth 0 is one box around everything and a leaf above the depth counts
    /// with its own box. A scene with a sphere culler instead of a BVH over objects has the bounds of its objects.
    ///
    /// At most `limit` boxes: where a BVH has more at the depth, those of a lower depth, and what comes after them is left
    /// out.
    pub fn bvh_boxes(&self, depth: u32, limit: usize) -> Vec<Bounds> {
        let mut out: Vec<Bounds> = Vec::new();
        if self.culler.is_some() {
            let placed =
                self.primitives.iter().filter_map(|p| Some(p.shape.bounds()?.transformed(&self.to_world(p))));
            out.extend(placed.take(self.bounded.min(limit)));
        } else {
            let boxes = self.bvh.boxes(depth, limit);
            out.extend(boxes.iter().map(|b| self.frame.bounds_of(b)));
        }
        if let Some(world_mesh) = &self.world_mesh {
            let offset = world_mesh.offset();
            let boxes = world_mesh.mesh().bvh_boxes(depth, limit - out.len());
            out.extend(boxes.iter().map(|b| Bounds::new(b.min + offset, b.max + offset)));
        }
        for primitive in &self.primitives[..] {
            if out.len() >= limit {
                break;
            }
            if let Shape::Mesh(mesh) = &primitive.shape {
                let to_world = self.to_world(primitive);
                let boxes = mesh.bvh_boxes(depth, limit - out.len());
                out.extend(boxes.iter().map(|b| b.transformed(&to_world)));
            }
        }
        out
    }
}
