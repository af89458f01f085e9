//! `--denoise` and `--quality`.

use crate::aovs::samples;
use crate::common::folder;
use crate::convert::SCENES;
use crate::folder::{Folder, Run};

fn relmse(f: &Folder, a: &str, b: &str) -> f64 {
    let run = f.turner(&["compare", a, b, "--metric", "relmse", "--json"]).ok();
    let value: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    value["metrics"]["relmse"]["value"].as_f64().unwrap_or_else(|| panic!("{}", run.stdout))
}

#[test]
fn less_noise_with_the_raw_picture_kept() {
    let f = folder();
    let scene = format!("{SCENES}/showcase/cornell-box.toml");
    // Without the lamp, whose edges need more samples.
    let size = ["--width", "64", "--height", "64", "--crop", "8,36,48,24"];
    let render = |output: &str, options: &[&str]| {
        let mut args = vec![scene.as_str(), "-o", output];
        args.extend(size);
        args.extend(options);
        f.turner(&args).ok()
    };
    let clean = render("clean.exr", &["--samples", "8", "--denoise"]);
    assert!(clean.stderr.contains("before denoising"), "{}", clean.stderr);
    let raw = render("raw.exr", &["--samples", "8", "--denoise", "off"]);
    assert!(!raw.stderr.contains("denoising"), "{}", raw.stderr);
    render("reference.exr", &["--samples", "256", "--seed", "7"]);
    let (before, after) = (relmse(&f, "raw.exr", "reference.exr"), relmse(&f, "clean.exr", "reference.exr"));
    assert!(after < 0.5 * before, "{before} {after}");
    for channel in ["R", "G", "B"] {
        let layer = samples(&f, "clean.exr", &format!("raw.{channel}"));
        assert_eq!(layer, samples(&f, "raw.exr", channel));
    }
    // Threads do not change a bit.
    render("one.exr", &["--samples", "8", "--denoise", "--threads", "1"]);
    assert_eq!(samples(&f, "one.exr", "G"), samples(&f, "clean.exr", "G"));
}

#[test]
fn quality_sets_what_no_other_option_sets() {
    let f = folder();
    let line = |options: &[&str]| {
        let mut args =
            vec!["s.toml", "--integrator", "path", "--width", "24", "--height", "16", "-o", "q.png"];
        args.extend(options);
        f.turner(&args).ok().stderr
    };
    let draft = line(&["--quality", "draft"]);
    assert!(draft.contains("4 samples per pixel") && draft.contains("before denoising"), "{draft}");
    let own = line(&["--quality", "draft", "--samples", "5", "--denoise", "off"]);
    assert!(own.contains("5 samples per pixel") && !own.contains("denoising"), "{own}");
}

/// Nothing is rendered, and the remedy names both ways out.
#[test]
fn a_library_that_is_missing_is_told_before_the_first_sample() {
    let f = folder();
    let args = ["s.toml", "--integrator", "path", "--samples", "4", "--denoise", "oidn", "-o", "o.png"];
    let run = |library: &str| Run::of(f.command(&args).env("TURNER_OIDN", library).output().unwrap());
    run("nowhere").fails(1, &["OIDN cannot be loaded", "nowhere", "TURNER_OIDN=FOLDER", "--denoise on"]);
    assert!(!f.path().join("o.png").exists());
    run(".").fails(1, &["OIDN was not found: looked for ./"]);
}

#[test]
fn aovs_of_light_lose_their_noise_when_asked() {
    let f = folder();
    let scene = format!("{SCENES}/showcase/cornell-box.toml");
    let render = |output: &str, options: &[&str]| {
        let mut args = vec![scene.as_str(), "-o", output, "--width", "48", "--height", "48"];
        args.extend(["--samples", "8", "--aov", "indirect,albedo"]);
        args.extend(options);
        f.turner(&args).ok();
    };
    render("kept.exr", &["--denoise"]);
    render("clean.exr", &["--denoise", "--denoise-aovs"]);
    assert_eq!(samples(&f, "kept.exr", "albedo.G"), samples(&f, "clean.exr", "albedo.G"));
    assert_eq!(samples(&f, "kept.exr", "G"), samples(&f, "clean.exr", "G"));
    let [kept, clean] = ["kept.exr", "clean.exr"].map(|file| samples(&f, file, "indirect.G"));
    // The mean difference of neighbours.
    let rough = |v: &[f32]| v.windows(2).map(|v| f64::from((v[0] - v[1]).abs())).sum::<f64>();
    assert!(rough(&clean) < 0.8 * rough(&kept), "{} {}", rough(&clean), rough(&kept));
    let sum = |v: &[f32]| v.iter().map(|v| f64::from(*v)).sum::<f64>();
    assert!((sum(&clean) / sum(&kept) - 1.0).abs() < 0.03, "{} {}", sum(&clean), sum(&kept));
}
