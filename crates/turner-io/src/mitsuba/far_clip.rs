//! The far clipping distance of sensors: Turner's cameras have none, which matters where meshes lie beyond it.

use turner::description::{ObjectContent, ObjectDesc, SceneDesc};
use turner::math::DVec3;
use turner::shape::ShapeDesc;

use crate::scene_import::report::{Place, Report};

/// Where a sensor's view ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct FarClip {
    pub(super) place: Place,
    /// The position of the camera, and the unit vector along which it looks.
    pub(super) position: DVec3,
    pub(super) forward: DVec3,
    /// In scene units along that vector.
    pub(super) distance: f64,
}

impl FarClip {
    /// Reports a vertex of a mesh beyond it. Instances and other shapes are not examined.
    pub(super) fn check(&self, scene: &SceneDesc, report: &mut Report) {
        if scene.objects.iter().any(|object| self.passes(object, scene)) {
            let message = format!(
                "far_clip is ignored: the camera also sees what is farther away than {}",
                self.distance
            );
            report.ignored(self.place, message);
        }
    }

    /// Whether a mesh has a vertex beyond it.
    fn passes(&self, object: &ObjectDesc, scene: &SceneDesc) -> bool {
        let ObjectContent::Shape(ShapeDesc::Mesh(mesh)) = &object.content else { return false };
        let Some(asset) = scene.meshes.get(mesh.mesh.index()) else { return false };
        let to_world = object.transform.0;
        let along = to_world.matrix3.transpose() * self.forward;
        let start = (to_world.translation - self.position).dot(self.forward);
        let left = self.distance - start;
        asset.data.positions.iter().any(|p| along.dot(DVec3::from(p.map(f64::from))) > left)
    }
}

#[cfg(test)]
mod tests {
    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;

    #[test]
    fn meshes_beyond_it_are_reported() {
        // A square of side 2 about z = 50, seen from z = 1 along +z; it is tilted, so that it reaches z = 51.
        let warnings = |far: &str| {
            let text = format!(
                "<scene version='3.0.0'><sensor type='perspective'>{far}<float name='fov' value='45'/>
                   <transform name='to_world'><translate value='0, 0, 1'/></transform></sensor>
                 <shape type='rectangle'><transform name='to_world'><rotate x='1' angle='90'/>
                   <translate value='0, 0, 50'/></transform></shape></scene>"
            );
            let (assets, options) = (MemoryAssets::default(), ImportOptions::default());
            let scene = super::super::import_from(text.into_bytes(), "a.xml", &assets, &options).unwrap();
            scene.warnings.iter().filter(|w| w.message.contains("far_clip")).count()
        };
        let far = |v: f64| warnings(&format!("<float name='far_clip' value='{v}'/>"));
        assert_eq!([far(40.0), far(49.9), far(50.1), far(1e4), warnings("")], [1, 1, 0, 0, 0]);
    }
}
