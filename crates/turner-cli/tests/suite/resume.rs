//! Nothing is lost: checkpoints, `turner resume`, `turner merge`, `--resume`.
#![cfg(unix)]

use std::process::{Child, Command, Stdio};
use std::time::Instant;

use crate::common::{Folder, folder, pixels};

/// A path-traced picture of some hundred milliseconds.
const PATH: [&str; 9] =
    ["s.toml", "--integrator", "path", "--width", "80", "--height", "56", "--samples", "48"];

fn args<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&PATH[..], more].concat()
}

/// The picture of an undisturbed render.
fn single(f: &Folder, more: &[&str]) -> Vec<u8> {
    f.turner(&args(&[more, &["-o", "single.png"]].concat())).ok();
    f.read("single.png")
}

fn start(f: &Folder, args: &[&str]) -> Child {
    f.command(args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Low-discrepancy numbers from 0 to 1: moments that are spread evenly.
fn moments(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(|i| (0.5 + f64::from(i) * 0.618_034) % 1.0)
}

fn flaws(f: &Folder) -> Vec<String> {
    f.names().into_iter().filter(|n| n.contains(".tmp")).collect()
}

/// `kill -9` at any moment: the checkpoint is complete, and the render continues to the same bytes.
#[test]
fn a_killed_render_continues_to_the_same_bytes() {
    let f = folder();
    let begin = Instant::now();
    let expected = single(&f, &[]);
    let duration = begin.elapsed();
    let mut continued = 0;
    for moment in moments(6) {
        let options =
            args(&["-o", "a.png", "--checkpoint", "c.turner-checkpoint", "--checkpoint-interval", "0.02"]);
        let mut child = start(&f, &options);
        std::thread::sleep(duration.mul_f64(moment));
        let _ = child.kill();
        child.wait().unwrap();
        if f.path().join("c.turner-checkpoint").exists() {
            continued += 1;
            f.turner(&["resume", "c.turner-checkpoint"]).ok();
        } else {
            f.turner(&options).ok();
        }
        assert!(f.read("a.png") == expected, "{moment}");
        std::fs::remove_file(f.path().join("a.png")).unwrap();
        std::fs::remove_file(f.path().join("c.turner-checkpoint")).unwrap();
        assert!(flaws(&f).is_empty(), "{:?}", f.names());
    }
    assert!(continued > 0, "no checkpoint was written in {duration:?}");
}

/// SIGTERM at any moment: the picture so far, a checkpoint beside it, and the way to continue.
#[test]
fn an_interrupted_render_continues_to_the_same_bytes() {
    let f = folder();
    let begin = Instant::now();
    let expected = single(&f, &[]);
    let duration = begin.elapsed();
    let beside = ".a.png.turner-checkpoint";
    for moment in moments(6) {
        let mut child = f.command(&args(&["-o", "a.png"])).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(duration.mul_f64(moment));
        let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
        let code = child.wait().unwrap().code();
        if f.path().join(beside).exists() {
            assert_eq!(code, Some(143));
            assert_eq!(pixels(&f.read("a.png")).0, 80);
            assert!(f.read("a.png") != expected, "{moment}");
            f.turner(&["resume", beside]).ok();
        } else if code == Some(143) {
            // It ended before the first sample.
            f.turner(&args(&["-o", "a.png"])).ok();
        }
        assert!(f.read("a.png") == expected, "{moment}");
        // The checkpoint of a finished picture is gone.
        assert_eq!(f.names(), ["a.png", "s.toml", "single.png"]);
        std::fs::remove_file(f.path().join("a.png")).unwrap();
    }
}

/// An interrupted render with `--resume` is the same command again.
#[test]
fn the_same_command_continues_with_resume() {
    let f = folder();
    let expected = single(&f, &[]);
    let render = args(&["-o", "a.png", "--resume"]);
    f.turner(&args(&["-o", "a.png", "--sample-range", "0..7", "--checkpoint", ".a.png.turner-checkpoint"]))
        .ok();
    f.turner(&render).ok();
    assert!(f.read("a.png") == expected);
    let again = f.turner(&render).ok();
    assert!(again.stderr.contains("a.png: complete, skipped"), "{again:?}");
    // A checkpoint of other options is left alone, and refused if the user names it.
    let checkpoint = ".a.png.turner-checkpoint";
    f.turner(&args(&["-o", "a.png", "--sample-range", "0..7", "--checkpoint", checkpoint])).ok();
    let before = f.read(checkpoint);
    let run = f.turner(&args(&["-o", "a.png", "--resume", "--max-depth", "2"])).ok();
    assert!(run.stderr.contains("is of another scene or other options"), "{run:?}");
    assert!(f.read(checkpoint) == before && f.read("a.png") != expected);
    let named = args(&["-o", "b.png", "--resume", "--max-depth", "2", "--checkpoint", checkpoint]);
    f.turner(&named).fails(1, &["the scene or its options changed", "render again"]);
    // A part continues as a part.
    f.turner(&["resume", checkpoint]).ok();
    assert!(f.read(checkpoint).len() + 20 >= before.len());
    let missing = f.turner(&["resume", "s.toml"]);
    missing.fails(1, &["s.toml: is not a checkpoint"]);
}

/// A finished render with more samples equals a new one with as many.
#[test]
fn samples_are_added_to_a_finished_render() {
    let f = folder();
    let base = ["s.toml", "--integrator", "path", "--width", "40", "--height", "30"];
    let run = |more: &[&str]| f.turner(&[&base[..], more].concat());
    run(&["--samples", "1", "-o", "a.png", "--checkpoint", "a.turner-checkpoint"]).ok();
    for samples in ["5", "12"] {
        f.turner(&["resume", "a.turner-checkpoint", "--samples", samples]).ok();
        run(&["--samples", samples, "-o", "b.png"]).ok();
        assert!(f.read("a.png") == f.read("b.png"), "{samples}");
    }
    // Nothing is left to do.
    f.turner(&["resume", "a.turner-checkpoint", "-o", "c.png"]).ok();
    assert!(f.read("c.png") == f.read("a.png"));
    let fewer = f.turner(&["resume", "a.turner-checkpoint", "--samples", "3"]);
    fewer.fails(2, &["with 12 samples per pixel; expected at least as many, found 3"]);
    // Classic ray tracing places its samples by their number.
    let classic = ["s.toml", "--antialias", "monte-carlo", "--samples", "4"];
    f.turner(&[&classic[..], &["--checkpoint", "k.turner-checkpoint"]].concat()).ok();
    f.turner(&["resume", "k.turner-checkpoint"]).ok();
    let more = f.turner(&["resume", "k.turner-checkpoint", "--samples", "9"]);
    more.fails(1, &["\"classic\" places its samples by their number"]);
}

/// Sample ranges and crops of any split give the bytes of a single render: of the picture and of the checkpoint.
#[test]
fn parts_merge_to_the_single_render() {
    let f = folder();
    let expected = single(&f, &[]);
    f.turner(&args(&["-o", "all.turner-checkpoint"])).ok();
    let part = |name: &str, more: &[&str]| {
        f.turner(&args(&[more, &["-o", name]].concat())).ok();
    };
    part("a.turner-checkpoint", &["--sample-range", "0..5"]);
    part("b.turner-checkpoint", &["--sample-range", "5..48"]);
    let merge = |files: &[&str], out: &str| f.turner(&[&["merge"], files, &["-o", out]].concat());
    merge(&["b.turner-checkpoint", "a.turner-checkpoint"], "m.png").ok();
    assert!(f.read("m.png") == expected);
    let crops = [
        ("1", "0,0,33,56", "0..48"),
        ("2", "33,0,47,21", "0..20"),
        ("3", "33,0,47,21", "20..48"),
        ("4", "33,21,47,35", "0..48"),
    ];
    let names = crops.map(|(name, crop, range)| {
        let name = format!("{name}.turner-checkpoint");
        part(&name, &["--crop", crop, "--sample-range", range]);
        name
    });
    let names = names.each_ref().map(String::as_str);
    merge(&names, "m.png").ok();
    assert!(f.read("m.png") == expected);
    merge(&names, "m.turner-checkpoint").ok();
    let film = |name: &str| {
        let limits = turner::schema::Limits::default();
        turner_io::checkpoint::read(&f.path().join(name), &limits).unwrap().film.to_bytes()
    };
    assert!(film("m.turner-checkpoint") == film("all.turner-checkpoint"));
    f.turner(&["resume", "m.turner-checkpoint", "-o", "r.png"]).ok();
    assert!(f.read("r.png") == expected);
    // A rectangle of the picture.
    merge(&names[1..], "right.png").ok();
    f.turner(&args(&["--crop", "33,0,47,56", "-o", "crop.png"])).ok();
    assert_eq!(pixels(&f.read("right.png")), pixels(&f.read("crop.png")));

    merge(&names[..2], "x.png").fails(1, &["hold different samples: 0..48", "but 0..20"]);
    merge(&[names[0], names[3]], "x.png").fails(1, &["leave a gap"]);
    merge(&[names[0], names[0]], "x.png").fails(1, &["both films hold samples 0 to 47 of tile 0"]);
    part("other.turner-checkpoint", &["--sample-range", "5..48", "--max-depth", "2"]);
    merge(&["a.turner-checkpoint", "other.turner-checkpoint"], "x.png")
        .fails(1, &["options other than --sample-range"]);
    let half = merge(&["a.turner-checkpoint"], "half.png").ok();
    assert!(half.stderr.contains("10.4 % of the 48 samples per pixel"), "{half:?}");
    assert!(!f.path().join("x.png").exists());
}

/// Equal parts, and the jobs that render them, give the bytes of a single render.
#[test]
fn numbered_parts_and_jobs_give_the_single_render() {
    let f = folder();
    let expected = single(&f, &[]);
    for part in ["1/3", "2/3", "3/3"] {
        f.turner(&args(&["--part", part])).ok();
    }
    let files = ["1", "2", "3"].map(|i| format!("s-{i}-of-3.turner-checkpoint"));
    let files = files.each_ref().map(String::as_str);
    f.turner(&[&["merge"], &files[..], &["-o", "m.png"]].concat()).ok();
    assert!(f.read("m.png") == expected);
    f.turner(&args(&["--part", "1/49"])).fails(2, &["48 samples per pixel", "at most 48 parts"]);
    f.turner(&args(&["--part", "4/3"])).fails(2, &["--part 1/64"]);

    let options = args(&[]);
    let split = ["farm", "split", "s.toml", "--parts", "5", "--queue", "shell", "-o", "job.sh", "--"];
    f.turner(&[&split[..], &options[1..]].concat()).ok();
    if cfg!(unix) {
        let turner = std::path::Path::new(env!("CARGO_BIN_EXE_turner")).parent().unwrap().to_owned();
        let path = format!("{}:{}", turner.display(), std::env::var("PATH").unwrap_or_default());
        let run =
            || crate::folder::Run::of(f.program("sh", &["job.sh"]).env("PATH", &path).output().unwrap()).ok();
        run();
        assert!(f.read("s.png") == expected);
        // A part that is lost, and one that was stopped on its way, are rendered; the others stay.
        let lost = f.path().join("s-parts/part-000002.turner-checkpoint");
        std::fs::remove_file(&lost).unwrap();
        std::fs::remove_file(f.path().join("s.png")).unwrap();
        run();
        assert!(lost.is_file() && f.read("s.png") == expected);
    }
    f.turner(&["farm", "split", "no.toml", "--parts", "5"]).fails(2, &["no.toml", "no such file"]);
    f.turner(&["farm", "split", "s.toml", "--parts", "5", "--", "--crop=0,0,4,4"]).fails(2, &["--crop"]);
}

/// Finished pictures of a sequence are skipped; the interrupted one continues.
#[test]
fn a_sequence_continues() {
    let f = folder();
    let base = [
        "s.toml",
        "--integrator",
        "path",
        "--width",
        "24",
        "--height",
        "16",
        "--samples",
        "8",
        "--turntable",
        "4",
    ];
    let run = |more: &[&str]| f.turner(&[&base[..], more].concat());
    run(&["-o", "one_#.png"]).ok();
    run(&["-o", "two_#.png", "--resume"]).ok();
    std::fs::remove_file(f.path().join("two_2.png")).unwrap();
    let again = run(&["-o", "two_#.png", "--resume"]).ok();
    for (name, is_skipped) in [("two_0", true), ("two_1", true), ("two_2", false), ("two_3", true)] {
        assert_eq!(again.stderr.contains(&format!("{name}.png: complete, skipped")), is_skipped, "{again:?}");
    }
    for i in 0..4 {
        assert!(f.read(&format!("one_{i}.png")) == f.read(&format!("two_{i}.png")), "{i}");
    }
    // Of another turntable no picture is skipped but the first, which has the same camera.
    let other = f.turner(&[&base[..9], &["--turntable", "3", "-o", "two_#.png", "--resume"]].concat()).ok();
    assert!(other.stderr.contains("two_0.png: complete") && !other.stderr.contains("two_1.png: complete"));

    // The checkpoint of a picture of a sequence continues that picture.
    let long =
        ["--integrator", "path", "--width", "200", "--height", "160", "--samples", "400", "--turntable", "2"];
    let mut child = f
        .command(&[&["s.toml", "-o", "l_#.png", "--json"][..], &long].concat())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut events = std::io::BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while !line.contains("\"progress\"") {
        line.clear();
        assert!(std::io::BufRead::read_line(&mut events, &mut line).unwrap() > 0, "it ended early");
    }
    // SIGINT is off where the tests run in the background.
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut events, &mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(143), "{rest}");
    assert!(rest.contains(".l_0.png.turner-checkpoint") && !f.path().join("l_1.png").exists(), "{rest}");
    assert!(!f.path().join("l_1.png").exists());
}

/// Options that contradict each other, and files that are not checkpoints.
#[test]
fn misuse_is_explained() {
    let f = folder();
    let two = |args: &[&str], words: &[&str]| drop(f.turner(&[&["s.toml"], args].concat()).fails(2, words));
    two(&["--sample-range", "0..1"], &["it needs a checkpoint file", "--checkpoint part.turner-checkpoint"]);
    two(&["--sample-range", "5..2", "-o", "a.turner-checkpoint"], &["--sample-range 0..64"]);
    two(
        &["--sample-range", "0..2", "-o", "a.turner-checkpoint"],
        &["reaches beyond the 1 samples per pixel"],
    );
    two(&["--turntable", "3", "--checkpoint", "a.turner-checkpoint"], &["cannot hold several pictures"]);
    two(&["--checkpoint", "s.toml"], &["s.toml: exists and is not a checkpoint"]);
    two(&["--checkpoint", "a", "-o", "b.turner-checkpoint"], &["two checkpoint files"]);
    f.turner(&["s.toml", "--checkpoint", "none/a"]).fails(1, &["the folder none does not exist"]);
    f.turner(&["resume", "missing"]).fails(1, &["missing: cannot be read"]);
    f.turner(&["resume", "."]).fails(1, &[".: is not a file"]);
    f.turner(&["merge", "s.toml", "-o", "a.png"]).fails(1, &["s.toml: is not a checkpoint"]);
    assert_eq!(f.names(), ["s.toml"]);
}

/// Damaged checkpoints, also with a valid checksum, are one error; a checkpoint cannot name files elsewhere.
#[test]
fn hostile_checkpoints_are_refused() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png", "--checkpoint", "a.turner-checkpoint"]).ok();
    let bytes = f.read("a.turner-checkpoint");
    let path = f.path().join("b.turner-checkpoint");
    for i in 0..40 {
        let mut bytes = bytes.clone();
        if i % 2 == 0 {
            bytes.truncate(bytes.len() * i / 40);
        } else {
            let at = bytes.len() * i / 40;
            bytes[at] ^= 1 << (i % 8);
        }
        std::fs::write(&path, bytes).unwrap();
        let run = f.turner(&["resume", "b.turner-checkpoint"]).fails(1, &["b.turner-checkpoint"]);
        assert_eq!(run.stderr.matches("error").count(), 1, "{run:?}");
    }
    let forged = |old: &str, new: &str, words: &[&str]| {
        let limits = turner::schema::Limits::default();
        let film = turner_io::checkpoint::read(&f.path().join("a.turner-checkpoint"), &limits).unwrap();
        let text = serde_json::to_string(&film.header).unwrap();
        assert!(text.contains(old), "{text}");
        let header = serde_json::from_str(&text.replace(old, new)).unwrap();
        std::fs::write(&path, turner_io::checkpoint::to_bytes(&header, &film.film).unwrap()).unwrap();
        let run = f.turner(&["resume", "b.turner-checkpoint"]);
        assert!(run.code == Some(1) || run.code == Some(2), "{run:?}");
        assert!(words.iter().all(|word| run.stderr.contains(word)), "{words:?}: {run:?}");
    };
    forged("\"a.png\"", "\"../../a.png\"", &["records the output", "name the picture with `-o FILE`"]);
    forged("\"a.png\"", "\"/tmp/none/a.png\"", &["records the output"]);
    forged("\"a.png\"", "\".profile\"", &["unusual extension"]);
    forged("\"s.toml\"", "\"\\u001b[2J\"", &["no such file"]);
    forged("\"arguments\":[]", "\"arguments\":[\"--hack=1\"]", &["there is no option"]);
    forged("\"arguments\":[]", "\"arguments\":[\"--width=99\"]", &["the scene or its options changed"]);
    forged("\"turner\":\"", "\"turner\":\"9", &["written by Turner 9"]);
    f.write("s.toml", &crate::common::SCENE.replace("tomato", "gold"));
    f.turner(&["resume", "a.turner-checkpoint"]).fails(1, &["the scene or its options changed"]);
}

/// A full disk costs the checkpoint, not the picture.
#[test]
fn a_checkpoint_that_cannot_be_written_is_a_warning() {
    let f = folder();
    std::fs::create_dir(f.path().join("tiny")).unwrap();
    let script = r#"
        mount -t tmpfs -o size=16k tmpfs tiny || exit 77
        "$0" s.toml --integrator path --width 80 --height 56 --samples 48 -o a.png --checkpoint tiny/c --checkpoint-interval 0.02 2> said || exit 78
        [ -s a.png ] || exit 79
        [ "$(grep -c 'cannot be written' said)" -le 2 ] || exit 80
        grep -q 'free some space' said || exit 81
    "#;
    let mut unshare = Command::new("unshare");
    unshare.args(["--user", "--map-root-user", "--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_turner")]);
    let Ok(output) = unshare.current_dir(f.path()).output() else { return };
    let run = crate::common::Run::of(output);
    // Mounting may not be permitted.
    if run.code != Some(77) && !run.stderr.starts_with("unshare") {
        assert_eq!(run.code, Some(0), "{run:?}");
    }
}
