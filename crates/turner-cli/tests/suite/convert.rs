//! `turner convert`: output, events, errors.

use crate::common::folder;

pub(crate) const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");

#[test]
fn a_converted_scene_renders_to_the_same_picture() {
    let f = folder();
    for scene in ["showcase/interior", "classic/002-09-reflection-texture", "textures/mappings"] {
        let scene = format!("{SCENES}/{scene}.toml");
        f.turner(&["convert", &scene, "c.toml", "--force"]).ok();
        for (scene, picture) in [(scene.as_str(), "a.exr"), ("c.toml", "b.exr")] {
            f.turner(&[scene, "--width", "24", "--height", "16", "--samples", "2", "-o", picture]).ok();
        }
        let compared = f.turner(&["compare", "a.exr", "b.exr", "--metric", "max", "--tolerance", "0"]);
        assert_eq!(compared.code, Some(0), "{scene}: {}", compared.stderr);
    }
}

#[test]
fn a_scene_as_gltf_looks_the_same() {
    let f = folder();
    let scene = format!("{SCENES}/showcase/cornell-box.toml");
    f.turner(&["convert", &scene, "c.glb"]).ok();
    let plain = [
        "--integrator",
        "path",
        "--no-ground",
        "-D",
        "studio.lights=false",
        "--background",
        "#000",
        "--tonemap",
        "none",
        "--denoise",
        "off",
        "-D",
        "film.fireflies=keep",
    ];
    for (scene, picture) in [(scene.as_str(), "a.exr"), ("c.glb", "b.exr")] {
        let mut args = vec![scene, "--width", "48", "--height", "36", "--samples", "16", "-o", picture];
        args.extend(plain);
        f.turner(&args).ok();
    }
    let compared = f.turner(&["compare", "a.exr", "b.exr", "--metric", "relmse", "--tolerance", "5e-3"]);
    assert_eq!(compared.code, Some(0), "{} {}", compared.stdout, compared.stderr);
}

#[test]
fn options_apply_and_json_reports_the_files() {
    let f = folder();
    let run = f.turner(&["convert", "s.toml", "c.toml", "--width", "77", "-D", "film.seed=5", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let last = run.stdout.lines().last().unwrap();
    assert!(last.contains("\"event\":\"converted\"") && last.contains("\"output\":\"c.toml\""), "{last}");
    let text = String::from_utf8(f.read("c.toml")).unwrap();
    assert!(text.contains("width = 77") && text.contains("seed = 5"), "{text}");
}

#[test]
fn bad_outputs_are_errors() {
    let f = folder();
    f.write("there.toml", "mine");
    for (args, code, words) in [
        (&["convert", "s.toml", "there.toml"][..], 1, "--force"),
        (&["convert", "s.toml", "s.toml", "--force"], 2, "read from this file"),
        (&["convert", "s.toml", "a.obj"], 2, ".glb"),
        (&["convert", "s.toml", "a.tom"], 2, "did you mean .toml?"),
        (&["convert", "missing.toml", "a.toml"], 1, "missing.toml"),
        (&["convert", "s.toml", "nowhere/a.toml"], 1, "nowhere"),
    ] {
        let run = f.turner(args);
        assert_eq!(run.code, Some(code), "{args:?} {}", run.stderr);
        assert!(run.stderr.contains(words), "{args:?} {}", run.stderr);
    }
    assert_eq!(f.read("there.toml"), b"mine");
    assert_eq!(f.names(), ["s.toml", "there.toml"]);
}

#[test]
fn an_imported_camera_is_written_once() {
    let f = folder();
    let scene =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../turner-io/tests/assets/pbrt/cornell-box/scene-v4.pbrt");
    f.turner(&["convert", scene, "c.toml"]).ok();
    let text = String::from_utf8(f.read("c.toml")).unwrap();
    assert!(text.contains("[camera]") && !text.contains("-0.0"), "{text}");
    assert!(!text.contains("[[view]]") && !text.contains("[studio]"), "{text}");
}

#[test]
fn a_model_is_written_with_the_camera_and_light_that_were_used() {
    let f = folder();
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../turner-io/tests/assets/gltf/Box.glb");
    let small = ["--width", "24", "--height", "16", "--samples", "2"];
    f.turner(&[&["convert", model, "b.toml", "--fov", "20"][..], &small].concat()).ok();
    let text = String::from_utf8(f.read("b.toml")).unwrap();
    for part in ["[camera]", "fov = 20", "[[light]]", "\"environment\"", "rotation = 35", "backdrop"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    f.turner(&[&[model, "-o", "a.png", "--fov", "20"][..], &small].concat()).ok();
    f.turner(&["b.toml", "-o", "b.png"]).ok();
    assert_eq!(crate::common::pixels(&f.read("a.png")), crate::common::pixels(&f.read("b.png")));
}
