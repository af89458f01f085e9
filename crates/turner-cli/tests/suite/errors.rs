//! All errors of a scene in one run, the pages of the codes, and usage errors.

use crate::common::{SCENE, folder};

/// A faulty line, the position of its error (line and column), its code, and the corrected line.
type Fault = (&'static str, (u64, u64), &'static str, &'static str);

/// The head of the scene is correct; `{}` stands for the lines.
const FAULTS: &[Fault] = &[
    ("[film]\nwidht = 24", (2, 1), "E0102", "[film]\nwidth = 24"),
    ("height = \"tall\"", (3, 10), "E0104", "height = 16"),
    ("samples = 0", (4, 11), "E0105", "samples = 1"),
    ("[camera]\nposition = [0, 1]", (6, 12), "E0104", "[camera]\nposition = [0, 1, 6]"),
    ("fov = 200", (7, 7), "E0105", "fov = 40"),
    ("[texture.board]\ntype = \"chekers\"", (9, 8), "E0103", "[texture.board]\ntype = \"constant\"\n#"),
    ("[material.a]\nreflection = 0.3", (11, 1), "E0102", "[material.a]\nk_reflect = 0.3"),
    ("[[object]]\ntype = \"cube\"", (13, 8), "E0103", "[[object]]\ntype = \"box\""),
    (
        "[[object]]\ntype = \"sphere\"\nmaterial = \"gold\"",
        (16, 12),
        "E0103",
        "[[object]]\ntype = \"sphere\"\nmaterial = \"a\"",
    ),
    (
        "[[light]]\nposition = [5, 8, 5]",
        (17, 1),
        "E0106",
        "[[light]]\ntype = \"point\"\nposition = [5, 8, 5]",
    ),
];

fn scene(corrected: usize) -> String {
    let lines = FAULTS.iter().enumerate().map(|(i, fault)| if i < corrected { fault.3 } else { fault.0 });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn ten_faults_give_ten_errors_at_their_places() {
    let f = folder();
    f.write("bad.toml", &scene(0));
    let text = f.turner(&["bad.toml"]).fails(1, &["10 errors"]).stderr;
    let json = f.turner(&["bad.toml", "--json"]).fails(1, &[]).stdout;
    let events: Vec<serde_json::Value> = json.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(events.len(), FAULTS.len(), "{json}");
    for ((_, (line, column), code, _), event) in FAULTS.iter().zip(&events) {
        assert_eq!(
            (event["line"].as_u64(), event["column"].as_u64(), event["code"].as_str()),
            (Some(*line), Some(*column), Some(*code)),
            "{event}"
        );
        assert!(text.contains(&format!("bad.toml:{line}:{column}")), "{text}");
    }
}

#[test]
fn each_correction_removes_one_error() {
    let f = folder();
    for corrected in 0..FAULTS.len() {
        f.write("bad.toml", &scene(corrected));
        let run = f.turner(&["bad.toml"]).fails(1, &[]);
        let count = run.stderr.matches("error[").count();
        assert_eq!(count, FAULTS.len() - corrected, "{corrected}: {}", run.stderr);
    }
    f.write("good.toml", &scene(FAULTS.len()));
    f.turner(&["info", "good.toml"]).ok();
}

#[test]
fn what_failed_causes_no_further_errors() {
    let f = folder();
    let one = |text: &str, words: &[&str]| {
        f.write("bad.toml", &format!("{text}\n{SCENE}"));
        let run = f.turner(&["bad.toml"]).fails(1, words);
        assert_eq!(run.stderr.matches("error[").count(), 1, "{}", run.stderr);
    };
    // The name of a faulty material is known.
    one(
        "[material.gold]\ntype = \"conductr\"\n[[object]]\ntype = \"sphere\"\nmaterial = \"gold\"",
        &["E0103", "conductr"],
    );
    // A key of the wrong type is not also missing.
    one("[[object]]\ntype = \"mesh\"\nfile = 3", &["E0104"]);
    // Two objects name the same missing file.
    one(
        "[[object]]\ntype = \"mesh\"\nfile = \"no.obj\"\n[[object]]\ntype = \"mesh\"\nfile = \"no.obj\"",
        &["E0201"],
    );
    // A section that is not a table.
    one("integrator = 3", &["E0104"]);
    // A syntax error is reported alone.
    one("[[object]\ncolor = 3\nradus = 4", &["E0101"]);
}

#[test]
fn many_errors_are_cut_off() {
    let f = folder();
    let keys: String = (0..30).map(|i| format!("wrong_{i} = 1\n")).collect();
    f.write("bad.toml", &format!("[film]\n{keys}"));
    let run = f.turner(&["bad.toml"]).fails(1, &["and 10 more", "30 errors"]);
    assert_eq!(run.stderr.matches("error[").count(), 20, "{}", run.stderr);
    let json = f.turner(&["bad.toml", "--json"]).fails(1, &[]).stdout;
    assert_eq!(json.lines().count(), 30, "{json}");
}

/// The example of each page gives the error of the page.
#[test]
fn examples_of_errors_give_their_errors() {
    let f = folder();
    for page in turner_cli::error_pages::PAGES {
        if page.faulty.is_empty() || page.faulty.starts_with("turner") {
            continue;
        }
        let rest = if page.faulty.contains("[[object]]") { "" } else { "\n[[object]]\ntype = \"sphere\"\n" };
        f.write("bad.toml", &format!("{}\n{rest}", page.faulty));
        f.turner(&["bad.toml", "--width", "4"]).fails(1, &[&format!("error[{}]", page.code.as_str())]);
    }
    let codes: Vec<_> = turner_cli::error_pages::PAGES.iter().map(|page| page.code).collect();
    assert_eq!(codes, turner::schema::ErrorCode::ALL, "one page for each code");
}

#[test]
fn usage_errors_look_like_all_others() {
    let f = folder();
    for (args, words) in [
        (&["s.toml", "--spp", "4"][..], &["no option `--spp`", "--samples"][..]),
        (&["s.toml", "--size=4x4"], &["no option `--size`", "--width 640 --height 480"]),
        (&["s.toml", "--widht", "4"], &["did you mean `--width`?"]),
        (&["s.toml", "--width"], &["`--width` needs a value"]),
        (&["s.toml", "--width", "wide"], &["`--width` cannot be \"wide\""]),
        (&["s.toml", "--antialias", "gird"], &["did you mean \"grid\"?"]),
        (&["s.toml", "--time", "1", "--frame", "2"], &["exclude each other"]),
        (&["s.toml", "--width", "1", "--width", "2"], &["given twice"]),
        (&["render"], &["<SCENE>"]),
        (&["info", "s.toml", "--turntable", "4"], &["option of `turner render`"]),
        (&["info", "s.toml", "other"], &["unexpected argument \"other\""]),
    ] {
        let run = f.turner(args).fails(2, &["error[E0601]: "]);
        let run = run.fails(2, words);
        assert!(run.stderr.contains("help"), "{}", run.stderr);
    }
}

#[test]
fn still_scenes_say_that_frames_are_the_same() {
    let f = folder();
    let run = f.turner(&["s.toml", "--frames", "0-1", "--width", "4"]).ok();
    assert!(run.stderr.contains("nothing in this scene moves"), "{}", run.stderr);
    f.turner(&["s.toml", "--frames", "0-1", "--strict"]).fails(1, &["E0501"]);
}

#[test]
fn the_old_name_of_shared_paths_is_read() {
    let f = folder();
    for option in ["--reuse", "--shared-paths"] {
        f.turner(&["s.toml", "--integrator", "path", "--width", "4", option, "off"]).ok();
    }
    assert!(!f.turner(&["render", "--help-all"]).ok().stdout.contains("--reuse"));
}

#[test]
fn missing_arguments_and_wrong_files_have_remedies() {
    let f = folder();
    for command in ["explain", "doctor", "info", "watch", "new", "convert", "compare", "render"] {
        let run = f.turner(&[command]).fails(2, &["E0601", "missing: "]);
        assert!(run.stderr.contains(&format!("help: usage: turner {command} ")), "{}", run.stderr);
    }
    f.turner(&["list", "nope"]).fails(2, &["there is no topic \"nope\"", "valid: shapes"]);
    for command in [&["explain", "--pixel", "1,1"][..], &["doctor"], &["info"], &["watch", "--count", "1"]] {
        for file in ["nope.toml", "."] {
            f.turner(&[command, &[file]].concat()).fails(1, &["E0201", file, "help: "]);
        }
    }
}
