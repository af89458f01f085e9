//! `turner doctor`: it finds the planted fault in broken scenes, and no errors in good ones.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::{Folder, folder};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn examined(f: &Folder, scene: &str, options: &[&str]) -> Value {
    let run = f.turner(&[&["doctor", scene, "--json"][..], options].concat()).ok();
    serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{scene}: {e}: {}", run.stdout))
}

fn findings(report: &Value) -> Vec<(String, String)> {
    let word = |f: &Value, key: &str| f[key].as_str().unwrap().to_owned();
    let list = report["findings"].as_array().unwrap();
    list.iter().map(|f| (word(f, "severity"), word(f, "code"))).collect()
}

/// The broken scenes. Each is named after its expected code, except for those listed here.
fn broken() -> Vec<(PathBuf, String)> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(root().join("crates/turner-cli/tests/doctor")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let code = match &*stem {
            "spot-away" => "light-faces-away",
            "lamp-in-wall" | "shade-of-boxes" => "light-enclosed",
            "mesh-lamp-inside-out" => "mesh-inside-out",
            "lamp-in-smoke" => "medium-too-dense",
            "noise-rough-glass" => "noise-caustics",
            "night-sky" => "sun-below-horizon",
            "far-model" => "objects-too-small",
            "model-without-light" => "no-lights",
            stem => stem,
        };
        out.push((path.clone(), code.to_owned()));
    }
    out.sort();
    out
}

