//! Adding, copying and removing parts; groups; models.

use turner::description::{ModelDesc, ObjectContent, ObjectDesc, SceneDesc, SceneLight};
use turner::light::{LightDesc, PointDesc};
use turner::material::MaterialDesc;
use turner::schema::{ErrorCode, Transform};
use turner::texture::TextureDesc;

use super::{scene, with_files};

const SCENE: &str = r##"
[texture.wood]
type = "checkerboard"
even = "red"
odd = "blue"

[material.gold]
type = "metal"

[material.oak]
color = "wood"

[[object]]
type = "sphere"
name = "ball"
radius = 2
material = "gold"
transform = { translate = [1, 2, 3] }

[[object]]
type = "sphere"
material = { color = [0.25, 0.5, 0.75] }
transform = { scale = 0.3, rotate = [10, 20, 30] }

[[object]]
type = "box"
material = "oak"

[[object]]
type = "instance"
group = "pair"
material = "gold"
light_group = "key"
transform = { rotate = [0, 40, 0], translate = [0, 0.1, 0] }

[[group.pair.object]]
type = "sphere"
transform = { translate = [0.1, 0.7, 0.3] }

[[group.pair.object]]
type = "box"
material = "oak"

[[light]]
type = "point"
name = "lamp"
position = [1, 2, 3]
"##;

#[test]
fn parts_are_added_with_names_that_are_free() {
    let mut desc = scene(SCENE);
    assert_eq!(desc.add_object(ObjectDesc::default()), "object.4");
    let light = LightDesc::Point(PointDesc::default());
    assert_eq!(desc.add_light(SceneLight::from(light)), "light.1");
    assert_eq!(desc.add_material("gold", MaterialDesc::default()), "material.gold 2");
    assert_eq!(desc.add_material("a.b", MaterialDesc::default()), "material.\"a.b\"");
    assert_eq!(desc.add_texture("red", TextureDesc::default()), "texture.red 2");
    assert_eq!(desc.add_view("front", Default::default()), "view.0");
    assert_eq!(desc.add_view("front", Default::default()), "view.1");
    assert_eq!(desc.duplicate("object.0").unwrap(), "object.5");
    assert_eq!(desc.duplicate("object.5").unwrap(), "object.6");
    assert_eq!(desc.objects[6].name.as_deref(), Some("ball 3"));
    assert_eq!(desc.objects[6].span, None);
    assert_eq!(desc.objects[6].transform, desc.objects[0].transform);
    assert_eq!(desc.duplicate("light.0").unwrap(), "light.2");
    assert_eq!(desc.lights[2].name.as_deref(), Some("lamp 2"));
    assert_eq!(desc.duplicate("material.gold").unwrap(), "material.gold 3");
    assert_eq!(desc.duplicate("group.pair.object.0").unwrap(), "group.pair.object.2");
    assert_eq!(desc.duplicate("object.9").unwrap_err().code, ErrorCode::UnknownName);
}

#[test]
fn what_is_in_use_is_not_removed() {
    let mut desc = scene(SCENE);
    let before = desc.clone();
    let error = desc.remove(&["material.gold"]).unwrap_err();
    assert!(error.message.contains("\"ball\" (object.0) and by 1 other"), "{error}");
    let error = desc.remove(&["texture.wood"]).unwrap_err();
    assert!(error.message.contains("the material \"oak\""), "{error}");
    assert!(desc.remove(&["object.0", "light.7"]).is_err());
    assert_eq!(desc, before);
    desc.remove(&["object.0", "object.3", "material.gold"]).unwrap();
    assert_eq!(desc.names().materials, ["oak", "material-2"]);
    desc.remove(&["object.1", "group.pair", "texture.wood", "material.oak"]).unwrap();
    assert_eq!(
        (desc.objects.len(), desc.materials.len(), desc.textures.len(), desc.groups.len()),
        (1, 1, 0, 0)
    );
    // A material that was written in place goes with its object.
    desc.remove(&["object.0", "light.0"]).unwrap();
    assert_eq!((desc.objects.len(), desc.materials.len(), desc.lights.len()), (0, 0, 0));
    assert!(before.materials[1].value == scene(SCENE).materials[1].value);
}

