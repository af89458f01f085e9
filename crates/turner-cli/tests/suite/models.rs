//! Models without a scene file: `turner model.glb`.

use std::path::{Path, PathBuf};

use crate::common::{Folder, folder, pixels};

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../turner-io/tests/assets")
}

/// A folder with copies of models.
fn with(names: &[&str]) -> Folder {
    let f = folder();
    for name in names {
        let to = f.path().join(Path::new(name).file_name().unwrap());
        std::fs::copy(assets().join(name), to).unwrap();
    }
    f
}

const SMALL: [&str; 6] = ["--width", "32", "--height", "24", "--samples", "2"];

fn small<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [args, &SMALL].concat()
}

/// The alpha of each pixel.
fn alphas(bytes: &[u8]) -> Vec<f32> {
    let image =
        turner_io::image::decode(bytes, "picture", &turner_io::image::DecodeLimits::default()).unwrap();
    let positions = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    positions.map(|(x, y)| image.alpha(x, y)).collect()
}

#[test]
fn a_model_needs_no_flag_and_is_reported() {
    let f = with(&["gltf/Box.glb"]);
    let run = f.turner(&small(&["Box.glb"])).ok();
    for words in ["Box.glb: glTF 2.0, ", "12 triangles", "no camera", "studio", "floor"] {
        assert!(run.stderr.contains(words), "{words}: {run:?}");
    }
    let (w, h, p) = pixels(&f.read("Box.png"));
    assert_eq!((w, h), (32, 24));
    // A red box at the centre of a grey picture.
    let [r, g, b] = p[12 * 32 + 16];
    assert!(r > 2.0 * g && r > 2.0 * b, "{:?}", p[12 * 32 + 16]);
    let [r, g, b] = p[0];
    assert!(r > 0.3 && (r - g).abs() < 0.1 && (r - b).abs() < 0.1, "{:?}", p[0]);
    f.turner(&small(&["Box.glb", "-o", "b.png", "--threads", "1"])).ok();
    assert_eq!(f.read("Box.png"), f.read("b.png"));
}

#[test]
fn every_kind_of_model_renders() {
    let f = with(&[
        "mesh/cube.obj",
        "mesh/cube.mtl",
        "mesh/points_ascii.ply",
        "mesh/20mm-xyz-cube.stl",
        "gltf/Fox.glb",
    ]);
    for name in ["cube.obj", "points_ascii.ply", "20mm-xyz-cube.stl", "Fox.glb"] {
        f.turner(&small(&[name, "-o", "x.png"])).ok();
        let (_, _, p) = pixels(&f.read("x.png"));
        let (low, high) = p.iter().flatten().fold((1.0f32, 0.0f32), |(l, h), v| (l.min(*v), h.max(*v)));
        assert!(low < high - 0.1, "{name}: a picture of one colour");
    }
}

#[test]
fn a_transparent_background_leaves_the_floor_out() {
    let f = with(&["gltf/Box.glb"]);
    f.turner(&small(&["Box.glb", "--background", "transparent"])).ok();
    let alphas = alphas(&f.read("Box.png"));
    assert_eq!((alphas[0], alphas[12 * 32 + 16]), (0.0, 1.0));
    f.turner(&small(&["Box.glb", "--background", "green", "--no-ground", "-o", "l.png"])).ok();
    let (_, _, p) = pixels(&f.read("l.png"));
    // Exactly the colour that was asked for, (0, 128, 0).
    assert_eq!(p[0].map(|v| (255.0 * v).round()), [0.0, 128.0, 0.0]);
}

#[test]
fn cameras_by_orbit_and_by_name() {
    let f = with(&["gltf/MultiUVTest.glb", "gltf/Box.glb"]);
    f.turner(&small(&["Box.glb", "--camera", "orbit:0,0", "-o", "front.png"])).ok();
    f.turner(&small(&["Box.glb", "--camera", "orbit:90,0,4", "-o", "right.png"])).ok();
    assert_ne!(f.read("front.png"), f.read("right.png"));
    let run = f.turner(&["info", "MultiUVTest.glb", "--json"]).ok();
    let info: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let name = info["cameras"][0].as_str().unwrap().to_owned();
    assert_eq!(info["imports"][0]["format"], "glTF 2.0");
    f.turner(&small(&["MultiUVTest.glb", "--camera", &name, "-o", "named.png"])).ok();
    f.turner(&small(&["MultiUVTest.glb", "-o", "first.png"])).ok();
    assert_eq!(pixels(&f.read("named.png")), pixels(&f.read("first.png")));
    f.turner(&["Box.glb", "--camera", "orbit:1"]).fails(2, &["orbit:azimuth,elevation"]);
    f.turner(&["MultiUVTest.glb", "--camera", "nobody"]).fails(1, &["nobody"]);
}

