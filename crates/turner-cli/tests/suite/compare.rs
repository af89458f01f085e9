//! `turner compare`: metrics against reference implementations, exit codes, output.

use std::path::{Path, PathBuf};

use serde_json::Value;
use turner::compare::{Canvas, Metric, Pair};
use turner::image::{Image, Pixels};
use turner_io::image::{DecodeLimits, Display, ImageFormat, OutputImage, Transfer, decode, encode, exr};

use crate::common::{Folder, folder, pixels};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/compare")
}

fn data_file(name: &str) -> String {
    data().join(name).to_str().unwrap().to_owned()
}

fn canvas(name: &str) -> Canvas {
    let bytes = std::fs::read(data().join(name)).unwrap();
    let limits = DecodeLimits::default();
    if name.ends_with(".exr") {
        return Canvas::new(&exr::decode_as_stored(&bytes, name, &limits).unwrap(), true);
    }
    Canvas::new(&decode(&bytes, name, &limits).unwrap(), false)
}

/// values.json is the output of reference_values.py in the same folder, which names the programs used.
#[test]
fn flip_and_ssim_are_those_of_their_authors() {
    let text = std::fs::read_to_string(data().join("values.json")).unwrap();
    let values: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(values.len(), 5);
    for value in &values {
        let name = |key: &str| value[key].as_str().unwrap();
        let pair = Pair::new(canvas(name("a")), canvas(name("b"))).unwrap();
        let (found, flip) = (Metric::Flip.measure(&pair, 2), &value["flip"]);
        let off = |a: f64, b: &Value| (a - b.as_f64().unwrap()).abs();
        assert!(off(found.value, &flip["mean"]) < 1e-4, "{value}: {}", found.value);
        assert_eq!(
            (found.worst.x, found.worst.y),
            (flip["worst"][0].as_u64().unwrap() as u32, flip["worst"][1].as_u64().unwrap() as u32)
        );
        let width = pair.width as usize;
        let rows = found.map.chunks_exact(width).step_by(5);
        let sample: Vec<f32> = rows.flat_map(|row| row.iter().step_by(7).copied()).collect();
        let expected = flip["sample"].as_array().unwrap();
        assert_eq!(sample.len(), expected.len());
        let worst = sample.iter().zip(expected).map(|(v, e)| off(f64::from(*v), e)).fold(0.0, f64::max);
        assert!(worst < 1e-4, "{} {}: {worst}", name("a"), name("b"));
        if pair.is_linear {
            let stops = turner::compare::flip::exposures(&pair);
            assert_eq!(stops.len() as u64, flip["exposures"].as_u64().unwrap());
        } else {
            let ssim = Metric::Ssim.measure(&pair, 2).value;
            assert!(off(ssim, &value["ssim"]) < 1e-6, "{value}: {ssim}");
        }
    }
}

fn json(f: &Folder, args: &[&str]) -> (Option<i32>, Value) {
    let run = f.turner(&[&["compare", "--json"][..], args].concat());
    let value = serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e}: {run:?}"));
    (run.code, value)
}

