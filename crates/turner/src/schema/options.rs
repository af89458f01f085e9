//! How a scene is prepared.

use turner_bvh::InstructionSet;

use super::{Limits, Quality};

/// How to prepare.
#[derive(Clone, Debug, Default)]
pub struct PrepareOptions {
    /// Threads for building trees; 0 takes all there are. The scene is the same for any number.
    pub threads: usize,
    /// How much work goes into the trees of meshes. It changes how long pictures take, not what they show.
    pub quality: Quality,
    /// What it may take.
    pub limits: Limits,
    /// What batches of rays are traced and shaded with; by default the best that this machine has. Pictures are the same with any.
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