#[test]
fn the_fault_of_each_broken_scene_is_the_first_finding() {
    let f = folder();
    let (mut wrong, mut count) = (Vec::new(), 0);
    for (path, code) in broken() {
        let report = examined(&f, &path.to_string_lossy(), &[]);
        let found = findings(&report);
        count += 1;
        if found.first().is_none_or(|(severity, first)| *first != code || severity == "note") {
            wrong.push(format!("{}: {found:?}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count >= 25, "{count}");
}

#[test]
fn good_scenes_have_no_errors() {
    let f = folder();
    for scene in [
        "hello",
        "still-life",
        "temple",
        "explain",
        "tutorial/step-8",
        "classic/002-13-thirty-spheres",
        "classic/004-book",
        "showcase/cornell-box",
        "showcase/glass-still-life",
        "showcase/evening",
        "showcase/interior",
        "showcase/night-street",
        "showcase/product",
        "peers/s1",
        "peers/s2",
        "textures/mappings",
    ] {
        let path = root().join("scenes").join(format!("{scene}.toml"));
        let report = examined(&f, &path.to_string_lossy(), &["--strict"]);
        let errors: Vec<_> =
            findings(&report).into_iter().filter(|(severity, _)| severity == "error").collect();
        assert!(errors.is_empty(), "{scene}: {errors:?}");
        assert_eq!(report["summary"]["black"], false, "{scene}");
    }
}

/// Findings and values are equal on every run, for any number of threads.
#[test]
fn an_examination_is_deterministic() {
    let f = folder();
    let broken = root().join("crates/turner-cli/tests/doctor/noise-indirect.toml");
    let scene = broken.to_string_lossy();
    let report = |threads: &str| {
        let mut report = examined(&f, &scene, &["--threads", threads]);
        report["seconds"] = Value::Null;
        report
    };
    let first = report("1");
    assert_eq!(first["format"], "turner-doctor");
    assert_eq!(first["version"], 2);
    assert_eq!(first, report("1"));
    assert_eq!(first, report("5"));
}

#[test]
fn findings_have_measurements_and_remedies() {
    let f = folder();
    let lamp = root().join("crates/turner-cli/tests/doctor/light-enclosed.toml");
    let scene = lamp.to_string_lossy();
    let report = examined(&f, &scene, &[]);
    let first = &report["findings"][0];
    assert_eq!(first["question"], "black");
    assert!(first["what"].as_str().unwrap().contains("shade"), "{first}");
    assert_eq!(first["measured"]["directions-enclosed"]["value"], 1.0, "{first}");
    assert_eq!(first["measured"]["points-reached"]["value"], 0.0, "{first}");
    assert_eq!(report["summary"]["black"], true);
    // As text, and the exit code with --strict.
    let text = f.turner(&["doctor", &scene]).ok().stdout;
    for word in ["error[light-enclosed]", "why:", "remedy:", "shade", "probed"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    f.turner(&["doctor", &scene, "--strict"]).fails(1, &["light-enclosed"]);
    f.turner(&["doctor", "nothing.toml"]).fails(1, &["nothing.toml"]);
    f.turner(&["doctor", &scene, "--seconds", "never"]).fails(2, &["seconds"]);
    // Options apply.
    let with = ["--set", "object.2.radius=0.01", "--set", "object.2.center=[9,9,9]"];
    assert!(findings(&examined(&f, &scene, &with)).iter().all(|(s, _)| s != "error"));
}

/// The options of a remedy remove the finding.
#[test]
fn the_flags_of_a_remedy_can_be_used() {
    let f = folder();
    for name in [
        "exposure-too-low",
        "light-too-weak",
        "depth-too-low",
        "lights-off",
        "light-sampling",
        "camera-looks-away",
    ] {
        let path = root().join(format!("crates/turner-cli/tests/doctor/{name}.toml"));
        let scene = path.to_string_lossy();
        let report = examined(&f, &scene, &[]);
        let flag = report["findings"][0]["flags"][0].as_str().unwrap().replace('\'', "");
        let words: Vec<&str> = flag.splitn(2, ' ').collect();
        let after = findings(&examined(&f, &scene, &words));
        assert!(after.iter().all(|(_, code)| code != name), "{name} {flag}: {after:?}");
    }
}

/// A light without a name is named by its type and position, and located in the file.
#[test]
fn lights_are_named() {
    let f = folder();
    let path = root().join("crates/turner-cli/tests/doctor/light-too-weak.toml");
    let scene = path.to_string_lossy();
    let report = examined(&f, &scene, &[]);
    let first = &report["findings"][0];
    assert!(!first["what"].as_str().unwrap().contains('#'), "{first}");
    let line = std::fs::read_to_string(&path).unwrap().lines().position(|l| l == "[[light]]").unwrap() + 1;
    assert_eq!(first["line"], line, "{first}");
    let text = f.turner(&["doctor", &scene]).ok().stdout;
    assert!(text.contains(&format!("light-too-weak.toml:{line}:")), "{text}");
}

/// IDs are not averaged: options for anti-aliasing have no effect.
#[test]
fn ids_are_the_same_with_any_samples() {
    let f = folder();
    f.turner(&["s.toml", "--integrator", "ids", "-o", "plain.png"]).ok();
    let many = ["--antialias", "monte-carlo", "--samples", "32", "-o", "many.png"];
    let run = f.turner(&[&["s.toml", "--integrator", "ids"][..], &many].concat()).ok();
    assert!(run.stderr.contains("IDs cannot be averaged"), "{}", run.stderr);
    assert!(!run.stderr.contains("no effect"), "{}", run.stderr);
    let [a, b] = ["plain.png", "many.png"].map(|name| crate::common::pixels(&f.read(name)));
    assert_eq!(a, b);
}

/// Film keys that a scene does not set have the defaults of the final integrator.
#[test]
fn film_defaults_follow_the_integrator() {
    let f = folder();
    let scene = "film = { width = 8, height = 8 }\n[[object]]\ntype = \"sphere\"\n[[light]]\ntype = \"point\"\nposition = [0, 3, 3]\n";
    f.write("plain.toml", scene);
    f.write("given.toml", &scene.replace("height = 8", "height = 8, samples = 5, transfer = \"none\""));
    let film = |name: &str, options: &[&str]| {
        let run = f.turner(&[&["info", name, "--json"][..], options].concat()).ok();
        let info: Value = serde_json::from_str(&run.stdout).unwrap();
        let film = &info["film"];
        format!("{} {} {}", film["antialias"], film["samples"], film["transfer"]).replace('"', "")
    };
    let with = |integrator: &str| format!("integrator.type=\"{integrator}\"");
    assert_eq!(film("plain.toml", &[]), "none 16 none");
    assert_eq!(film("plain.toml", &["-D", &with("path")]), "monte-carlo 64 srgb");
    assert_eq!(film("plain.toml", &["-D", &with("direct")]), "monte-carlo 16 srgb");
    assert_eq!(film("plain.toml", &["-D", &with("depth")]), "none 16 none");
    assert_eq!(film("given.toml", &["-D", &with("path")]), "monte-carlo 5 none");
    assert_eq!(film("plain.toml", &["-D", &with("path"), "-D", "film.antialias=none"]), "none 64 srgb");
}

#[test]
fn maps_are_pictures() {
    let f = folder();
    let run = f.turner(&["doctor", "s.toml", "-o", "maps", "--integrator", "path"]).ok();
    assert!(run.stdout.contains("colours of path-kind"), "{}", run.stdout);
    for name in ["cost", "variance", "path-kind"] {
        let (width, height, pixels) = crate::common::pixels(&f.read(&format!("maps/{name}.png")));
        assert_eq!((width, height), (24, 32), "{name}");
        assert!(pixels.iter().any(|p| *p != pixels[0]), "{name}");
    }
    let report = examined(&f, "s.toml", &["-o", "all.png", "--integrator", "path"]);
    assert_eq!(report["maps"][0]["maps"], serde_json::json!(["cost", "variance", "path-kind"]));
    let (width, ..) = crate::common::pixels(&f.read("all.png"));
    assert_eq!(width, 3 * 24 + 2 * 6);
    // With the classic integrator there is only the cost map.
    let report = examined(&f, "s.toml", &["-o", "cost.png"]);
    assert_eq!(report["maps"][0]["maps"], serde_json::json!(["cost"]));
    f.turner(&["doctor", "s.toml", "-o", "x.exr"]).fails(2, &["PNG"]);
}

/// Half a million triangles in a picture of a few thousand pixels.
#[test]
fn a_dense_mesh_is_named() {
    let f = folder();
    let n = 520;
    let mut obj = String::new();
    for y in 0..n {
        for x in 0..n {
            obj += &format!("v {} {} {}\n", x as f64 / 100.0, ((x * y) % 7) as f64 / 100.0, y as f64 / 100.0);
        }
    }
    for y in 0..n - 1 {
        for x in 0..n - 1 {
            let i = y * n + x + 1;
            obj += &format!("f {} {} {}\nf {} {} {}\n", i, i + n, i + 1, i + 1, i + n, i + n + 1);
        }
    }
    f.write("dense.obj", &obj);
    let text = "film.width = 160\nfilm.height = 120\n[[object]]\nname = \"terrain\"\ntype = \"mesh\"\nfile = \"dense.obj\"\n\
        [[light]]\ntype = \"directional\"\nfrom = [1, 3, 2]\n";
    f.write("dense.toml", text);
    let report = examined(&f, "dense.toml", &[]);
    assert_eq!(findings(&report)[0], ("warning".to_owned(), "dense-mesh".to_owned()), "{report}");
    assert!(report["findings"][0]["subject"] == "terrain", "{report}");
}

/// Lights and objects of light groups are counted.
#[test]
fn info_lists_light_groups() {
    let f = folder();
    f.write(
        "groups.toml",
        r#"
integrator.type = "path"
[[light]]
type = "point"
position = [0, 3, 0]
light_group = "lamps"
[[light]]
type = "directional"
from = [0, 1, 0]
light_group = "sun"
[group.pair]
[[group.pair.object]]
type = "sphere"
material = { type = "emissive" }
[[group.pair.object]]
type = "sphere"
center = [3, 0, 0]
light_group = "sign"
material = { type = "emissive" }
[[object]]
type = "instance"
group = "pair"
light_group = "lamps"
[[object]]
type = "sphere"
center = [0, 0, 5]
"#,
    );
    let info: Value =
        serde_json::from_str(&f.turner(&["info", "groups.toml", "--json"]).ok().stdout).unwrap();
    let expected = serde_json::json!([
        { "name": "lamps", "lights": 1, "objects": 1 },
        { "name": "sun", "lights": 1, "objects": 0 },
        { "name": "sign", "lights": 0, "objects": 1 },
    ]);
    assert_eq!(info["light_groups"], expected, "{info}");
    let text = f.turner(&["info", "groups.toml"]).ok().stdout;
    assert!(text.contains("lamps: 1 light, 1 object"), "{text}");
    f.write("empty.toml", "[[light]]\ntype = \"point\"\nposition = [0, 1, 0]\ngroup = \"\"\n");
    f.turner(&["info", "empty.toml"]).fails(1, &["empty.toml", "light group"]);
}

/// The memory of the light BVH is reported.
#[test]
fn info_says_what_the_light_tree_takes() {
    let street = root().join("scenes/showcase/night-street.toml");
    let run = folder().turner(&["info", &street.to_string_lossy(), "--json"]).ok();
    let info: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(info["memory"]["lights"].as_u64().unwrap() > 10_000, "{}", info["memory"]);
}
