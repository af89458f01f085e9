//! Saving a scene in its own text.

use std::fs;
use std::path::{Path, PathBuf};

use turner::description::{ModelDesc, ObjectDesc, SceneDesc};
use turner::schema::value::{Data, Value};
use turner::schema::{ErrorCode, KeyEdit};
use turner_io::assets::FolderAssets;
use turner_io::edit::{Opened, Saved, save_scene};
use turner_io::scene::{LoadOptions, SceneFiles, Sources};

use super::assets_folder;

const SCENE: &str = r##"# A scene for people.
include = []

[film]   # the picture
width = 640          # pixels
height = 4_80

# Gold, as in the catalogue.
[material.gold]
type = "metal"
roughness = 0.10     # polished

[material]
grey.color = [0.5, 0.50, 5e-1]

[camera]
position = [0, 1,
            8]

# The ball.
[[object]]
type = "sphere"
name = "ball"
radius = 1.50
material = "gold"
transform = { translate = [0, 1.0, 0], scale = 2 }

# The box,
# with a material of its own.
[[object]]
type = "box"
material = { color = "#ff8000", ks = 0.20 }   # orange

  [[object]]
  type = "sphere"
  material = "grey"

# The lamp.
[[light]]
type = "point"
position = [3, 5, 4]
"##;

/// A folder with a scene in it.
struct Folder {
    folder: tempfile::TempDir,
}

impl Folder {
    fn with(text: &str) -> Folder {
        let folder = Folder { folder: tempfile::tempdir().unwrap() };
        fs::write(folder.path("scene.toml"), text).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn open(&self, name: &str) -> Opened {
        Opened::load(&self.path(name), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Edits the opened scene, saves it as `out` and checks that the file gives the edited scene.
    fn edited(
        &self,
        opened: &Opened,
        edit: impl FnOnce(&mut SceneDesc, &mut SceneFiles<'_>),
        out: &str,
    ) -> Saved {
        let mut desc = opened.desc.clone();
        let assets = FolderAssets::new(self.folder.path()).unwrap().allow_outside(true);
        let sources = Sources::default();
        edit(&mut desc, &mut SceneFiles::new(&assets, &sources));
        let saved = save_scene(&desc, Some(opened), &self.path(out)).unwrap_or_else(|e| panic!("{e}"));
        let read = turner_io::load(self.path(out)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(desc.same_apart_from_order(&read), Ok(()));
        saved
    }
}

fn set(desc: &mut SceneDesc, files: &mut SceneFiles<'_>, path: &str, data: Data) {
    desc.edit(&[KeyEdit::new(path, data)], files).unwrap_or_else(|e| panic!("{path}: {e}"));
}

/// The lines of one text that the other does not have, and the other way round.
fn differing<'a>(old: &'a str, new: &'a str) -> (Vec<&'a str>, Vec<&'a str>) {
    let only = |a: &'a str, b: &str| {
        let mut left: Vec<&str> = b.lines().collect();
        let mut out = Vec::new();
        for line in a.lines() {
            match left.iter().position(|other| *other == line) {
                Some(at) => _ = left.remove(at),
                None => out.push(line),
            }
        }
        out
    };
    (only(old, new), only(new, old))
}

#[test]
fn an_unchanged_scene_is_the_same_text() {
    for text in [SCENE.to_owned(), SCENE.replace('\n', "\r\n"), format!("\u{feff}{SCENE}")] {
        let folder = Folder::with(&text);
        let saved = folder.edited(&folder.open("scene.toml"), |_, _| {}, "scene.toml");
        assert!(saved.kept_text, "{saved:?}");
        assert_eq!(folder.text("scene.toml"), text);
    }
}

#[test]
fn only_what_changed_is_written() {
    for text in [SCENE.to_owned(), SCENE.replace('\n', "\r\n"), format!("\u{feff}{SCENE}")] {
        let folder = Folder::with(&text);
        let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
            set(desc, files, "film.width", Data::Integer(320));
            set(desc, files, "material.gold.roughness", Data::Number(0.25));
            set(desc, files, "material.grey.color", Data::Number(0.75));
            set(desc, files, "object.0.hidden", Data::Bool(true));
            set(desc, files, "object.1.material", Data::String("gold".into()));
            set(desc, files, "object.2.radius", Data::Number(3.0));
            set(desc, files, "light.0.intensity", Data::Number(7.0));
        };
        let saved = folder.edited(&folder.open("scene.toml"), change, "scene.toml");
        assert!(saved.kept_text, "{saved:?}");
        let new = folder.text("scene.toml");
        let (gone, added) = differing(&text, &new);
        assert_eq!(
            gone,
            [
                "width = 640          # pixels",
                "roughness = 0.10     # polished",
                "grey.color = [0.5, 0.50, 5e-1]",
                "material = { color = \"#ff8000\", ks = 0.20 }   # orange",
            ]
        );
        assert_eq!(
            added,
            [
                "width = 320          # pixels",
                "roughness = 0.25     # polished",
                "grey.color = 0.75",
                "hidden = true",
                "material = \"gold\"   # orange",
                "  radius = 3",
                "intensity = 7",
            ],
        );
        assert_eq!(new.contains('\r'), text.contains('\r'));
        assert_eq!(new.replace("\r\n", "").contains(['\r', '\n']), !text.contains('\r'));
        assert_eq!(new.starts_with('\u{feff}'), text.starts_with('\u{feff}'));
    }
}

#[test]
fn keys_in_braces_change_in_place() {
    let folder = Folder::with(SCENE);
    let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
        set(desc, files, "material.material-3.ks", Data::Number(0.5));
    };
    assert!(folder.edited(&folder.open("scene.toml"), change, "scene.toml").kept_text);
    assert!(folder.text("scene.toml").contains("{ color = \"#ff8000\", ks = 0.5 }   # orange"));
    let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
        set(desc, files, "material.material-3.shininess", Data::Number(99.0));
        set(desc, files, "material.material-3.ks", Data::Number(0.0));
    };
    let saved = folder.edited(&folder.open("scene.toml"), change, "scene.toml");
    assert!(saved.kept_text, "{saved:?}");
    let text = folder.text("scene.toml");
    assert!(text.contains("material = { color = \"#ff8000\", ") && text.contains("}   # orange"), "{text}");
}

