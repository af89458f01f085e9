//! `turner-lab render`: errors fall, tables and plots are written, other renderers take part.

use std::sync::atomic::AtomicBool;

use serde_json::Value;
use turner::render::{PassOptions, Renderer};
use turner::schema::PrepareOptions;
use turner_io::image::{ImageFormat, OutputImage, Transfer, encode};
use turner_io::scene::{LoadOptions, load};

use crate::folder::Folder;

/// A small scene: a plane, a sphere and a spherical area light.
const TINY: &str = r#"
[camera]
position = [0, 1, 4]
look_at = [0, 0.5, 0]

[integrator]
type = "path"

[film]
width = 16
height = 16
antialias = "monte-carlo"
samples = 1024

[[object]]
type = "plane"
material = { type = "matte", color = [0.5, 0.5, 0.5] }

[[object]]
type = "sphere"
center = [0, 0.5, 0]
radius = 0.5
material = { type = "matte", color = [0.8, 0.3, 0.2] }

[[object]]
type = "sphere"
center = [1, 2, 1]
radius = 0.3
material = { type = "emissive", color = [20, 20, 20] }
"#;

fn tiny() -> Folder {
    let f = Folder::new();
    f.write("tiny.toml", TINY);
    f
}

/// Renders the scene into a file, with `width` columns and rows.
fn picture(f: &Folder, name: &str, width: u32, samples: u32) {
    let loaded = load(&f.path().join("tiny.toml"), &LoadOptions::default()).unwrap();
    let mut desc = loaded.desc;
    (desc.film.width, desc.film.height, desc.film.samples) = (width, width, samples);
    let scene = desc.prepare(&PrepareOptions::default()).unwrap();
    let mut renderer = Renderer::new(scene).unwrap();
    let never = AtomicBool::new(false);
    renderer.pass(u32::MAX, &PassOptions { threads: 2, cancel: &never, progress: None }).unwrap();
    let picture = renderer.film.develop(&renderer.prepared().view.film, 0);
    let image = OutputImage {
        width,
        height: width,
        alpha: false,
        linear: Some(&picture.linear),
        transfer: Transfer::Unstated,
        metadata: &Default::default(),
        threads: 1,
        ..OutputImage::default()
    };
    std::fs::write(f.path().join(name), encode(&image, ImageFormat::Exr).unwrap()).unwrap();
}

/// With a converged image, named in upper case, in its own folder.
fn with_reference() -> Folder {
    let f = tiny();
    std::fs::create_dir(f.path().join("refs")).unwrap();
    picture(&f, "refs/TINY.exr", 16, 1024);
    f
}

