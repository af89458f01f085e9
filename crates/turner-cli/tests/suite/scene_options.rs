//! Options that change the scene: `-D`, `--width`, `--integrator`, `--strict`.

use crate::common::{SCENE, folder, pixels};

#[test]
fn values_are_set_by_path() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png", "-D", "film.width=9", "-D", "object.0.material.color=blue"]).ok();
    let (w, _, p) = pixels(&f.read("a.png"));
    assert_eq!(w, 9);
    assert!(p.iter().any(|c| c[2] > c[0] + 0.1));
    f.turner(&["s.toml", "--width", "8", "--height", "6", "-o", "a.png"]).ok();
    assert_eq!(pixels(&f.read("a.png")).2.len(), 48);
}

#[test]
fn one_side_alone_keeps_the_shape_and_the_part() {
    let f = folder();
    let film =
        |crop: &str| SCENE.replace("width = 24\nheight = 16", &format!("width = 40\nheight = 30\n{crop}"));
    let size = |args: &[&str]| {
        f.turner(&[&["t.toml", "-o", "t.png"][..], args].concat()).ok();
        let (w, h, _) = pixels(&f.read("t.png"));
        (w, h)
    };
    f.write("t.toml", &film(""));
    assert_eq!(size(&["--width", "20"]), (20, 15));
    assert_eq!(size(&["--height", "15"]), (20, 15));
    assert_eq!(size(&["--width", "1"]), (1, 1));
    f.write("t.toml", &film("crop = [20, 10, 10, 20]"));
    assert_eq!(size(&["--width", "20"]), (5, 10));
    assert_eq!(size(&["--width", "20", "--crop", "0,0,20,3"]), (20, 3));
}

#[test]
fn bad_values_are_bad_usage_and_show_the_argument() {
    let f = folder();
    f.turner(&["s.toml", "-D", "film.widht=9"]).fails(2, &["E0102", "-D film.widht=9", "width"]);
    f.turner(&["s.toml", "-D", "film"]).fails(2, &["key=value"]);
    f.turner(&["s.toml", "--width", "0"]).fails(2, &["E0105", "--width 0"]);
    f.turner(&["s.toml", "--width", "x"]).fails(2, &["--width"]);
    f.turner(&["s.toml", "--antialias", "gird"]).fails(2, &["grid"]);
    f.turner(&["s.toml", "--crop", "1,2,3"]).fails(2, &["X,Y,W,H"]);
    f.turner(&["s.toml", "--integrator", "normal"]).fails(2, &["normals"]);
    assert_eq!(f.names(), ["s.toml"]);
}

#[test]
fn another_integrator_drops_what_it_does_not_know() {
    let f = folder();
    f.write("c.toml", &format!("{SCENE}\n[integrator]\nmax_depth = 2\nshadows = false\n"));
    f.turner(&["c.toml", "--integrator", "normals"]).ok();
    f.turner(&["c.toml", "--integrator", "classic", "-o", "d.png"]).ok();
    f.turner(&["c.toml", "-o", "e.png"]).ok();
    assert_eq!(pixels(&f.read("d.png")), pixels(&f.read("e.png")), "the same integrator keeps its settings");
    assert_ne!(pixels(&f.read("c.png")), pixels(&f.read("e.png")));
    f.turner(&["c.toml", "--integrator", "normals", "--max-depth", "3"]).fails(2, &["--max-depth 3"]);
}

#[test]
fn warnings_are_shown_once_and_strict_refuses_them() {
    let f = folder();
    f.write("dark.toml", "[[object]]\ntype = \"sphere\"\n[film]\nwidth = 4\nheight = 4\n");
    let run = f.turner(&["dark.toml"]).ok();
    assert!(run.stderr.contains("warning") && run.stderr.contains("light"), "{run:?}");
    assert_eq!(f.turner(&["dark.toml", "--quiet"]).ok().stderr, "");
    f.turner(&["dark.toml", "--strict", "-o", "x.png"]).fails(1, &["error[E0501]", "light"]);
    assert!(!f.names().contains(&"x.png".to_owned()));
    let run = f.turner(&["dark.toml", "--samples", "9"]).ok();
    assert!(run.stderr.contains("--samples is ignored"), "{run:?}");
}

#[test]
fn scenes_stay_in_their_folder() {
    let f = folder();
    std::fs::create_dir(f.path().join("in")).unwrap();
    f.write("part.toml", SCENE);
    f.write("in/s.toml", "include = [\"../part.toml\"]\n");
    f.turner(&["in/s.toml"]).fails(1, &["E0201"]);
    f.turner(&["in/s.toml", "--allow-outside"]).ok();
}

