//! `turner-lab povray` and `antialias`: another renderer alternates with Turner.
#![cfg(unix)]

use serde_json::Value;

use crate::folder::Folder;

const SCENE: &str = "[camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\n[film]\nwidth = 12\nheight = 8\n\
    [background]\ncolor = [0.2, 0.3, 0.5]\n[[object]]\ntype = \"sphere\"\n[[light]]\ntype = \"point\"\nposition = [3, 4, 5]\n";

/// A script that prints POV-Ray's report and writes an image.
fn povray(f: &Folder, says: &str) -> String {
    let black = turner_io::image::OutputImage {
        width: 12,
        height: 8,
        alpha: false,
        display: Some(turner_io::image::Display::U8(&[[0; 4]; 96])),
        transfer: turner_io::image::Transfer::Unstated,
        metadata: &Default::default(),
        threads: 1,
        ..turner_io::image::OutputImage::default()
    };
    let png = turner_io::image::encode(&black, turner_io::image::ImageFormat::Png).unwrap();
    std::fs::write(f.path().join("black.png"), png).unwrap();
    let from = f.path().join("black.png");
    let body = format!(
        "for a in \"$@\"; do case $a in +O*) cp '{}' \"${{a#+O}}\";; esac; done\necho '{says}' >&2",
        from.display()
    );
    f.script("povray", &body)
}

const TIME: &str = "  Trace Time:       0 hours  0 minutes  2 seconds (2.500 seconds)";

fn bench_folder() -> Folder {
    let f = Folder::new();
    std::fs::create_dir(f.path().join("bench")).unwrap();
    f.write("bench/ball.toml", SCENE);
    f.write("bench/alone.toml", SCENE);
    f.write("bench/ball.pov", "");
    f
}

#[test]
fn povray_times_are_reported() {
    let f = bench_folder();
    let program = povray(&f, TIME);
    let args = ["povray", "--dir", "bench", "--repeat", "2", "--threads", "1", "--program", &program];
    let run = f.lab(&[&args[..], &["--json"]].concat()).ok();
    let lines: Vec<Value> = run.stdout.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(
        (&lines[0]["scene"], lines[0]["povray_median_seconds"].is_null()),
        (&Value::from("alone"), true)
    );
    assert_eq!(lines[1]["povray_seconds"], serde_json::json!([2.5, 2.5]));
    let ratio = lines[1]["povray_ratio"].as_f64().unwrap() * lines[1]["median_seconds"].as_f64().unwrap();
    assert!((ratio - 2.5).abs() < 1e-9, "{ratio}");
    let text = f.lab(&args).ok().stdout;
    assert!(text.contains("POV-Ray   ratio") && text.contains("2.50 s"), "{text}");
    f.lab(&["povray", "--dir", "bench", "ball", "--program", "no-such-program"])
        .fails(1, &["no-such-program cannot be run", "--program"]);
    let silent = povray(&f, "nothing to say");
    f.lab(&["povray", "--dir", "bench", "ball", "--program", &silent]).fails(1, &["Trace Time"]);
}

#[test]
fn anti_aliasing_modes_are_compared() {
    let f = bench_folder();
    let program = povray(&f, TIME);
    let args = ["--samples", "4", "--reference", "4", "--repeat", "1", "--program", &program, "--json"];
    let run = f.lab(&[&["antialias", "bench/ball.toml"], &args[..]].concat()).ok();
    let lines: Vec<Value> = run.stdout.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(lines.len(), 5 + 3, "{}", run.stdout);
    assert_eq!(lines[7]["mode"], "POV-Ray 16 samples");
    assert_eq!(lines[7]["median_seconds"], 2.5);
    // A black image has a large error.
    assert!(
        lines[7]["rmse"].as_f64().unwrap() > 0.1 && lines[4]["rmse"].as_f64().unwrap() < 0.1,
        "{}",
        run.stdout
    );
    f.lab(&["antialias", "bench/alone.toml"]).fails(1, &["no .pov file next to it"]);
}
