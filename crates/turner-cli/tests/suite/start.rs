//! `turner new`, `turner watch`, completion scripts and manual pages.

use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Run, SCENE, folder, pixels};

#[test]
fn new_scenes_render_without_a_warning() {
    let f = folder();
    for template in ["physical", "classic"] {
        let run = f.turner(&["new", template, "--template", template]);
        assert_eq!(run.code, Some(0), "{run:?}");
        let name = format!("{template}.toml");
        assert!(run.stdout.contains(&format!("turner watch {name}")), "{run:?}");
        let text = String::from_utf8(f.read(&name)).unwrap();
        assert!(text.contains(&format!("turner {name}")) && !text.contains("NAME"), "{text}");
        let size = ["--width", "40", "--height", "25", "-D", "film.samples=2", "--strict"];
        let run = f.turner(&[&[&*name], &size[..]].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        assert!(!run.stderr.contains("warning"), "{run:?}");
        let (w, h, p) = pixels(&f.read(&format!("{template}.png")));
        assert_eq!((w, h), (40, 25));
        // The red sphere is at the centre.
        let center = p[(h / 2 * w + w / 2) as usize];
        assert!(center[0] > 1.5 * center[1] && center[0] > 1.5 * center[2], "{center:?}");
    }
}

#[test]
fn new_writes_over_nothing() {
    let f = folder();
    for name in ["s", "s.toml"] {
        let run = f.turner(&["new", name]);
        assert_eq!(run.code, Some(1));
        assert!(run.stderr.contains("s.toml: the file already exists"), "{run:?}");
    }
    assert_eq!(f.read("s.toml"), SCENE.as_bytes());
    let run = f.turner(&["new", "no/such/folder/x"]);
    assert_eq!(run.code, Some(1), "{run:?}");
    for name in [".", "..", "./", "x/", "no/."] {
        f.turner(&["new", name]).fails(1, &["is not a file name"]);
    }
    f.turner(&["new", "a\u{1b}[31mb"]).fails(1, &["control character"]);
    assert_eq!(f.names(), ["s.toml"]);
}

fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < Duration::from_secs(60), "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn end(child: Child) -> Run {
    Run::of(child.wait_with_output().unwrap())
}

fn contents(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_default()
}

#[test]
fn watch_renders_again_when_a_file_is_saved() {
    let f = folder();
    f.write("paint.toml", "[material.paint]\ncolor = \"red\"\n");
    let scene = SCENE.replace("{ color = \"tomato\", k_reflect = 0.3 }", "\"paint\"");
    f.write("s.toml", &format!("include = [\"paint.toml\"]\n{scene}"));
    let child = f
        .command(&["watch", "s.toml", "-o", "w.png", "--count", "5"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let picture = f.path().join("w.png");
    // Pictures so far are written, too.
    let is_new = |before: &[u8]| {
        let now = contents(&picture);
        let finished = b"turner:finished";
        !now.is_empty() && now != before && !now.windows(finished.len()).any(|w| w == finished)
    };
    until("the first picture", || is_new(&[]));
    let first = contents(&picture);
    // An included file.
    f.write("paint.toml", "[material.paint]\ncolor = \"lime\"\n");
    until("the second picture", || is_new(&first));
    let second = contents(&picture);
    // An error leaves the picture unchanged. Then the file is missing for a while, then incomplete.
    f.write("s.toml", "[camera\n");
    std::thread::sleep(Duration::from_millis(1500));
    std::fs::remove_file(f.path().join("s.toml")).unwrap();
    std::thread::sleep(Duration::from_millis(600));
    assert_eq!(contents(&picture), second);
    f.write("s.toml", "");
    std::thread::sleep(Duration::from_millis(400));
    f.write("s.toml", SCENE);
    until("the picture after a mistake", || is_new(&second));
    let third = contents(&picture);
    f.write("s.toml", &SCENE.replace("tomato", "navy"));
    until("the last picture", || is_new(&third));
    let run = end(child);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert_eq!(run.stderr.matches("error[").count(), 1, "{run:?}");
    assert!(
        run.stderr.contains("does not exist: waiting") || run.stdout.contains("does not exist: waiting"),
        "{run:?}"
    );
    assert_eq!(f.names(), ["paint.toml", "s.toml", "w.png"]);
}

#[test]
fn a_long_render_leaves_off_when_the_scene_is_saved() {
    let f = folder();
    let slow = SCENE.replace("height = 16", "height = 16\nantialias = \"monte-carlo\"\nsamples = 16000000");
    f.write("s.toml", &slow);
    let child = f
        .command(&["watch", "s.toml", "-o", "w.png", "--count", "1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    f.write("s.toml", SCENE);
    let run = end(child);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert_eq!(pixels(&f.read("w.png")).0, 24);
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let f = folder();
    for (args, word) in [
        (&["watch", "-", "-o", "x.png"][..], "standard input"),
        (&["watch", "s.toml", "-o", "-", "--format", "png"], "repeatedly"),
        (&["watch", "s.toml", "--turntable", "4"], "sequences"),
    ] {
        let run = f.turner(args);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains(word), "{run:?}");
    }
}

#[test]
fn shells_and_manuals_know_the_options() {
    let f = folder();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = f.turner(&["completions", shell]);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert!(run.stdout.contains("antialias") && run.stdout.contains("watch"), "{shell}");
    }
    let run = f.turner(&["man"]);
    assert!(run.stdout.starts_with(".ie") && run.stdout.contains(".TH turner 1"), "{run:?}");
    let run = f.turner(&["man", "--into", "man1"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let page = std::fs::read_to_string(f.path().join("man1/turner-render.1")).unwrap();
    assert!(page.contains("antialias"), "{page}");
    assert!(f.path().join("man1/turner.1").is_file());
}