#[test]
fn parts_come_and_go() {
    let folder = Folder::with(SCENE);
    let change = |desc: &mut SceneDesc, _: &mut SceneFiles<'_>| {
        desc.remove(&["object.0", "material.gold"]).unwrap();
        desc.duplicate("object.0").unwrap();
        desc.duplicate("light.0").unwrap();
        desc.add_object(ObjectDesc { name: Some("new".into()), ..ObjectDesc::default() });
        desc.add_material("glass", Default::default());
        desc.add_view("side", Default::default());
    };
    let saved = folder.edited(&folder.open("scene.toml"), change, "scene.toml");
    assert!(saved.kept_text, "{saved:?}");
    let text = folder.text("scene.toml");
    assert!(
        !text.contains("The ball") && !text.contains("Gold") && text.contains("# The box,\n# with"),
        "{text}"
    );
    let places =
        ["# The box,", "  material = \"grey\"", "name = \"new\"", "# The lamp."].map(|part| text.find(part));
    assert!(places.is_sorted() && places.iter().all(Option::is_some), "{text}");
    assert!(text.contains("\n\n[material.glass]\n"), "{text}");
}

#[test]
fn groups_are_written_as_sections() {
    let folder = Folder::with(SCENE);
    let change = |desc: &mut SceneDesc, _: &mut SceneFiles<'_>| {
        desc.group_objects(&["object.0", "object.1"], "pair").unwrap();
    };
    let saved = folder.edited(&folder.open("scene.toml"), change, "scene.toml");
    assert!(folder.text("scene.toml").contains("[[group.pair.object]]"), "{saved:?}");
    let change = |desc: &mut SceneDesc, _: &mut SceneFiles<'_>| {
        desc.ungroup("object.1").unwrap();
    };
    let saved = folder.edited(&folder.open("scene.toml"), change, "scene.toml");
    assert!(!folder.text("scene.toml").contains("group"), "{saved:?}");
}

#[test]
fn an_integrator_of_another_type_keeps_the_film() {
    let folder = Folder::with(SCENE);
    let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
        set(desc, files, "integrator.type", Data::String("path".into()));
        set(desc, files, "film.samples", Data::Integer(16));
    };
    let saved = folder.edited(&folder.open("scene.toml"), change, "scene.toml");
    assert!(saved.kept_text, "{saved:?}");
    assert!(folder.text("scene.toml").contains("[integrator]\ntype = \"path\""));
}

#[test]
fn an_included_file_is_not_changed() {
    let folder = Folder::with(&SCENE.replace("include = []", "include = \"parts.toml\""));
    let parts = "# Shared.\n[[object]]\ntype = \"sphere\"\nname = \"shared\"\n";
    fs::write(folder.path("parts.toml"), parts).unwrap();
    let opened = folder.open("scene.toml");
    let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
        set(desc, files, "object.1.radius", Data::Number(4.0));
    };
    assert!(folder.edited(&opened, change, "scene.toml").kept_text);
    let mut desc = opened.desc.clone();
    desc.objects[0].hidden = true;
    let before = folder.text("scene.toml");
    let error = save_scene(&desc, Some(&opened), &folder.path("scene.toml")).unwrap_err();
    assert_eq!(error.code, ErrorCode::Conflict);
    assert!(error.help.unwrap().contains("another name"));
    assert_eq!((folder.text("scene.toml"), folder.text("parts.toml")), (before, parts.to_owned()));
    let saved = folder.edited(&opened, |desc, _| desc.objects[0].hidden = true, "other.toml");
    assert!(!saved.kept_text && !folder.text("other.toml").contains("include"));
}