fn json(text: &str) -> Vec<Value> {
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn errors_fall_with_samples() {
    let f = with_reference();
    let args = ["render", "tiny.toml", "--references", "refs", "--samples", "16,1,4", "--runs", "2"];
    let run = f.lab(&[&args[..], &["--threads", "1", "--json", "--plot", "error.svg"]].concat()).ok();
    let lines = json(&run.stdout);
    assert_eq!(lines.len(), 4, "{}", run.stdout);
    let errors: Vec<f64> = lines[..3].iter().map(|l| l["relmse"].as_f64().unwrap()).collect();
    assert!(errors[0] > 2.0 * errors[1] && errors[1] > 2.0 * errors[2], "{errors:?}");
    assert_eq!(lines[2]["samples"], 16);
    assert_eq!(lines[2]["seconds"].as_array().unwrap().len(), 2);
    assert!(lines[3]["start_seconds"].as_f64().unwrap() > 0.0);
    let plot = String::from_utf8(f.read("error.svg")).unwrap();
    assert!(plot.starts_with("<svg") && plot.matches("<circle").count() == 3, "{plot}");

    // The reference's own noise is subtracted; if nothing is left, the error is unknown.
    f.write("refs/refs.json", r#"{ "tiny": { "own_noise": 0.9 } }"#);
    let noisy = json(&f.lab(&[&args[..], &["--json"]].concat()).ok().stdout);
    assert_eq!(noisy[2]["relmse"], Value::Null);
    f.write("refs/refs.json", r#"{ "tiny": { "own_noise": "much" } }"#);
    f.lab(&args).fails(1, &["refs.json", "own_noise of tiny"]);
}

#[test]
fn tables_show_unknown_errors() {
    let f = tiny();
    let short = ["render", "tiny.toml", "--samples", "1,2", "--runs", "1"];
    let run = f.lab(&short).ok();
    assert!(run.stdout.contains("relMSE 0.001") && run.stdout.contains("tiny 16x16"), "{}", run.stdout);
    assert!(run.stderr.contains("--references"), "{}", run.stderr);
    let run = f.lab(&[&short[..], &["--markdown"]].concat()).ok();
    assert!(run.stdout.starts_with("| scene |") && run.stdout.lines().count() == 3, "{}", run.stdout);
    f.lab(&[&short[..], &["--references", "."]].concat()).fails(2, &["there is no reference image tiny.exr"]);
    picture(&f, "tiny.exr", 8, 1);
    f.lab(&[&short[..], &["--references", "tiny.exr"]].concat())
        .fails(1, &["8x8 pixels, the scene has 16x16"]);
    // The image next to the scene was not requested, so its size is only a remark.
    assert!(f.lab(&short).ok().stderr.contains("8x8 pixels"));
    f.lab(&["render"]).fails(2, &["scenes/peers"]);
    f.lab(&["render", "--peers", "arnold"]).fails(2, &["mitsuba-llvm"]);
}

#[cfg(unix)]
#[test]
fn other_renderers_alternate() {
    let f = with_reference();
    f.write("tiny.json", "{}");
    let answers = r#"echo '{"start_seconds": 2.5, "version": "1.2"}'
while read samples seed file; do
    head -c 3072 /dev/zero > "$file"
    echo "{\"samples\": $samples, \"seconds\": 0.5, \"width\": 16, \"height\": 16}"
done"#;
    let run = |program: &str, more: &[&str]| {
        let args = ["render", "tiny.toml", "--references", "refs/TINY.exr", "--samples", "1,2"];
        f.lab(&[&args[..], &["--peers", "cycles", "--python", program], more].concat())
    };
    let black = f.script("black", answers);
    let lines = json(&run(&black, &["--json"]).ok().stdout);
    let of_peer: Vec<_> = lines.iter().filter(|l| l["renderer"] == "cycles").collect();
    assert_eq!(of_peer.len(), 3);
    assert_eq!(of_peer[1]["median_seconds"], 0.5);
    assert_eq!(of_peer[2]["start_seconds"], 2.5);
    // The error of a black image does not fall.
    let error = of_peer[0]["relmse"].as_f64().unwrap();
    assert!(error > 0.05 && of_peer[1]["relmse"] == error, "{of_peer:?}");
    assert!(of_peer[2]["reach"][0]["seconds"].is_null(), "{of_peer:?}");
    assert!(run(&black, &["--markdown"]).ok().stdout.contains("cycles 1.2 | 2.50 s"));

    // Failures name the renderer.
    let cases = [
        ("echo Error: out of luck >&2", "cycles: the process ended: Error: out of luck"),
        (r#"echo '{"error": "no module", "help": "install it"}'"#, "no module"),
        (&answers.replace("3072", "3071"), "cycles: an incomplete image"),
        (&answers.replace("16, ", "17, "), "17x16 pixels, expected 16x16"),
    ];
    for (i, (body, message)) in cases.iter().enumerate() {
        run(&f.script(&format!("case{i}"), body), &[]).fails(1, &[message]);
    }
    // Turner and the other renderers continue without it.
    let failing = f.script("failing", &answers.replace("done", "[ $samples = 1 ] || exit\ndone"));
    let both =
        run(&failing, &["--json", "--peers", "mitsuba-scalar"]).fails(1, &["cycles: the process ended"]);
    let lines =
        json(&both.stdout.lines().filter(|l| l.contains("\"renderer\"")).collect::<Vec<_>>().join("\n"));
    let pictures =
        |name: &str| lines.iter().filter(|l| l["renderer"] == name && !l["samples"].is_null()).count();
    assert_eq!((pictures("turner"), pictures("cycles"), pictures("mitsuba-scalar")), (2, 1, 1), "{lines:?}");
    run("no-such-python", &[]).fails(1, &["no-such-python cannot be run", "--install-peers"]);
}
