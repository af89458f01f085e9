//! Copy and paste.

use turner_io::edit::{copy, paste};

use super::{all_scenes, scene, with_files};

const SCENE: &str = r##"
[texture.wood]
type = "checkerboard"
even = "red"
odd = "blue"

[material.oak]
color = "wood"

[[group.pair.object]]
type = "sphere"
material = "oak"

[[object]]
type = "sphere"
name = "ball"
radius = 2
material = "oak"

[[object]]
type = "instance"
group = "pair"

[[light]]
type = "point"
name = "lamp"
position = [1, 2, 3]
"##;

fn pasted(into: &mut turner::description::SceneDesc, text: &str) -> Vec<String> {
    with_files(|files| paste(into, text, files)).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

#[test]
fn parts_are_copied_with_what_they_refer_to() {
    let desc = scene(SCENE);
    let text = copy(&desc, &["object.0".into(), "light.0".into()]).unwrap();
    for part in ["[texture.wood]", "[material.oak]", "[[object]]", "name = \"ball\"", "[[light]]"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains("group"), "{text}");
    // In an empty scene everything is new.
    let mut empty = turner::description::SceneDesc::default();
    let paths = pasted(&mut empty, &text);
    assert_eq!(paths, ["texture.wood", "material.oak", "object.0", "light.0"]);
    assert_eq!(
        empty.value_at("object.0").unwrap().unwrap().data,
        scene(&text).value_at("object.0").unwrap().unwrap().data
    );
    // In the same scene the material is the one it has.
    let mut same = desc.clone();
    assert_eq!(pasted(&mut same, &text), ["object.2", "light.1"]);
    assert_eq!(same.objects[2].material, desc.objects[0].material);
    assert_eq!(same.objects[2].name.as_deref(), Some("ball 2"));
}

#[test]
fn other_parts_of_the_same_name_get_a_number() {
    let mut desc = scene(&SCENE.replace("even = \"red\"", "even = \"green\""));
    let text = copy(&scene(SCENE), &["object.1".into()]).unwrap();
    let paths = pasted(&mut desc, &text);
    assert_eq!(paths, ["texture.wood 2", "material.oak 2", "group.pair 2", "object.2"]);
    let color = desc.value_at("material.oak 2.color").unwrap().unwrap().data;
    assert_eq!(color, turner::schema::value::Data::String("wood 2".into()));
    let inside = desc.value_at("group.pair 2.object.0.material").unwrap().unwrap().data;
    assert_eq!(inside, turner::schema::value::Data::String("oak 2".into()));
}

#[test]
fn an_error_has_its_place_in_the_text() {
    let mut desc = scene(SCENE);
    let before = desc.clone();
    for (text, place) in [
        ("[[object]]\ntype = \"sphere\"\n  radus = 1\n", "line 3, column 3:"),
        ("[[object]\n", "line 1, column"),
        ("[[object]]\ntype = \"sphere\"\nmaterial = \"none\"", "line 3, column 12:"),
    ] {
        let error = with_files(|files| paste(&mut desc, text, files)).unwrap_err();
        assert!(error.message.starts_with(place), "{error}");
        assert_eq!(desc, before);
    }
    assert!(copy(&desc, &["object.7".into()]).is_err());
}

#[test]
fn every_object_of_every_scene_can_be_copied() {
    for path in all_scenes() {
        let desc = turner_io::load(&path).unwrap();
        let paths: Vec<String> = (0..desc.objects.len().min(30)).map(|i| format!("object.{i}")).collect();
        let text = copy(&desc, &paths).unwrap();
        let mut twice = desc.clone();
        let folder = turner_io::assets::FolderAssets::new(path.parent().unwrap()).unwrap();
        let sources = turner_io::scene::Sources::default();
        let mut files = turner_io::scene::SceneFiles::new(&folder, &sources);
        let added = paste(&mut twice, &text, &mut files)
            .unwrap_or_else(|e| panic!("{}: {e}\n{text}", path.display()));
        let objects = added.iter().filter(|path| path.starts_with("object.")).count();
        assert_eq!(objects, paths.len(), "{}", path.display());
        for (i, path) in paths.iter().enumerate() {
            let new = &twice.objects[desc.objects.len() + i];
            assert_eq!(new.transform, desc.objects[i].transform, "{path}");
        }
    }
}
