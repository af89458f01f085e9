//! Sequences as one file.

use std::process::Command;

use crate::common::{Folder, folder};

const SCENE: &str = "camera = { position = [0, 2, 6], look_at = [0, 1, 0] }\n\
    light = [{ type = \"point\", position = [3, 4, 5] }]\n\
    object = [{ type = \"sphere\", center = [0.5, 1, 0] }]\n\
    film = { width = 36, height = 25 }\n";

/// The arguments for a turntable of four frames.
fn turn(output: &str) -> Vec<&str> {
    vec!["s.toml", "--turntable", "4", "--fps", "10", "-o", output]
}

fn with_scene() -> Folder {
    let f = folder();
    f.write("s.toml", SCENE);
    f
}

#[test]
fn sequences_become_animations() {
    let f = with_scene();
    f.turner(&turn("single_#.png")).ok();
    for (name, starts) in [("a.gif", &b"GIF89a"[..]), ("a.apng", b"\x89PNG"), ("a.webp", b"RIFF")] {
        let run = f.turner(&turn(name)).ok();
        assert!(run.stderr.contains(&format!("{name}: 4 frames, 10 per second")), "{run:?}");
        let first = f.read(name);
        assert!(first.starts_with(starts), "{name}");
        assert!(!f.path().join(format!(".{name}.frames")).exists(), "the frames are removed");
        // The same bytes again, with other threads.
        f.turner(&[&turn(name)[..], &["--threads", "1"]].concat()).ok();
        assert!(f.read(name) == first, "{name}");
    }
    // Decoders of still images show the first frame: it is the single picture.
    let pixels = |name: &str| crate::common::pixels(&f.read(name));
    assert_eq!(pixels("a.apng"), pixels("single_0.png"));
}

#[test]
fn an_interrupted_animation_continues() {
    let f = with_scene();
    f.turner(&turn("whole.gif")).ok();
    // As if the render had been killed after two frames: its folder has them.
    f.turner(&turn("part.gif")).ok();
    std::fs::create_dir(f.path().join(".part.gif.frames")).unwrap();
    f.turner(&["s.toml", "--turntable", "4", "-o", ".part.gif.frames/frame_####.png"]).ok();
    for last in [2, 3] {
        std::fs::remove_file(f.path().join(format!(".part.gif.frames/frame_000{last}.png"))).unwrap();
    }
    std::fs::remove_file(f.path().join("part.gif")).unwrap();
    let run = f.turner(&[&turn("part.gif")[..], &["--resume"]].concat()).ok();
    assert_eq!(run.stderr.matches("complete, skipped").count(), 2, "{run:?}");
    assert!(f.read("part.gif") == f.read("whole.gif"));
}

#[test]
fn one_picture_is_no_animation() {
    let f = with_scene();
    for name in ["a.gif", "a.apng", "a.mp4"] {
        f.turner(&["s.toml", "-o", name]).fails(2, &["needs several pictures", "--turntable"]);
    }
    f.turner(&["s.toml", "-o", "a.webp"]).ok();
}

#[test]
fn videos_are_made_by_ffmpeg() {
    let f = with_scene();
    let none = f.command(&turn("a.mp4")).env("PATH", f.path()).output().unwrap();
    let text = String::from_utf8_lossy(&none.stderr).into_owned();
    assert!(none.status.code() == Some(2) && text.contains("install ffmpeg"), "{text}");
    assert!(!f.path().join(".a.mp4.frames").exists());
    if Command::new("ffmpeg").arg("-version").output().is_err() {
        eprintln!("ffmpeg is not installed: the rest is not tested");
        return;
    }
    for name in ["a.mp4", "a.webm"] {
        f.turner(&turn(name)).ok();
        let first = f.read(name);
        f.turner(&turn(name)).ok();
        assert!(first.len() > 500 && f.read(name) == first, "{name}");
        assert!(!f.path().join(format!(".{name}.frames")).exists());
    }
}