/// The first and last column and row in which a picture with alpha shows anything, as fractions of its shorter side.
fn extent(bytes: &[u8], [width, height]: [usize; 2]) -> [f64; 4] {
    let alphas = alphas(bytes);
    let seen = |i: &usize| alphas[*i] > 0.5;
    let columns = || (0..alphas.len()).filter(seen).map(|i| i % width);
    let rows = || (0..alphas.len()).filter(seen).map(|i| i / width);
    let side = width.min(height) as f64;
    [columns().min(), columns().max().map(|v| v + 1), rows().min(), rows().max().map(|v| v + 1)]
        .map(|v| v.unwrap() as f64 / side)
}

#[test]
fn models_fill_three_quarters_of_the_picture_and_options_keep_that() {
    let f = with(&["gltf/Fox.glb"]);
    let wide = ["--width", "160", "--height", "120", "--samples", "2", "--background", "transparent"];
    for more in [
        &["--camera", "orbit:35,22"][..],
        &["--camera", "orbit:90,0"],
        &["--camera", "orbit:0,80"],
        &["--camera", "orbit:200,-40"],
        &["--fov", "60"],
        &["-D", "camera.fov=10"],
        &["--fstop", "64"],
    ] {
        f.turner(&[&["Fox.glb", "-o", "f.png"][..], &wide, more].concat()).ok();
        let [left, right, top, bottom] = extent(&f.read("f.png"), [160, 120]);
        let longer = (right - left).max(bottom - top);
        assert!((0.7..0.8).contains(&longer), "{more:?}: {longer}");
        assert!((left + right - 160.0 / 120.0).abs() < 0.04, "{more:?}: {left} {right}");
        assert!((top + bottom - 1.0).abs() < 0.04, "{more:?}: {top} {bottom}");
    }
    f.turner(&[&["Fox.glb", "--zoom", "0.5", "-o", "z.png"][..], &wide].concat()).ok();
    let [left, right, ..] = extent(&f.read("z.png"), [160, 120]);
    assert!((0.2..0.42).contains(&(right - left)), "{left} {right}");
    f.turner(&small(&["Fox.glb", "--look-at", "nothing"])).fails(1, &["nothing"]);
    f.turner(&small(&["Fox.glb", "--focus", "near"])).fails(2, &["object"]);
}

#[test]
fn a_white_background_is_white() {
    let f = with(&["gltf/Box.glb"]);
    f.turner(&small(&["Box.glb", "--background", "white", "-o", "w.png"])).ok();
    let (_, _, p) = pixels(&f.read("w.png"));
    assert_eq!(p[0][..3], [1.0, 1.0, 1.0]);
    f.turner(&small(&["Box.glb", "-o", "b.png"])).ok();
    let (_, _, p) = pixels(&f.read("b.png"));
    assert!((0.9..1.0).contains(&p[0][0]), "{:?}", p[0]);
}

#[test]
fn turntables_and_frames_are_numbered() {
    let f = with(&["gltf/Box.glb", "gltf/Fox.glb"]);
    f.turner(&small(&["Box.glb", "--turntable", "3", "-o", "t-##.png"])).ok();
    f.turner(&small(&["Fox.glb", "--frames", "0-1", "--fps", "4", "--animation", "Walk"])).ok();
    for name in ["t-00.png", "t-01.png", "t-02.png", "Fox_0000.png", "Fox_0001.png"] {
        assert!(f.names().contains(&name.to_owned()), "{name}: {:?}", f.names());
    }
    assert_ne!(f.read("t-00.png"), f.read("t-01.png"));
    assert_ne!(f.read("Fox_0000.png"), f.read("Fox_0001.png"));
    f.turner(&small(&["Fox.glb", "--frame", "1", "--fps", "4", "--animation", "Walk", "-o", "one.png"])).ok();
    assert_eq!(pixels(&f.read("one.png")), pixels(&f.read("Fox_0001.png")));
    // The first picture of a turntable shows the view of the scene's camera; the second one differs.
    f.write(
        "c.toml",
        "camera = { position = [0, 2, 6], look_at = [0, 1, 0] }\nlight = [{ type = \"point\", position = [3, 4, 5] }]\n\
         object = [{ type = \"sphere\", center = [0.5, 1, 0] }]\n",
    );
    f.turner(&small(&["c.toml", "--turntable", "2", "-o", "c-#.png"])).ok();
    f.turner(&small(&["c.toml", "-o", "c.png"])).ok();
    assert_eq!(pixels(&f.read("c.png")), pixels(&f.read("c-0.png")));
    assert_ne!(f.read("c-0.png"), f.read("c-1.png"));
    f.turner(&["Box.glb", "--turntable", "2", "-o", "-", "--format", "png"]).fails(2, &["standard output"]);
}