#[test]
fn a_scene_with_a_model_keeps_its_table() {
    let text = "# Mine.\n[[object]]\ntype = \"model\"\nfile = \"Box.glb\"  # from the web\n";
    let folder = Folder::with(text);
    fs::copy(assets_folder().join("Box.glb"), folder.path("Box.glb")).unwrap();
    let opened = folder.open("scene.toml");
    let translate = || {
        let mut table = turner::schema::value::Table::default();
        let numbers = [1.0, 2.0, 3.0].map(|v| Value::new(Data::Number(v)));
        table.push("translate", Data::Array(numbers.to_vec()));
        Data::Table(table)
    };
    let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
        set(desc, files, "object.0.transform", translate());
    };
    let saved = folder.edited(&opened, change, "scene.toml");
    assert!(saved.kept_text, "{saved:?}");
    assert_eq!(folder.text("scene.toml"), format!("{text}transform = {{ translate = [1, 2, 3] }}\n"));
    // A change inside the model.
    let inside = |desc: &mut SceneDesc, _: &mut SceneFiles<'_>| desc.materials[0].value = Default::default();
    let saved = folder.edited(&opened, inside, "scene.toml");
    assert!(!saved.kept_text && saved.notes[0].contains("written in full"), "{saved:?}");
}

#[test]
fn a_placed_model_becomes_a_short_scene() {
    let folder = Folder::with("");
    fs::create_dir(folder.path("models")).unwrap();
    fs::copy(assets_folder().join("Fox.glb"), folder.path("models/Fox.glb")).unwrap();
    let opened = folder.open("models/Fox.glb");
    let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
        set(desc, files, "film.width", Data::Integer(99));
        set(desc, files, "light", Data::Array(vec![]));
        desc.add_light(turner::light::LightDesc::default().into());
        desc.camera = Some(Default::default());
    };
    for out in ["fox.toml", "models/fox.toml"] {
        let saved = folder.edited(&opened, change, out);
        let text = folder.text(out);
        assert!(text.len() < 2000 && text.contains("Fox.glb\""), "{saved:?}\n{text}");
        assert_eq!(saved.files.len(), 1);
    }
    // A new scene with a model.
    let mut desc = SceneDesc::default();
    let assets = FolderAssets::new(folder.folder.path()).unwrap();
    let model = ModelDesc { file: "models/Fox.glb".into(), ..ModelDesc::default() };
    desc.add_model("fox", &model, &mut SceneFiles::new(&assets, &Sources::default())).unwrap();
    let saved = save_scene(&desc, None, &folder.path("new.toml")).unwrap();
    assert_eq!(saved.files.len(), 1, "{saved:?}");
    assert_eq!(desc.same_apart_from_order(&turner_io::load(folder.path("new.toml")).unwrap()), Ok(()));
}

#[test]
fn a_picture_from_elsewhere_is_copied() {
    let folder = Folder::with(SCENE);
    let elsewhere = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/classic/textures/wood.png");
    let mut table = turner::schema::value::Table::default();
    table.push("type", Data::String("image".into()));
    table.push("file", Data::String(elsewhere.canonicalize().unwrap().to_string_lossy().into_owned()));
    let change = |desc: &mut SceneDesc, files: &mut SceneFiles<'_>| {
        set(desc, files, "texture.wood", Data::Table(table));
        set(desc, files, "material.gold.color", Data::String("wood".into()));
    };
    let saved = folder.edited(&folder.open("scene.toml"), change, "scene.toml");
    assert!(saved.kept_text && saved.notes.iter().any(|note| note.contains("was copied")), "{saved:?}");
    assert_eq!(saved.files.len(), 2);
}

#[test]
fn a_failure_leaves_the_old_file() {
    let folder = Folder::with(SCENE);
    let opened = folder.open("scene.toml");
    let mut desc = opened.desc.clone();
    desc.film.width = 12;
    assert!(save_scene(&desc, Some(&opened), &folder.path("missing/scene.toml")).is_err());
    // A folder in the place of the file.
    fs::create_dir(folder.path("taken.toml")).unwrap();
    assert!(save_scene(&desc, Some(&opened), &folder.path("taken.toml")).is_err());
    assert_eq!(folder.text("scene.toml"), SCENE);
    assert_eq!(fs::read_dir(folder.folder.path()).unwrap().count(), 2, "no temporary file is left");
}

#[test]
fn ten_thousand_objects_are_saved_fast() {
    let mut text = String::from("[material.a]\ncolor = \"red\"\n");
    for i in 0..10_000 {
        text += &format!("\n[[object]]\ntype = \"sphere\"\ncenter = [{i}, 0.5, 1]\nmaterial = \"a\"\n");
    }
    let folder = Folder::with(&text);
    let opened = folder.open("scene.toml");
    let start = std::time::Instant::now();
    let saved = folder.edited(
        &opened,
        |desc, files| set(desc, files, "object.5000.radius", Data::Number(2.0)),
        "scene.toml",
    );
    println!("10,000 objects: edit, save and load in {:?}", start.elapsed());
    assert!(saved.kept_text);
    assert_eq!(folder.text("scene.toml").len(), text.len() + "radius = 2\n".len());
}
