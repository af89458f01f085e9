//! `turner render`: files, formats, streams, exit codes.

use crate::common::{Run, SCENE, folder, pixels};

#[test]
fn a_scene_alone_becomes_a_png_here() {
    let f = folder();
    let run = f.turner(&["s.toml"]).ok();
    assert_eq!(f.names(), ["s.png", "s.toml"]);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert_eq!(lines.len(), 1, "one closing line: {run:?}");
    assert!(lines[0].starts_with("s.png: 24x16, 1 sample per pixel, "), "{}", lines[0]);
    assert!(lines[0].ends_with('s') && !lines[0].contains("non-finite"), "{}", lines[0]);
    assert_eq!(run.stdout, "");
    assert!(!run.stderr.contains('\u{1b}'), "no colours in a pipe");
    let (w, h, p) = pixels(&f.read("s.png"));
    assert_eq!((w, h), (24, 16));
    assert!(p.iter().any(|c| c[0] > 0.5 && c[2] < 0.5), "the ball is seen");
    assert_eq!(f.turner(&["render", "s.toml", "--quiet"]).ok().stderr, "");
}

#[test]
fn formats_go_by_extension() {
    let f = folder();
    for (name, magic) in
        [("a.png", &b"\x89PNG"[..]), ("a.exr", b"\x76\x2f\x31\x01"), ("a.jpg", b"\xff\xd8"), ("a.HDR", b"#?")]
    {
        f.turner(&["s.toml", "-o", name]).ok();
        assert!(f.read(name).starts_with(magic), "{name}");
    }
    f.turner(&["s.toml", "-o", "b.dat", "--format", "exr"]).ok();
    assert!(f.read("b.dat").starts_with(b"\x76\x2f\x31\x01"));
    f.write("v1.2.toml", SCENE);
    f.turner(&["v1.2.toml", "--format", "jpg"]).ok();
    assert!(f.names().contains(&"v1.2.jpg".to_owned()), "{:?}", f.names());
    f.turner(&["s.toml", "-o", "a.gif"]).fails(2, &["E0401", ".gif", ".png"]);
    f.turner(&["s.toml", "-o", "a"]).fails(2, &["no extension"]);
}

#[test]
fn standard_output_and_standard_input() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png"]).ok();
    let output = f.command(&["s.toml", "-o", "-", "--format", "png"]).output().unwrap();
    assert_eq!(output.stdout, f.read("a.png"));
    f.turner(&["s.toml", "-o", "-"]).fails(2, &["--format"]);
    let scene = std::fs::File::open(f.path().join("s.toml")).unwrap();
    let status = f.command(&["-", "-o", "b.png", "--quiet"]).stdin(scene).status().unwrap();
    assert!(status.success());
    assert_eq!(pixels(&f.read("a.png")), pixels(&f.read("b.png")));
    f.turner(&["-"]).fails(2, &["-o FILE"]);
}

#[test]
fn events_are_json_lines() {
    let f = folder();
    let run = f.turner(&["s.toml", "--json"]).ok();
    assert_eq!(run.stderr, "");
    let events: Vec<serde_json::Value> =
        run.stdout.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(events[0]["event"], "start");
    let done = events.last().unwrap();
    assert_eq!(
        (&done["event"], &done["width"], &done["complete"]),
        (&"done".into(), &24.into(), &true.into())
    );
    assert_eq!(done["rays"]["camera"], 24 * 16);
    let sum: u64 = ["camera", "shadow", "reflected", "refracted"]
        .map(|k| done["rays"][k].as_u64().unwrap())
        .iter()
        .sum();
    assert_eq!(done["rays"]["total"], sum);
    for key in ["load", "render", "save"] {
        assert!(done["seconds"][key].as_f64().unwrap() >= 0.0);
    }
    assert_eq!(done["non_finite"]["count"], 0);
    assert_eq!(done["scene_hash"].as_str().unwrap().len(), 32);
    assert_eq!(done["samples"], 24 * 16);
    // With the picture on standard output, events go to standard error.
    let output = f.command(&["s.toml", "--json", "-o", "-", "--format", "png"]).output().unwrap();
    assert!(output.stdout.starts_with(b"\x89PNG"));
    let run = Run::of(output).ok();
    assert!(run.stderr.lines().all(|l| serde_json::from_str::<serde_json::Value>(l).is_ok()), "{run:?}");
    // Errors as well.
    f.write("bad.toml", "[film]\nwidht = 4\n");
    let run = f.turner(&["bad.toml", "--json"]);
    assert_eq!(run.code, Some(1));
    let error: serde_json::Value = serde_json::from_str(run.stdout.trim()).unwrap();
    assert_eq!((&error["event"], &error["code"]), (&"error".into(), &"E0102".into()));
    assert_eq!(
        (&error["file"], &error["line"], &error["column"]),
        (&"bad.toml".into(), &2.into(), &1.into())
    );
    assert!(error["help"].as_str().unwrap().contains("width"));
}

