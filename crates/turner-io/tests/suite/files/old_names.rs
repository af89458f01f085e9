//! Replaced names of the scene format are still read: the same scene, with a note for each.

use turner::description::SceneDesc;
use turner::schema::WarningKind;
use turner_io::assets::FolderAssets;
use turner_io::scene::{LoadOptions, Override, load_text};

const OLD: &str = r#"
film = { max_sample = 4 }
integrator = { type = "path", reuse = "always" }
camera = { type = "thin-lens", focus = 3 }
stage = { studio = false, studio_rotation = 30, studio_strength = 2 }
view = [{ type = "fisheye", angle = 200 }]
light = [{ type = "point", position = [0, 2, 0], group = "key" }]
object = [
  { type = "sphere", material = { type = "boundary" } },
  { type = "sphere", material = { type = "matte", color = { type = "product", a = { type = "chessboard" }, b = { type = "vertex-color", otherwise = 0.5 } } } },
]
"#;

const NEW: &str = r#"
film = { clamp_sample = 4 }
integrator = { type = "path", shared_paths = "always" }
camera = { type = "thin-lens", focus_distance = 3 }
studio = { lights = false, rotation = 30, strength = 2 }
view = [{ type = "fisheye", fov = 200 }]
light = [{ type = "point", position = [0, 2, 0], light_group = "key" }]
object = [
  { type = "sphere", material = { type = "interface" } },
  { type = "sphere", material = { type = "matte", color = { type = "multiply", a = { type = "checkerboard" }, b = { type = "vertex-color", fallback = 0.5 } } } },
]
"#;

fn load(text: &str, options: &[&str]) -> SceneDesc {
    let overrides = options.iter().map(|o| Override::parse(o).unwrap()).collect();
    let options = LoadOptions { overrides, ..LoadOptions::default() };
    let assets = FolderAssets::new(".").unwrap();
    load_text(text.to_owned(), "scene.toml", &assets, &options).unwrap().desc
}

#[test]
fn old_names_are_read_with_a_note_each() {
    let (old, new) = (load(OLD, &[]), load(NEW, &[]));
    old.same_scene(&new).unwrap();
    assert!(new.warnings.is_empty(), "{:?}", new.warnings);
    let pairs = [
        ("max_sample", "clamp_sample"),
        ("reuse", "shared_paths"),
        ("focus", "focus_distance"),
        ("stage", "studio"),
        ("studio", "lights"),
        ("studio_rotation", "rotation"),
        ("studio_strength", "strength"),
        ("angle", "fov"),
        ("boundary", "interface"),
        ("product", "multiply"),
        ("chessboard", "checkerboard"),
        ("otherwise", "fallback"),
        ("group", "light_group"),
    ];
    for (was, is) in pairs {
        let said = format!("`{was}` is now called `{is}`");
        let found = old.warnings.iter().filter(|w| w.message.starts_with(&said)).collect::<Vec<_>>();
        assert_eq!(found.len(), 1, "{said}: {:?}", old.warnings);
        assert_eq!(found[0].kind, WarningKind::Note, "a note is no error under --strict");
        assert!(found[0].span.is_some());
    }
    assert_eq!(old.warnings.len(), pairs.len(), "{:?}", old.warnings);
}

#[test]
fn options_set_a_key_by_either_name_whichever_the_file_has() {
    let expected = load(NEW, &["film.clamp_sample=9", "studio.strength=5"]);
    for text in [OLD, NEW] {
        for options in
            [["film.max_sample=9", "stage.studio_strength=5"], ["film.clamp_sample=9", "studio.strength=5"]]
        {
            load(text, &options).same_scene(&expected).unwrap();
        }
    }
}
