//! `turner explain`: the parts of a sample are its sum, and the sum is the picture's.

use serde_json::Value;

use crate::common::{Folder, folder, pixels};

const GLASS: &str = r#"
integrator = { type = "path", rr_start = 1 }
camera = { position = [0, 1.5, 5], look_at = [0, 0.8, 0], fov = 40 }
film = { width = 24, height = 16 }
[material.floor]
type = "matte"
color = 0.6
[material.glass]
type = "principled"
transmission_weight = 1
specular_roughness = 0
transmission_color = [0.6, 0.9, 0.7]
transmission_depth = 1
[[object]]
type = "plane"
material = "floor"
[[object]]
type = "sphere"
center = [0, 1, 0]
material = "glass"
[[object]]
type = "box"
min = [-1, 3, -1]
max = [1, 3.2, 1]
material = { type = "emissive", strength = 8 }
[[light]]
type = "environment"
"#;

fn explain(f: &Folder, pixel: &str, more: &[&str]) -> Value {
    let args = ["explain", "g.toml", "--pixel", pixel, "--json"];
    serde_json::from_str(&f.turner(&[&args[..], more].concat()).ok().stdout).unwrap()
}

fn color(v: &Value) -> [f32; 3] {
    let v: Vec<f32> = v.as_array().unwrap().iter().map(|c| c.as_f64().unwrap() as f32).collect();
    v.try_into().unwrap()
}

#[test]
fn the_parts_sum_to_the_pixel_of_the_picture() {
    let f = folder();
    f.write("g.toml", GLASS);
    f.turner(&["g.toml", "-o", "g.exr"]).ok();
    let (width, _, picture) = pixels(&f.read("g.exr"));
    let mut through_glass = false;
    for (x, y) in [(12, 7), (10, 9), (3, 12), (20, 2), (13, 12), (12, 5)] {
        let path = explain(&f, &format!("{x},{y}"), &[]);
        let vertices = path["vertices"].as_array().unwrap();
        let parts = vertices.iter().flat_map(|v| [&v["emission"], &v["light"]]).chain([&path["escape"]]);
        let sum = parts.filter(|p| p.is_object()).fold([0f32; 3], |sum, part| {
            let c = color(&part["contribution"]);
            [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]]
        });
        assert_eq!(sum.map(f32::to_bits), color(&path["radiance"]).map(f32::to_bits), "{x},{y}: {path}");
        assert_eq!(sum, color(&path["sum"]));
        assert_eq!(sum, picture[(y * width + x) as usize], "{x},{y}");
        assert_eq!((&path["exact"], &path["samples_per_pixel"]), (&true.into(), &1.into()));
        for v in vertices {
            assert!(v["t"].as_f64().unwrap() > 0.0 && v["primitive"].is_u64());
            through_glass |= v["material"]["name"] == "glass" && v["transmittance"].is_array();
        }
    }
    assert!(through_glass);
}

#[test]
fn the_text_names_what_was_met_and_shows_the_sum() {
    let f = folder();
    f.write("g.toml", GLASS);
    let options = ["--samples", "16", "--antialias", "monte-carlo"];
    let args = ["explain", "g.toml", "--pixel", "12,7", "--sample", "5"];
    let text = f.turner(&[&args[..], &options].concat()).ok().stdout;
    for word in [
        "g.toml: pixel 12,7, sample 5 of 16, integrator \"path\"",
        "\"glass\", outside",
        "\"glass\", inside",
        "throughput [1, 1, 1]",
        "clear transmission",
        "eta 0.66",
        "MIS weight",
        "end: ",
        "equal to the last bit",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let args = ["--sample", "5", "--samples", "16", "--antialias", "monte-carlo"];
    let json = explain(&f, "12,7", &args);
    let [r, g, b] = color(&json["radiance"]);
    assert!(text.contains(&format!("sample as rendered   [{r}, {g}, {b}]")), "{text}");
    // Another sample goes another way.
    let args = ["--sample", "6", "--samples", "16", "--antialias", "monte-carlo"];
    assert_ne!(json["camera"], explain(&f, "12,7", &args)["camera"]);
    // So does one of another integrator.
    let direct = explain(&f, "12,7", &["--integrator", "direct"]);
    assert_eq!((&direct["integrator"], &direct["exact"]), (&"direct".into(), &true.into()));
}

#[test]
fn what_cannot_be_explained_is_said() {
    let f = folder();
    f.write("g.toml", GLASS);
    let fails = |args: &[&str], words: &[&str]| {
        f.turner(&[&["explain"], args].concat()).fails(2, words);
    };
    fails(&["g.toml", "--pixel", "24,0"], &["E0105", "g.toml", "no pixel in column 24, row 0", "24x16"]);
    fails(&["g.toml", "--pixel", "0,0", "--sample", "1"], &["E0105", "no sample 1", "one sample, number 0"]);
    fails(&["g.toml", "--pixel", "0"], &["two whole numbers"]);
    fails(&["g.toml", "--pixel", "-1,2"], &["X,Y"]);
    fails(&["g.toml"], &["--pixel"]);
    // `s.toml` is rendered by the classic integrator.
    fails(
        &["s.toml", "--pixel", "0,0"],
        &["E0107", "classic", "\"path\" and \"direct\"", "--integrator path"],
    );
    let adaptive = ["g.toml", "--pixel", "0,0", "--antialias", "adaptive"];
    fails(&adaptive, &["E0105", "have no numbers"]);
    let run = f.turner(&["explain", "g.toml", "--pixel", "99,0", "--json"]).fails(2, &["E0105"]);
    assert_eq!(run.stderr, "");
    assert_eq!(serde_json::from_str::<Value>(&run.stdout).unwrap()["event"], "error");
}