#[test]
fn tone_mapping_and_exposure_change_what_is_shown_alone() {
    let f = folder();
    let plain = |name: &str| f.turner(&["s.toml", "-o", name, "-D", "film.transfer=srgb"]).ok();
    plain("plain.png");
    plain("plain.exr");
    let linear = pixels(&f.read("plain.exr"));
    let shown = pixels(&f.read("plain.png"));
    let cases: &[&[&str]] = &[
        &["--tonemap", "neutral"],
        &["--tonemap", "agx"],
        &["--tonemap", "aces"],
        &["--exposure", "-1.5"],
        &["--exposure", "2"],
        &["--auto-exposure", "--exposure", "3"],
    ];
    for case in cases {
        let run = |name: &str| {
            f.turner(&[&["s.toml", "-o", name, "-D", "film.transfer=srgb"], *case].concat()).ok();
            pixels(&f.read(name))
        };
        assert_ne!(run("x.png"), shown, "{case:?}");
        assert_eq!(run("x.exr"), linear, "{case:?}");
    }
    f.turner(&["s.toml", "--exposure", "99"]).fails(2, &["E0105", "--exposure 99", "-64 to 64"]);
    f.turner(&["s.toml", "--tonemap", "neutrall"]).fails(2, &["neutral"]);
}

#[test]
fn the_exposure_that_was_chosen_is_in_the_picture() {
    let f = folder();
    let exposure = |args: &[&str]| -> f64 {
        f.turner(&[&["s.toml", "-o", "x.png"], args].concat()).ok();
        let metadata = turner_io::image::read_metadata(&f.read("x.png"), "x.png").unwrap();
        metadata["turner:exposure"].to_string().parse().unwrap()
    };
    assert_eq!(exposure(&[]), 0.0);
    assert_eq!(exposure(&["--exposure", "-1.25"]), -1.25);
    let auto = exposure(&["--auto-exposure"]);
    assert!(auto != 0.0 && auto.abs() < 3.0, "{auto}");
    assert!((exposure(&["--auto-exposure", "--exposure", "0.5"]) - auto - 0.5).abs() < 1e-3);
    // Auto exposure: a scene of twice the brightness looks the same.
    let half = exposure(&[
        "--auto-exposure",
        "-D",
        "background.color=[0.1,0.15,0.25]",
        "-D",
        "light.0.intensity=0.5",
    ]);
    assert!((half - auto - 1.0).abs() < 0.01, "{half} {auto}");
}

#[test]
fn a_clamp_is_recorded_in_the_picture_and_no_clamp_is_not() {
    let f = folder();
    let path = ["s.toml", "-o", "x.png", "--integrator", "path", "-D", "film.antialias=monte-carlo"];
    let clamp = |args: &[&str]| {
        f.turner(&[&path, args].concat()).ok();
        let metadata = turner_io::image::read_metadata(&f.read("x.png"), "x.png").unwrap();
        metadata.get("turner:clampIndirect").map(|v| v.to_string())
    };
    assert_eq!(clamp(&[]), None);
    assert_eq!(clamp(&["--clamp-indirect", "2.5"]), Some("2.5".to_owned()));
    f.turner(&["s.toml", "--integrator", "path", "--clamp-indirect=-1"]).fails(2, &["--clamp-indirect"]);
}

#[test]
fn names_of_mitsuba_scenes_are_given_values() {
    let f = folder();
    f.write(
        "s.xml",
        r#"<scene version="3.0.0">
    <default name="spp" value="4"/><default name="size" value="8"/>
    <sensor type="perspective">
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm"><integer name="width" value="$size"/><integer name="height" value="8"/></film>
    </sensor>
    <emitter type="constant"/>
</scene>"#,
    );
    for (options, samples, width) in [
        (&[][..], 4, 8),
        (&["-D", "spp=3"], 3, 8),
        (&["--define", "spp=5", "-D", "size=6"], 5, 6),
        (&["-D", "film.samples=7"], 7, 8),
    ] {
        let run = f.turner(&[&["s.xml", "--json"][..], options].concat()).ok();
        let start: serde_json::Value =
            serde_json::from_str(run.stdout.lines().find(|l| l.contains("\"start\"")).unwrap()).unwrap();
        assert_eq!(
            (&start["samples_per_pixel"], &start["width"]),
            (&samples.into(), &width.into()),
            "{options:?}"
        );
    }
}

#[test]
fn options_of_the_path_tracer_name_it() {
    let f = folder();
    let scene = "integrator = { type = \"classic\" }\nobject = [{ type = \"sphere\" }]\n";
    f.write("c.toml", scene);
    for option in [["--caustics", "off"], ["--clamp-indirect", "10"], ["--shared-paths", "off"]] {
        let run = f.turner(&["c.toml", option[0], option[1]]).fails(2, &["E0102", option[0]]);
        assert!(run.stderr.contains("add `--integrator path`"), "{}", run.stderr);
    }
}

#[test]
fn an_empty_scene_names_the_example() {
    let f = folder();
    f.write("e.toml", "");
    let run = f.turner(&["e.toml", "--width", "16", "--samples", "1"]).ok();
    for words in ["warning[ignored]: ", "`turner new first`", "`turner help scene`"] {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}