#[test]
fn the_exit_code_is_the_verdict() {
    let f = folder();
    let (a, b) = (data_file("reference.png"), data_file("noisy.png"));
    // Without a tolerance there is no verdict.
    let (code, all) = json(&f, &[&a, &b]);
    assert_eq!((code, &all["verdict"]), (Some(0), &Value::Null));
    assert_eq!((&all["width"], &all["values"]), (&Value::from(96), &Value::from("display")));
    let metrics = all["metrics"].as_object().unwrap();
    assert_eq!(metrics.len(), Metric::ALL.len());
    for metric in Metric::ALL {
        let found = metrics[metric.word()]["value"].as_f64().unwrap();
        let at = |factor: f64| (found * factor).to_string();
        // Ten percent above and below the value.
        let (good, bad) = if metric.is_similarity() { (0.9, 1.1) } else { (1.1, 0.9) };
        let judge =
            |tolerance: f64| json(&f, &["--metric", metric.word(), "--tolerance", &at(tolerance), &a, &b]);
        let (code, one) = judge(good);
        assert_eq!((code, &one["verdict"]["within"]), (Some(0), &Value::Bool(true)), "{one}");
        assert_eq!(one["metrics"].as_object().unwrap().len(), 1);
        let (code, one) = judge(bad);
        assert_eq!((code, &one["verdict"]["within"]), (Some(1), &Value::Bool(false)), "{one}");
    }
    let past = f.turner(&["compare", &a, &b, "--tolerance", "0.05"]);
    past.fails(1, &["beyond the tolerance: FLIP 0.067", "at most 0.05", "column 38, row 22"]);
    let within = f.turner(&["compare", &a, &b, "--tolerance", "0.07"]).ok();
    assert!(within.stdout.contains("within the tolerance: FLIP"), "{within:?}");
    let same = f.turner(&["compare", &a, &a, "--tolerance", "0"]).ok();
    assert!(same.stdout.contains("no difference"), "{same:?}");
    for bad in ["-1", "nan", "inf", "much"] {
        f.turner(&["compare", &a, &b, &format!("--tolerance={bad}")]).fails(2, &["0 or more"]);
        f.turner(&["compare", &a, &b, "--tolerance", bad]).fails(2, &["0 or more"]);
    }
    f.turner(&["compare", &a, &b, "--metric", "flop"]).fails(2, &["flip"]);
}

#[test]
fn differences_are_drawn() {
    let f = folder();
    let (a, b) = (data_file("reference.exr"), data_file("noisy.exr"));
    let (code, found) = json(&f, &[&a, &b, "--diff", "d.png", "--metric", "max"]);
    assert_eq!((code, found["diff"]["file"].as_str()), (Some(0), Some("d.png")));
    let worst = &found["metrics"]["max"]["worst"];
    assert_eq!(found["diff"]["maximum"], worst["value"]);
    let (width, height, drawn) = pixels(&f.read("d.png"));
    assert_eq!((width, height), (96, 64));
    let at = |x: &Value, y: &Value| drawn[(y.as_u64().unwrap() * 96 + x.as_u64().unwrap()) as usize];
    // The worst pixel has the brightest colour.
    assert_eq!(at(&worst["x"], &worst["y"]), [252.0 / 255.0, 253.0 / 255.0, 191.0 / 255.0]);
    let same = f.turner(&["compare", &a, &a, "--diff", "d.png"]).ok();
    assert!(same.stdout.contains("d.png: FLIP"), "{same:?}");
    assert!(pixels(&f.read("d.png")).2.iter().all(|c| c[2] < 0.02), "black");
    // The result does not depend on the number of threads.
    f.turner(&["compare", &a, &b, "--diff", "1.png", "--threads", "1"]).ok();
    f.turner(&["compare", &a, &b, "--diff", "3.png", "--threads", "3"]).ok();
    assert_eq!(f.read("1.png"), f.read("3.png"));

    std::fs::write(f.path().join("own.png"), std::fs::read(data().join("noisy.png")).unwrap()).unwrap();
    let args = |diff: &'static str| ["compare", "own.png", "own.png", "--diff", diff];
    f.turner(&args("own.png")).fails(2, &["E0401", "one of the compared pictures"]);
    f.turner(&args("d.exr")).fails(2, &["E0401", ".png"]);
    f.turner(&args("none/d.png")).fails(1, &["E0401", "none"]);
    assert!(!f.names().iter().any(|n| n.ends_with(".tmp")), "{:?}", f.names());
}

fn write(f: &Folder, name: &str, samples: &[[f32; 4]], width: u32) {
    let bytes: Vec<[u8; 4]> = samples.iter().map(|p| p.map(|v| (v.clamp(0.0, 1.0) * 255.0) as u8)).collect();
    let image = OutputImage {
        width,
        height: samples.len() as u32 / width,
        alpha: samples.iter().any(|p| p[3] != 1.0),
        linear: Some(samples),
        display: Some(Display::U8(&bytes)),
        transfer: Transfer::Unstated,
        metadata: &Default::default(),
        threads: 1,
        ..OutputImage::default()
    };
    let format = ImageFormat::of_path(Path::new(name)).unwrap();
    std::fs::write(f.path().join(name), encode(&image, format).unwrap()).unwrap();
}

