//! New names: references follow in the file, and its comments stay.

use std::fs;

use turner_io::edit::{Opened, save_scene};
use turner_io::scene::LoadOptions;

const TEXT: &str = r#"# A still life.
[film]
width = 32
height = 24

[texture.squares]       # the floor
type = "checkerboard"

# The precious one.
[material.gold]
color = "gold"          # of course

[material.tiles]
color = "squares"

[medium.haze]
type = "homogeneous"

[[view]]
name = "from above"
type = "pinhole"
position = [0, 8, 0.1]
look_at = [0, 0, 0]

[[object]]
type = "sphere"
name = "ball"           # in the middle
material = "gold"

[[object]]
type = "plane"
material = "tiles"

[[object]]
type = "box"
material = { color = "red" }   # no name
"#;

#[test]
fn a_renamed_part_keeps_its_comments_and_its_references() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    fs::write(&file, TEXT).unwrap();
    let opened = Opened::load(&file, &LoadOptions::default()).unwrap();
    let mut desc = opened.desc.clone();
    for (path, name) in [
        ("material.gold", "old gold"),
        ("texture.squares", "board"),
        ("medium.haze", "fog"),
        ("view.0", "bird"),
        ("object.0", "orb"),
    ] {
        desc.rename(path, name).unwrap();
    }
    let saved = save_scene(&desc, Some(&opened), &file).unwrap();
    assert!(saved.kept_text, "{:?}", saved.notes);
    let expected = TEXT
        .replace("[material.gold]", "[material.\"old gold\"]")
        .replace("material = \"gold\"", "material = \"old gold\"")
        .replace("[texture.squares]", "[texture.board]")
        .replace("color = \"squares\"", "color = \"board\"")
        .replace("[medium.haze]", "[medium.fog]")
        .replace("name = \"from above\"", "name = \"bird\"")
        .replace("name = \"ball\"", "name = \"orb\"");
    assert_eq!(fs::read_to_string(&file).unwrap(), expected);
}

/// A material that is written where it is used gets a section once it has a name.
#[test]
fn a_part_without_a_name_gets_a_section() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    fs::write(&file, TEXT).unwrap();
    let opened = Opened::load(&file, &LoadOptions::default()).unwrap();
    let mut desc = opened.desc.clone();
    let number = desc.materials.iter().position(|material| material.name.is_none()).unwrap();
    let path = format!("material.{}", desc.names().materials[number]);
    assert_eq!(desc.rename(&path, "paint").unwrap(), "material.paint");
    let saved = save_scene(&desc, Some(&opened), &file).unwrap();
    assert!(saved.kept_text, "{:?}", saved.notes);
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.contains("material = \"paint\"   # no name"), "{text}");
    assert!(text.contains("[material.paint]") && text.contains("# The precious one."), "{text}");
    let again = Opened::load(&file, &LoadOptions::default()).unwrap();
    again.desc.same_apart_from_order(&desc).unwrap();
}
