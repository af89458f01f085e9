//! Values of parts by key path.

use turner::schema::KeyEdit;
use turner::schema::value::{Data, Value};

use super::{all_scenes, scene, with_files, with_files_in};

const SCENE: &str = r##"
[film]
width = 64

[integrator]
type = "path"

[texture.wood]
type = "checkerboard"
even = "red"
odd = "blue"

[material.gold]
type = "metal"

[material."Material.001"]
color = "wood"

[[view]]
name = "front"
position = [0, 0, 5]

[[view]]
name = "side"
position = [5, 0, 0]

[[object]]
type = "sphere"
name = "ball"
radius = 2
material = "gold"

[[object]]
type = "sphere"
material = { color = [0.25, 0.5, 0.75] }

[[object]]
type = "mesh"
positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
triangles = [[0, 1, 2]]

[[group.tree.object]]
type = "box"

[[group.tree.object]]
type = "sphere"
radius = 0.5

[[light]]
type = "point"
position = [1, 2, 3]
"##;

#[test]
fn values_are_those_of_the_file() {
    let desc = scene(SCENE);
    let at = |path: &str| desc.value_at(path).unwrap().map(|value| value.data);
    assert_eq!(at("object.0.radius"), Some(Data::Number(2.0)));
    assert_eq!(at("object.0.material"), Some(Data::String("gold".into())));
    assert_eq!(at("object.0.center"), None, "keys at their default are absent");
    assert_eq!(at("object.1.material"), Some(Data::String("material-3".into())));
    assert!(matches!(at("material.material-3.color"), Some(Data::Array(_))));
    assert_eq!(at("material.\"Material.001\".color"), Some(Data::String("wood".into())));
    assert_eq!(at("group.tree.object.1.radius"), Some(Data::Number(0.5)));
    assert_eq!(at("view.1.name"), Some(Data::String("side".into())));
    assert_eq!(at("light.0.position.2"), Some(Data::Number(3.0)));
    assert_eq!(at("texture.wood.type"), Some(Data::String("checkerboard".into())));
    assert_eq!(at("film.width"), Some(Data::Integer(64)));
    assert_eq!(at("film.samples"), None);
    assert!(matches!(at("object.2.triangles"), Some(Data::Array(_))), "a small mesh is in the value");
    for path in [
        "object.3",
        "object.x",
        "material.silver",
        "camera",
        "film.nothing",
        "",
        "stage",
        "object.0.radius.0",
    ] {
        assert_eq!(at(path), None, "{path}");
    }
    assert_eq!(desc.names().materials, ["gold", "Material.001", "material-3"]);
}

#[test]
fn every_value_sets_the_same_scene_again() {
    for path in all_scenes() {
        let desc = turner_io::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let names = desc.names();
        let mut paths: Vec<String> = vec!["film".into(), "integrator".into(), "background".into()];
        paths.extend((0..desc.objects.len().min(20)).map(|i| format!("object.{i}")));
        paths.extend((0..desc.lights.len().min(20)).map(|i| format!("light.{i}")));
        paths.extend((0..desc.cameras.len()).map(|i| format!("view.{i}")));
        paths.extend(
            names.materials.iter().take(20).map(|n| format!("material.{}", turner::schema::path_part(n))),
        );
        paths.extend(
            names.textures.iter().take(20).map(|n| format!("texture.{}", turner::schema::path_part(n))),
        );
        paths.extend(desc.camera.is_some().then(|| "camera".to_owned()));
        paths.extend(desc.studio.is_some().then(|| "studio".to_owned()));
        let mut edited = desc.clone();
        let edits = paths.iter().map(|p| KeyEdit {
            value: Value::new(desc.value_at(p).unwrap().unwrap_or_else(|| panic!("{p}")).data),
            ..KeyEdit::new(p, Data::Bool(true))
        });
        let edits: Vec<KeyEdit> = edits.collect();
        let done = with_files_in(path.parent().unwrap(), |files| edited.edit(&edits, files));
        done.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        desc.same_apart_from_order(&edited).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let spans = |d: &turner::description::SceneDesc| d.objects.iter().map(|o| o.span).collect::<Vec<_>>();
        assert_eq!(spans(&desc), spans(&edited), "edited items keep their position");
        assert_eq!(desc.camera.as_ref().map(|c| c.span), edited.camera.as_ref().map(|c| c.span));
    }
}

#[test]
fn an_edited_item_keeps_its_position() {
    let mut desc = scene(SCENE);
    let before: Vec<_> = desc.objects.iter().map(|o| o.span).collect();
    let edits = [
        KeyEdit::new("object.0.radius", Data::Number(3.0)),
        KeyEdit::new("material.gold.roughness", Data::Number(0.5)),
        KeyEdit {
            value: desc.value_at("object.1").unwrap().unwrap(),
            ..KeyEdit::new("object.1", Data::Bool(true))
        },
    ];
    let gold = desc.materials[0].span;
    with_files(|files| desc.edit(&edits, files)).unwrap();
    assert!(before.iter().all(Option::is_some));
    assert_eq!(desc.objects.iter().map(|o| o.span).collect::<Vec<_>>(), before);
    assert_eq!((desc.materials[0].span, gold.is_some()), (gold, true));
}