#[test]
fn errors_show_the_place_and_leave_the_old_picture() {
    let f = folder();
    f.write("bad.toml", &SCENE.replace("center = [0, 1, 0]", "centre = [0, 1, 0]"));
    f.write("bad.png", "old");
    let run = f
        .turner(&["bad.toml"])
        .fails(1, &["error[E0102]", "bad.toml:15:1", "centre = [0, 1, 0]", "help:", "center"]);
    assert!(!run.stderr.contains('\u{1b}'));
    assert_eq!(f.read("bad.png"), b"old");
    assert_eq!(f.names(), ["bad.png", "bad.toml", "s.toml"]);
    f.turner(&["none.toml"]).fails(1, &["error[E0201]", "none.toml"]);
}

#[test]
fn an_output_that_cannot_be_written_is_refused_first() {
    let f = folder();
    f.turner(&["s.toml", "-o", "no/where/a.png"]).fails(1, &["error[E0401]", "does not exist"]);
    std::fs::create_dir(f.path().join("dir.png")).unwrap();
    f.turner(&["s.toml", "-o", "dir.png"]).fails(1, &["error[E0401]", "folder"]);
    assert_eq!(f.names(), ["dir.png", "s.toml"], "nothing is left behind");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let f = folder();
    for name in ["a.png", "a.exr"] {
        let mut first = None;
        for threads in ["1", "2", "7", "16"] {
            let args =
                ["s.toml", "-o", name, "--threads", threads, "--antialias", "monte-carlo", "--samples", "20"];
            f.turner(&[&args[..], &["--width", "70", "--height", "50"]].concat()).ok();
            let bytes = f.read(name);
            assert_eq!(first.get_or_insert(bytes.clone()), &bytes, "{name} with {threads} threads");
        }
    }
}

#[test]
fn a_crop_is_a_part_of_the_picture() {
    let f = folder();
    for mode in ["none", "mean", "grid", "adaptive", "monte-carlo"] {
        let args = ["s.toml", "--antialias", mode, "-D", "film.samples=5", "--quiet"];
        for name in ["a.png", "a.exr"] {
            f.turner(&[&args[..], &["-o", name]].concat()).ok();
            let (w, _, full) = pixels(&f.read(name));
            f.turner(&[&args[..], &["-o", name, "--crop", "5,3,12,9"]].concat()).ok();
            let (cw, ch, part) = pixels(&f.read(name));
            assert_eq!((cw, ch), (12, 9));
            for (i, p) in part.iter().enumerate() {
                let (x, y) = (5 + i % 12, 3 + i / 12);
                assert_eq!(*p, full[y * w as usize + x], "{mode} {name} at {x}, {y}");
            }
        }
    }
}

#[test]
fn pictures_say_how_they_were_made() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png", "--seed", "7"]).ok();
    f.turner(&["s.toml", "-o", "a.exr", "--seed", "7"]).ok();
    for name in ["a.png", "a.exr"] {
        let meta = turner_io::image::read_metadata(&f.read(name), name).unwrap();
        let get =
            |key: &str| meta.get(key).unwrap_or_else(|| panic!("{name}: {key} in {meta:?}")).to_string();
        let software = if name == "a.png" { "Software" } else { "turner:software" };
        assert!(get(software).starts_with("Turner "));
        assert_eq!((get("turner:seed"), get("turner:samples")), ("7".into(), "1".into()));
        assert_eq!(get("turner:transfer"), "none");
        assert_eq!(get("turner:sceneHash").len(), 32);
        assert_eq!(get("turner:integrator"), "type = \"classic\"\n");
    }
    let before = f.read("a.png");
    f.turner(&["s.toml", "-o", "a.png", "--seed", "7"]).ok();
    assert_eq!(f.read("a.png"), before, "no times in it");
}

#[test]
fn transparent_backgrounds_have_alpha() {
    let f = folder();
    let channels = |name: &str| {
        let bytes = f.read(name);
        turner_io::image::decode(&bytes, name, &turner_io::image::DecodeLimits::default()).unwrap().channels
    };
    f.turner(&["s.toml", "-o", "a.png"]).ok();
    f.turner(&["s.toml", "-o", "b.png", "-D", "background.transparent=true"]).ok();
    assert_eq!((channels("a.png"), channels("b.png")), (3, 4));
}