#[test]
fn what_cannot_be_compared_is_said() {
    let f = folder();
    write(&f, "a.exr", &[[0.5, 0.5, 0.5, 1.0]; 6], 3);
    write(&f, "tall.exr", &[[0.5, 0.5, 0.5, 1.0]; 6], 2);
    write(&f, "clear.exr", &[[0.5, 0.5, 0.5, 0.5]; 6], 3);
    write(&f, "a.png", &[[0.5, 0.5, 0.5, 1.0]; 6], 3);
    write(&f, "a.hdr", &[[0.5, 0.5, 0.5, 1.0]; 6], 3);
    f.turner(&["compare", "a.exr", "tall.exr"])
        .fails(1, &["E0202", "tall.exr: 2x3 pixels, expected 3x2 as in a.exr"]);
    f.turner(&["compare", "a.exr", "clear.exr"])
        .fails(1, &["E0202", "clear.exr: partly transparent", "background"]);
    f.turner(&["compare", "a.png", "a.exr"]).fails(1, &["E0202", "a.exr: linear light", "two EXR"]);
    f.turner(&["compare", "a.exr", "b.exr"]).fails(1, &["E0201", "b.exr", "nearest is \"a.exr\""]);
    f.turner(&["compare", "a.exr", "."]).fails(1, &["E0201"]);
    f.write("text.png", "no picture");
    f.turner(&["compare", "a.exr", "text.png"]).fails(1, &["E0202", "text.png"]);
    let events =
        f.turner(&["compare", "a.exr", "tall.exr", "--json"]).fails(1, &["\"event\":\"error\"", "E0202"]);
    assert_eq!(events.stdout.lines().count(), 1);
    // Formats may differ if their values have the same meaning.
    f.turner(&["compare", "a.exr", "a.hdr", "--metric", "max", "--tolerance", "0.004"]).ok();
    f.turner(&["compare", "clear.exr", "clear.exr", "--tolerance", "0"]).ok();
}

#[test]
fn non_finite_pixels_are_counted_and_must_agree() {
    let f = folder();
    let grey = [[0.5, 0.5, 0.5, 1.0]; 6];
    let mut bad = grey;
    bad[4][1] = f32::NAN;
    bad[5][0] = f32::INFINITY;
    write(&f, "a.exr", &grey, 3);
    write(&f, "b.exr", &bad, 3);
    let (code, found) = json(&f, &["a.exr", "b.exr"]);
    assert_eq!(code, Some(0));
    assert_eq!(found["non_finite"]["reference"]["count"], 0);
    assert_eq!(found["non_finite"]["picture"]["count"], 2);
    assert_eq!(found["non_finite"]["picture"]["first"], serde_json::json!({ "x": 1, "y": 1 }));
    let run = f.turner(&["compare", "a.exr", "b.exr", "--metric", "rmse", "--tolerance", "1"]);
    run.fails(1, &["beyond the tolerance", "2 pixels", "column 1, row 1"]);
    f.turner(&["compare", "b.exr", "b.exr", "--tolerance", "0"]).ok();
}

#[test]
fn grey_pictures_compare_as_colour() {
    let grey = Image { width: 2, height: 1, channels: 1, pixels: Pixels::U8(vec![51, 255]) };
    let color =
        Image { width: 2, height: 1, channels: 3, pixels: Pixels::U8(vec![51, 51, 51, 255, 255, 255]) };
    let pair = Pair::new(Canvas::new(&grey, false), Canvas::new(&color, false)).unwrap();
    assert_eq!(Metric::Max.measure(&pair, 1).value, 0.0);
}
