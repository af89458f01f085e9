//! Options of scene preparation.

use turner_bvh::InstructionSet;

use super::{Limits, Quality};

/// Options of [`SceneDesc::prepare`](crate::description::SceneDesc::prepare).
#[derive(Clone, Debug, Default)]
pub struct PrepareOptions {
    /// Threads for building BVHs; 0 uses all cores. The prepared scene does not depend on it.
    pub threads: usize,
    /// The build quality of the BVHs of meshes. It changes the render time, not the picture.
    pub quality: Quality,
    /// Limits on memory and triangles.
    pub limits: Limits,
    /// The instruction set that traces and shades batches of rays; by default the best one that this machine has. The
    /// picture does not depend on it.
    pub instruction_set: InstructionSet,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{ObjectDesc, SceneDesc};
    use crate::math::DVec3;
    use crate::shape::{ShapeDesc, SphereDesc};

    #[test]
    fn the_instruction_set_asked_for_is_the_scenes_and_the_views() {
        let mut desc = SceneDesc::default();
        let ball = SphereDesc { center: DVec3::ZERO, radius: 1.0 };
        desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere(ball)));
        for set in InstructionSet::available() {
            let options = PrepareOptions { threads: 1, instruction_set: set, ..PrepareOptions::default() };
            let prepared = desc.prepare(&options).unwrap();
            assert_eq!(prepared.scene.instruction_set, set);
            assert_eq!(prepared.view.instruction_set, set);
        }
        assert_eq!(PrepareOptions::default().instruction_set, InstructionSet::best());
    }
}
