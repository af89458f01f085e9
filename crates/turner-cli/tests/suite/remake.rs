//! Headers that remake a picture, and `turner remake`.

use std::collections::BTreeMap;

use turner_io::image::{Display, ImageFormat, Metadata, OutputImage, encode, read_metadata};

use crate::common::{SCENE, folder};
use crate::folder::Folder;

fn header(f: &Folder, name: &str) -> BTreeMap<String, String> {
    let metadata = read_metadata(&f.read(name), name).unwrap();
    metadata.into_iter().map(|(key, value)| (key, value.to_string())).collect()
}

#[test]
fn a_header_is_text_for_people() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png", "--seed", "7", "--max-depth", "2", "--dither"]).ok();
    f.turner(&["./s.toml", "-o", "a.exr", "--max-depth", "2", "--threads", "1", "--seed", "7"]).ok();
    for name in ["a.png", "a.exr"] {
        let header = header(&f, name);
        assert_eq!(header["turner:scene"], "s.toml");
        assert_eq!(header["turner:film"], "width = 24\nheight = 16\nseed = 7\n");
        assert_eq!(header["turner:integrator"], "type = \"classic\"\nmax_depth = 2\n");
        assert!(
            header.values().all(|value| !value.contains("Desc") && !value.contains("Some(")),
            "{header:?}"
        );
        let camera: serde_json::Value = serde_json::from_str(&header["turner:camera"]).unwrap();
        assert_eq!(camera["model"], "perspective");
    }
    assert_eq!(header(&f, "a.png")["turner:command"], r#"["--dither","--max-depth=2","--seed=7"]"#);
    assert_eq!(header(&f, "a.exr")["turner:command"], r#"["--max-depth=2","--seed=7"]"#);
    // The view shows all of it, a line each.
    let view = f.turner(&["view", "a.exr", "--no-preview"]).ok().stdout;
    assert!(
        view.contains("max_depth = 2\n") && view.contains("world_to_camera") && !view.contains('…'),
        "{view}"
    );
    // Absolute paths, threads and the quality of the tree are not in it.
    let scene = f.path().join("s.toml").to_string_lossy().into_owned();
    f.turner(&[&scene, "-o", "b.exr", "--seed", "7", "--max-depth", "2", "--bvh-quality", "fast"]).ok();
    assert!(f.read("a.exr") == f.read("b.exr"));
}

#[test]
fn a_picture_is_remade() {
    let f = folder();
    let path = ["--integrator", "path", "--samples", "3"];
    for (name, options) in [
        ("a.png", &["--exposure", "-1", "--dither"][..]),
        ("b.exr", &["--crop", "3,2,9,8", "--bit-depth", "16", "--exr-compression", "piz"]),
        ("c.exr", &[&path[..], &["--aov", "depth,object_id", "-D", "object.0.radius=0.8"]].concat()),
        ("d.png", &[&path[..], &["--aov", "normal", "--width", "10"]].concat()),
        ("e.png", &["--integrator", "ids"]),
        ("f.png", &[&path[..], &["--sample-range", "1..3", "--checkpoint", "p.turner-checkpoint"]].concat()),
    ] {
        f.turner(&[&["s.toml", "-o", name][..], options].concat()).ok();
        let before = f.names();
        let run = f.turner(&["remake", name]).ok();
        assert!(run.stderr.ends_with(&format!("{name}: the same bytes\n")), "{run:?}");
        assert_eq!(f.names(), before);
    }
    // The file of the AOVs beside a picture.
    f.turner(&["remake", "d.exr"]).ok();
    f.turner(&["remake", "b.exr", "-o", "new.exr", "--threads", "1"]).ok();
    assert!(f.read("new.exr") == f.read("b.exr"));
    // Display values of an EXR file.
    f.turner(&["s.toml", "-o", "g.exr", "--exr-compression", "none"]).ok();
    f.turner(&["tonemap", "g.exr", "g.png", "--bit-depth", "16"]).ok();
    f.turner(&["remake", "g.png"]).ok();
    f.turner(&["tonemap", "g.exr", "h.png", "--exposure", "1"]).ok();
    f.turner(&["remake", "h.png"]).fails(1, &["turner:command", "does not say how"]);
}

#[test]
fn pictures_of_sequences_are_remade() {
    let f = folder();
    f.turner(&["s.toml", "--turntable", "3", "-o", "t_#.exr"]).ok();
    f.turner(&["s.toml", "--frames", "1-2", "--fps", "10", "-o", "f_#.png"]).ok();
    for name in ["t_0.exr", "t_1.exr", "t_2.exr", "f_2.png"] {
        f.turner(&["remake", name]).ok();
    }
    assert_eq!(header(&f, "t_2.exr")["turner:step"], "2");
    let camera = |name: &str| header(&f, name)["turner:camera"].clone();
    assert_ne!(camera("t_0.exr"), camera("t_2.exr"));
    // A frame is the same in any sequence, and alone.
    f.turner(&["s.toml", "--frame", "2", "--fps", "10", "-o", "alone.png"]).ok();
    assert!(f.read("alone.png") == f.read("f_2.png"));
    let again = f.turner(&["s.toml", "--turntable", "3", "-o", "t_#.exr", "--resume"]).ok();
    assert_eq!(again.stderr.matches("complete, skipped").count(), 3, "{again:?}");
}

#[test]
fn differences_are_named() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png"]).ok();
    f.turner(&["remake", "a.png", "-o", "a.png"]).fails(2, &["is the picture to render again"]);
    f.turner(&["remake", "a.png", "-o", "b.exr"]).fails(2, &["a.png is PNG", ".png"]);
    f.write("s.toml", &SCENE.replace("height = 16", "height = 16\nseed = 5"));
    let run = f.turner(&["remake", "a.png"]);
    run.fails(1, &["E0107", "its hash was", "[film] had `its default` and has `seed = 5`", "--anyway"]);
    let run = f.turner(&["remake", "a.png", "--anyway", "--json"]).ok();
    assert!(
        run.stdout.contains(r#""same_bytes":false"#) && run.stdout.contains(r#""same_pixels":true"#),
        "{run:?}"
    );
    f.turner(&["remake", "a.png", "--anyway"]).ok();
    f.write("s.toml", &SCENE.replace("tomato", "blue"));
    let run = f.turner(&["remake", "a.png", "--anyway"]);
    run.fails(1, &["a.png: different: ", " of 384, the first in column"]);
    // The scene elsewhere.
    std::fs::create_dir(f.path().join("x")).unwrap();
    std::fs::rename(f.path().join("a.png"), f.path().join("x/a.png")).unwrap();
    std::fs::remove_file(f.path().join("s.toml")).unwrap();
    f.turner(&["remake", "x/a.png"]).fails(1, &["its scene s.toml does not exist here", "--scene"]);
    f.write("other.toml", SCENE);
    f.turner(&["remake", "x/a.png", "--scene", "other.toml"]).ok();
    f.write("x/s.toml", SCENE);
    f.turner(&["remake", "x/a.png"]).ok();
}

/// A picture with these metadata.
fn picture(f: &Folder, metadata: &BTreeMap<String, String>) {
    let metadata: Metadata = metadata.iter().map(|(k, v)| (k.clone(), v.as_str().into())).collect();
    let image = OutputImage {
        width: 1,
        height: 1,
        display: Some(Display::U8(&[[0; 4]])),
        metadata: &metadata,
        ..OutputImage::default()
    };
    std::fs::write(f.path().join("bad.png"), encode(&image, ImageFormat::Png).unwrap()).unwrap();
}

#[test]
fn a_hostile_header_decides_nothing_else() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png"]).ok();
    let good = header(&f, "a.png");
    let with = |key: &str, value: &str| {
        let mut all = good.clone();
        all.insert(key.to_owned(), value.to_owned());
        picture(&f, &all);
        f.turner(&["remake", "bad.png"])
    };
    for command in [
        r#"["--output=s.toml"]"#,
        r#"["-o","s.toml"]"#,
        r#"["--allow-outside"]"#,
        r#"["--checkpoint=s.toml"]"#,
    ] {
        with("turner:command", command).fails(1, &["bad.png: turner:command has `-", "does not record"]);
    }
    with("turner:command", "{").fails(1, &["expected a JSON array"]);
    with("turner:command", r#"["--samples=x"]"#).fails(1, &["bad.png: turner:command", "--samples"]);
    with("turner:command", r#"["--environment=/etc/passwd"]"#).fails(1, &["environment map"]);
    with("turner:command", r#"["--turntable=9"]"#).fails(1, &["turner:step is `none`"]);
    with("turner:step", "99").fails(1, &["turner:step is `99`"]);
    with("turner:step", "-1").fails(1, &["expected a number"]);
    with("turner:scene", "/etc/passwd").fails(1, &["its scene /etc/passwd does not exist here"]);
    with("turner:sampleRange", "9").fails(1, &["turner:sampleRange is `9`"]);
    with("turner:finished", "0.5").fails(1, &["unfinished", "turner resume"]);
    with("Software", "Turner 0.0.0").fails(1, &["written by Turner 0.0.0", "--anyway"]);
    picture(&f, &BTreeMap::new());
    f.turner(&["remake", "bad.png"]).fails(1, &["does not say how it was rendered"]);
    f.turner(&["remake", "s.toml"]).fails(1, &["s.toml"]);
    assert_eq!(String::from_utf8(f.read("s.toml")).unwrap(), SCENE);
}
