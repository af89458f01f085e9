//! Cameras for programs: points on surfaces land on their pixels.

use serde_json::Value;
use turner::math::elementary::{asin, atan2};
use turner_io::image::{ChannelValues, DecodeLimits, exr, read_metadata};

use crate::common::{SCENE, folder};
use crate::folder::Folder;

/// The camera in the header of an EXR file.
fn camera(f: &Folder, name: &str) -> Value {
    let text = read_metadata(&f.read(name), name).unwrap()["turner:camera"].to_string();
    serde_json::from_str(&text).unwrap()
}

/// The channels `R G B` of the debug view `position`, by pixel.
fn positions(f: &Folder, name: &str) -> Vec<[f64; 3]> {
    let bytes = f.read(name);
    let read = exr::read_channels(&bytes, name, 0, |_| true, &DecodeLimits::default()).unwrap();
    let channel = |name: &str| match &read.iter().find(|c| c.name == name).unwrap().values {
        ChannelValues::Float(values) => values.to_vec(),
        ChannelValues::Uint(_) => panic!("{name} is uint"),
    };
    let [r, g, b] = ["R", "G", "B"].map(channel);
    r.iter().zip(&g).zip(&b).map(|((r, g), b)| [*r, *g, *b].map(f64::from)).collect()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("{v}"))
}

/// The product of a matrix and a point; the point has a 1 behind it if the matrix has four columns.
fn times(m: &Value, p: [f64; 3]) -> [f64; 3] {
    let row = |r: usize| {
        let v: Vec<f64> = m[r].as_array().unwrap().iter().map(number).collect();
        v[0] * p[0] + v[1] * p[1] + v[2] * p[2] + v.get(3).copied().unwrap_or(0.0)
    };
    [row(0), row(1), row(2)]
}

/// The formulas of docs/reference/header.md.
fn project(camera: &Value, p: [f64; 3]) -> [f64; 2] {
    let [x, y, z] = times(&camera["opencv"]["world_to_camera"], p);
    if camera["model"] == "perspective" {
        let [u, v, w] = times(&camera["K"], [x, y, z]);
        return [u / w, v / w];
    }
    assert_eq!(camera["K"], Value::Null);
    let pair = |v: &Value| [number(&v[0]), number(&v[1])];
    let [cx, cy] = pair(&camera["center"]);
    let key = if camera["model"] == "orthographic" { "pixels_per_unit" } else { "pixels_per_radian" };
    let [sx, sy] = pair(&camera[key]);
    let across = (x * x + y * y).sqrt();
    let [a, b] = match camera["model"].as_str().unwrap() {
        "orthographic" => [x, y],
        "fisheye" => [x, y].map(|v| atan2(across, z) * v / across),
        "equirectangular" => [atan2(x, z), asin(y / (x * x + y * y + z * z).sqrt())],
        other => panic!("{other}"),
    };
    [cx + sx * a, cy + sy * b]
}

/// Renders positions and asserts that those of surfaces land on the centres of their pixels.
fn check(f: &Folder, scene: &str, options: &[&str]) {
    f.write("c.toml", scene);
    let args = ["c.toml", "-o", "p.exr", "--integrator", "position", "--quiet"];
    f.turner(&[&args[..], options].concat()).ok();
    let camera = camera(f, "p.exr");
    let (width, height) = (camera["width"].as_u64().unwrap(), camera["height"].as_u64().unwrap());
    let positions = positions(f, "p.exr");
    assert_eq!(positions.len() as u64, width * height);
    let (mut count, mut worst) = (0, 0.0f64);
    for (i, p) in positions.iter().enumerate().filter(|(_, p)| **p != [0.0; 3]) {
        let (x, y) = ((i as u64 % width) as f64 + 0.5, (i as u64 / width) as f64 + 0.5);
        let [u, v] = project(&camera, *p);
        worst = worst.max((u - x).abs()).max((v - y).abs());
        count += 1;
    }
    assert!(count > 20, "{options:?}: {count} surfaces");
    assert!(worst < 1e-4, "{options:?}: {worst} pixels, {camera}");
}

/// The scene around another camera; positions are small numbers, which the floats of a file hold to 1e-7.
fn scene(camera: &str) -> String {
    let from = SCENE.find("[camera]").unwrap();
    let to = SCENE.find("[film]").unwrap();
    let near = SCENE.replace("[0, -1000, 0]\nradius = 1000", "[0, -20, 0]\nradius = 20");
    format!("{}[camera]\n{camera}\n{}", &near[..from], &near[to..])
}

const POSE: &str = "position = [1, 2, 4]\nlook_at = [0.2, 0.8, 0]\nup = [0.2, 1, 0.1]\n";

#[test]
fn points_on_surfaces_land_on_their_pixels() {
    let f = folder();
    for keys in [
        "fov = 40",
        "fov = 70\nshift = [0.1, -0.2]\nhandedness = \"left\"",
        "viewport = [3, 1]\ndistance = 2",
        "type = \"thin-lens\"\nlens_radius = 0\nfov = 50",
        "type = \"orthographic\"\nviewport = 3",
        "type = \"fisheye\"\nfov = 150",
        "type = \"equirectangular\"",
    ] {
        let scene = scene(&format!("{POSE}{keys}"));
        for options in [
            &[][..],
            &["-D", "film.width=30", "-D", "film.height=41"],
            &["--width", "50", "--height", "20", "--crop", "12,5,21,14"],
        ] {
            check(&f, &scene, options);
        }
    }
    check(&f, SCENE.replace("-1000", "-20").replace("1000", "20").as_str(), &[]);
}

#[test]
fn events_and_info_have_the_same_camera() {
    let f = folder();
    f.write("c.toml", &scene(&format!("{POSE}type = \"thin-lens\"\nlens_radius = 0.1\nfocus_distance = 3")));
    let run = f.turner(&["c.toml", "-o", "a.exr", "--json"]).ok();
    let done: Value = serde_json::from_str(run.stdout.lines().last().unwrap()).unwrap();
    let info: Value = serde_json::from_str(&f.turner(&["info", "c.toml", "--json"]).ok().stdout).unwrap();
    let header = camera(&f, "a.exr");
    assert_eq!((&done["camera"], &info["camera_model"]), (&header, &header));
    assert_eq!((number(&header["lens"]["radius"]), number(&header["lens"]["focus_distance"])), (0.1, 3.0));
    assert_eq!(header["shutter"], serde_json::json!([0.0, 1.0]));
    assert_eq!(header["mirrored"], false);
    // OpenGL's axes are those of OpenCV with y and z reversed.
    for (row, sign) in [(0, 1.0), (1, -1.0), (2, -1.0)] {
        for column in 0..4 {
            let at = |convention: &str| number(&header[convention]["world_to_camera"][row][column]);
            assert_eq!(at("opengl"), sign * at("opencv"));
        }
    }
    // The position of the camera.
    let column: Vec<f64> = (0..3).map(|row| number(&header["opencv"]["camera_to_world"][row][3])).collect();
    assert_eq!(column, [1.0, 2.0, 4.0]);
}