/// All shapes with their places in the world, their materials and light groups.
fn placed(desc: &SceneDesc) -> Vec<String> {
    fn add(desc: &SceneDesc, outer: &ObjectDesc, object: &ObjectDesc, out: &mut Vec<String>) {
        let placed = ObjectDesc {
            transform: Transform(outer.transform.0 * object.transform.0),
            material: object.material.or(outer.material),
            light_group: object.light_group.clone().or(outer.light_group.clone()),
            ..object.clone()
        };
        match object.content {
            ObjectContent::Instance(group) => {
                let inside = &desc.groups[group.index()].value.objects;
                inside.iter().for_each(|object| add(desc, &placed, object, out));
            }
            ObjectContent::Shape(_) => {
                let place = placed.transform.0.to_cols_array().map(|v| (v + 0.0).to_bits());
                let material = placed.material.map(|m| &desc.materials[m.index()]);
                out.push(format!("{:?} {place:?} {material:?} {:?}", object.content, placed.light_group));
            }
        }
    }
    let mut all = Vec::new();
    desc.objects.iter().for_each(|object| add(desc, &ObjectDesc::default(), object, &mut all));
    all.sort();
    all
}

#[test]
fn grouping_moves_nothing() {
    let mut desc = scene(SCENE);
    let before = placed(&desc);
    assert_eq!(desc.group_objects(&["object.2", "object.0"], "pair").unwrap(), "object.2");
    assert_eq!(desc.groups[1].name.as_deref(), Some("pair 2"));
    assert_eq!((desc.objects.len(), placed(&desc)), (3, before.clone()));
    assert_eq!(desc.ungroup("object.2").unwrap(), ["object.2", "object.3"]);
    assert_eq!((desc.groups.len(), placed(&desc)), (1, before.clone()));
    let paths = desc.ungroup("object.1").unwrap();
    assert_eq!(paths, ["object.3", "object.4"]);
    assert_eq!((desc.groups.len(), placed(&desc)), (0, before));
    assert_eq!(desc.objects[3].light_group.as_deref(), Some("key"));
    assert!(desc.ungroup("object.0").is_err());
    assert!(desc.group_objects(&[], "empty").is_err());
}

#[test]
fn a_model_is_placed_and_goes_with_everything_that_it_brought() {
    let mut desc = scene(SCENE);
    let before = desc.clone();
    let model = ModelDesc { file: "Box.glb".into(), ..ModelDesc::default() };
    let path = with_files(|files| desc.add_model("crate", &model, files)).unwrap();
    assert_eq!(path, "object.4");
    let ObjectContent::Instance(group) = desc.objects[4].content else { panic!() };
    let source = desc.groups[group.index()].value.model.as_ref().unwrap();
    assert_eq!(source.file, "Box.glb");
    assert!(desc.materials.len() > before.materials.len() && desc.meshes.len() > before.meshes.len());
    let twice = with_files(|files| desc.add_model("crate", &model, files)).unwrap();
    assert_eq!(desc.objects[5].name.as_deref(), Some("crate 2"));
    desc.remove(&[&path, &twice]).unwrap();
    let imports = std::mem::take(&mut desc.imports);
    assert_eq!(imports.len(), 2);
    assert_eq!(desc.same_scene(&before), Ok(()));
    assert_eq!((desc.meshes.len(), desc.images.len()), (before.meshes.len(), before.images.len()));
    let missing = ModelDesc { file: "none.glb".into(), ..ModelDesc::default() };
    assert!(with_files(|files| desc.add_model("x", &missing, files)).is_err());
    assert_eq!(desc.same_scene(&before), Ok(()));
}
