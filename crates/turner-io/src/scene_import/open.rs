//! The medium that surrounds the camera.

use turner::description::{ObjectContent, ObjectDesc, SceneDesc};
use turner::material::{InterfaceMaterial, MaterialDesc};
use turner::medium::MediumDesc;
use turner::schema::{MaterialId, MediumId, Named, Transform};
use turner::shape::{BoxDesc, ShapeDesc};

/// Adds the medium around the camera, which no shape of the finished scene encloses. A homogeneous medium
/// becomes that of the background. A grid ends at its bounding box, which becomes an object with an interface
/// material.
pub(crate) fn fill_open(scene: &mut SceneDesc, around: Option<MediumId>) {
    let Some(id) = around else { return };
    let Some(MediumDesc::Grid(grid)) = scene.media.get(id.index()).map(|m| &m.value) else {
        scene.background.medium = around;
        return;
    };
    let [min, max] = grid.bounds();
    let shape = BoxDesc { min: Some(min), max: Some(max), center: None, size: None };
    let material = MaterialDesc::Interface(InterfaceMaterial { interior: around });
    let material_id = MaterialId(scene.materials.len() as u32);
    scene.materials.push(Named { name: None, span: None, value: material });
    scene.objects.push(ObjectDesc {
        name: None,
        span: None,
        content: ObjectContent::Shape(ShapeDesc::Box(shape)),
        material: Some(material_id),
        light_group: None,
        shadow_catcher: false,
        hidden_from_camera: false,
        hidden: false,
        transform: Transform::IDENTITY,
        motion: None,
    });
}