#[test]
fn ignored_features_are_errors_with_strict() {
    let f = with(&["mesh/missing_material_file.obj"]);
    let run = f.turner(&small(&["missing_material_file.obj", "-o", "x.png"])).ok();
    assert!(run.stderr.contains("warning"), "{run:?}");
    f.turner(&small(&["missing_material_file.obj", "--strict", "-o", "y.png"])).fails(1, &["E0501"]);
    let events = f.turner(&small(&["missing_material_file.obj", "--json", "-o", "x.png"])).ok();
    let kinds: Vec<serde_json::Value> =
        events.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(kinds.iter().any(|e| e["event"] == "import" && e["counts"]["triangles"].as_u64() > Some(0)));
    assert!(kinds.iter().any(|e| e["event"] == "warning" && e["kind"] == "ignored"));
    assert!(kinds.iter().any(|e| e["event"] == "warning" && e["kind"] == "note"));
}

#[test]
fn models_in_scenes() {
    let f = with(&["gltf/Box.glb", "mesh/cube.obj", "mesh/cube.mtl"]);
    f.write(
        "m.toml",
        r#"include = ["Box.glb"]
[film]
width = 16
height = 12
[integrator]
type = "path"
[studio]
[[object]]
type = "model"
file = "cube.obj"
transform = { translate = [3, 0, 0] }
material = { type = "principled", base_color = "lime" }
"#,
    );
    let run = f.turner(&["info", "m.toml", "--json"]).ok();
    let info: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(info["imports"].as_array().unwrap().len(), 2);
    assert_eq!(info["triangles"], 24);
    f.turner(&["m.toml"]).ok();
    f.write(
        "n.toml",
        "[[object]]\ntype = \"model\"\nfile = \"cube.obj\"\nmaterials = { gold = { color = \"gold\" } }\n",
    );
    f.turner(&["n.toml"]).fails(1, &["n.toml:4", "gold"]);
    f.write("o.toml", "[[object]]\ntype = \"model\"\nfile = \"cube.obj\"\nnodes = [\"nobody\"]\n");
    f.turner(&["o.toml"]).fails(1, &["nobody"]);
}

#[test]
fn a_picture_that_the_model_uses_is_not_written_over() {
    let f = with(&["mesh/cube.obj"]);
    f.write("cube.mtl", "newmtl a\nmap_Kd cube.png\n");
    let picture = f.turner(&["s.toml", "-o", "cube.png"]).ok();
    assert_eq!(picture.code, Some(0));
    let before = f.read("cube.png");
    let obj = String::from_utf8(f.read("cube.obj")).unwrap();
    let own: String = obj
        .lines()
        .map(|l| if l.starts_with("usemtl") { "usemtl a\n".into() } else { format!("{l}\n") })
        .collect();
    f.write("cube.obj", &own);
    f.turner(&small(&["cube.obj"])).fails(1, &["cube.png", "reads this file"]);
    assert_eq!(f.read("cube.png"), before);
}

#[test]
fn info_lists_names() {
    let f = with(&["gltf/Fox.glb"]);
    let text = f.turner(&["info", "Fox.glb"]).ok().stdout;
    for words in ["material names  fox_material", "animations      Survey, Walk, Run"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&f.turner(&["info", "Fox.glb", "--json"]).ok().stdout).unwrap();
    assert_eq!(json["names"]["animations"], serde_json::json!(["Survey", "Walk", "Run"]));
}
