//! `turner list`, `turner help`, `turner info`, `turner bench`, and the names of commands.

use crate::common::{SCENE, folder};

#[test]
fn topics_are_listed() {
    let f = folder();
    let list = |topic: &str| f.turner(&["list", topic]).ok().stdout;
    for (topic, word) in [
        ("shapes", "sphere"),
        ("materials", "classic"),
        ("textures", "checkerboard"),
        ("lights", "directional"),
        ("cameras", "pinhole"),
        ("integrators", "normals"),
        ("antialias", "monte-carlo"),
        ("filters", "blackman-harris"),
        ("transfers", "srgb"),
        ("formats", ".exr"),
        ("sections", "film"),
        ("colors", "rebeccapurple"),
        ("errors", "E0102"),
    ] {
        assert!(list(topic).contains(word), "{topic}");
        let json = f.turner(&["list", topic, "--json"]).ok().stdout;
        let rows: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert!(
            rows.as_array().unwrap().iter().all(|r| r["name"].is_string() && r["description"] != ""),
            "{topic}"
        );
        assert!(f.turner(&["list"]).ok().stdout.contains(topic));
    }
    f.turner(&["list", "shape"]).fails(2, &["shapes"]);
}

#[test]
fn help_explains_commands_and_the_scene_format() {
    let f = folder();
    let help = |args: &[&str]| f.turner(&[&["help"], args].concat()).ok().stdout;
    assert!(help(&[]).contains("render") && help(&["render"]).contains("--antialias"));
    assert!(help(&["json"]).contains("rays_per_second"));
    let overview = help(&["scene"]);
    for word in ["[camera]", "[[object]]", "sphere", "[material.NAME]"] {
        assert!(overview.contains(word), "{word}");
    }
    let sphere = help(&["scene", "sphere"]);
    for word in
        ["The shape \"sphere\"", "The light \"sphere\"", "radius", "greater than 0", "default 1", "Example"]
    {
        assert!(sphere.contains(word), "{word}: {sphere}");
    }
    assert!(help(&["scene", "film"]).contains("\"adaptive\": "), "words have meanings");
    for name in ["camera", "object", "transform", "color", "group", "include", "shapes", "background"] {
        assert!(help(&["scene", name]).len() > 100, "{name}");
    }
    f.turner(&["help", "scene", "spere"]).fails(2, &["did you mean \"sphere\""]);
    f.turner(&["help", "rendr"]).fails(2, &["did you mean \"render\""]);
    for (word, expected) in [
        ("fov", "the camera \"pinhole\""),
        ("gloss", "0 to 8"),
        ("k_reflect", "the material \"classic\""),
        ("monte-carlo", "antialias = \"monte-carlo\""),
        ("--samples", "film.samples"),
        ("-o", "--output"),
        ("E0102", "radus"),
        ("e0102", "radus"),
        ("tomato", "#ff6347"),
        ("metalness", "base_metalness"),
        ("--spp", "--samples 64"),
    ] {
        assert!(help(&[word]).contains(expected), "{word}: {}", help(&[word]));
    }
    assert!(help(&["scene", "--markdown"]).contains("\n### Shapes: `sphere`\n"));
}

#[test]
fn info_counts_what_is_there() {
    let f = folder();
    let text = f.turner(&["info", "s.toml"]).ok().stdout;
    for word in ["2 sphere", "1 point", "pinhole", "24x16", "bounds", "tree"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let json = f.turner(&["info", "s.toml", "--json", "-D", "film.width=99"]).ok().stdout;
    let info: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&info["objects"]["sphere"], &info["film"]["width"]), (&2.into(), &99.into()));
    assert_eq!(info["bounds"]["min"][1], -2000.0);
    assert!(info["memory"]["film"].as_u64().unwrap() > 0);
    assert_eq!(f.names(), ["s.toml"], "nothing is written");
}

#[test]
fn misspelled_commands_are_found() {
    let f = folder();
    f.turner(&["rendr"]).fails(2, &["did you mean `turner render`"]);
    f.turner(&["lsit"]).fails(2, &["did you mean `turner list`"]);
    f.turner(&["nothing.toml"]).fails(1, &["E0201"]);
    f.turner(&[]).fails(2, &["Usage"]);
    f.turner(&["--nonsense"]).fails(2, &["--nonsense"]);
    assert!(f.turner(&["--version"]).ok().stdout.starts_with("turner "));
    // An existing file with this name is a scene.
    f.write("rendr", SCENE);
    f.turner(&["rendr"]).ok();
}

#[test]
fn bench_measures_a_folder() {
    let f = folder();
    f.turner(&["bench"]).fails(2, &["--dir"]);
    let json = f.turner(&["bench", "--dir", ".", "--repeat", "3", "--threads", "1,2", "--json"]).ok().stdout;
    let rows: Vec<serde_json::Value> = json.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(rows.len(), 2);
    assert_eq!((&rows[1]["threads"], &rows[0]["scene"]), (&2.into(), &"s".into()));
    assert_eq!(rows[0]["seconds"].as_array().unwrap().len(), 3);
    assert!(f.turner(&["bench", "s", "--dir", "."]).ok().stdout.contains("rays/s"));
    f.turner(&["bench", "x", "--dir", "."]).fails(2, &["valid: s"]);
}
