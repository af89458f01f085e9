//! Ctrl-C saves the picture.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Folder, Run, folder, pixels};

/// Starts a render that takes minutes, and waits for its first progress.
fn long(f: &Folder, args: &[&str]) -> (Child, BufReader<std::process::ChildStdout>) {
    let size = ["--width", "200", "--height", "200", "--antialias", "monte-carlo", "--samples", "1000000"];
    let mut child = f
        .command(&[&["s.toml", "--json"], &size[..], args].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut events = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while !line.contains("\"progress\"") {
        line.clear();
        assert!(events.read_line(&mut line).unwrap() > 0, "the program ended early");
    }
    (child, events)
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

fn end(mut child: Child, mut events: BufReader<std::process::ChildStdout>) -> Run {
    let start = Instant::now();
    let mut stdout = String::new();
    events.read_to_string(&mut stdout).unwrap();
    let output = child.wait().unwrap();
    assert!(start.elapsed() < Duration::from_secs(5));
    Run { code: output.code(), stdout, stderr: String::new() }
}

/// Whether the parent process ignores a signal (background jobs of a script): the program then ignores it as well.
fn is_off(signal: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}

#[test]
fn an_interrupt_saves_the_picture() {
    for (name, number, code) in [("-INT", 2, 130), ("-TERM", 15, 143), ("-HUP", 1, 129)] {
        if is_off(number) {
            continue;
        }
        let f = folder();
        let (child, events) = long(&f, &[]);
        signal(&child, name);
        let run = end(child, events);
        assert_eq!(run.code, Some(code), "{run:?}");
        let done: serde_json::Value = serde_json::from_str(run.stdout.lines().last().unwrap()).unwrap();
        assert_eq!((&done["event"], &done["complete"]), (&"done".into(), &false.into()));
        let fraction = done["finished"].as_f64().unwrap();
        assert!(fraction > 0.0 && fraction < 1.0, "{fraction}");
        let (w, h, p) = pixels(&f.read("s.png"));
        assert_eq!((w, h), (200, 200));
        assert!(p.iter().any(|c| c[0] > 0.3));
        // What is needed to continue.
        assert_eq!(f.names(), [".s.png.turner-checkpoint", "s.png", "s.toml"]);
        assert_eq!(done["checkpoint"], ".s.png.turner-checkpoint");
    }
}

/// `timeout` signals the program, and then its process group: the second signal belongs to the first.
#[test]
fn two_signals_at_once_are_one_request() {
    if is_off(15) {
        return;
    }
    let f = folder();
    let (child, events) = long(&f, &[]);
    let id = child.id().to_string();
    let script = "kill -TERM $0; kill -TERM $0; kill -CONT $0; sleep 0.05; kill -TERM $0";
    assert!(Command::new("sh").args(["-c", script, &id]).status().unwrap().success());
    let run = end(child, events);
    assert_eq!(run.code, Some(143), "{run:?}");
    assert_eq!(pixels(&f.read("s.png")).0, 200);
}

/// Ended by `timeout` at random moments, also in the first pass: once rendering has begun there is a whole picture.
#[test]
fn timeout_keeps_the_picture() {
    let f = folder();
    for i in 0..10 {
        let _ = std::fs::remove_file(f.path().join("s.png"));
        let time = format!("{:.3}", 0.03 + 0.35 * (f64::from(i) * 0.618_034 % 1.0));
        let size = ["--width", "400", "--height", "400", "--samples", "1000000", "--integrator", "path"];
        let mut command = Command::new("timeout");
        command.args([&time, env!("CARGO_BIN_EXE_turner"), "s.toml", "--json"]).args(size);
        let Ok(output) = command.current_dir(f.path()).output() else { return };
        let run = Run::of(output);
        assert!([Some(124), Some(143)].contains(&run.code), "{run:?}");
        if run.stdout.contains("\"start\"") {
            let png = f.read("s.png");
            assert_eq!(pixels(&png).0, 400);
            // Colour type 2, RGB: no pixel is missing, which would be transparent.
            assert_eq!(png[25], 2, "{time}: {run:?}");
        }
    }
}

#[test]
fn while_it_renders_there_is_no_other_file() {
    let f = folder();
    let (mut child, _events) = long(&f, &[]);
    assert_eq!(f.names(), ["s.toml"]);
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(f.names(), ["s.toml"]);
}

/// A signal that the parent process ignores (`nohup`) does not stop the program.
#[test]
fn signals_that_are_turned_off_stay_so() {
    let f = folder();
    let script = r#"trap '' HUP; "$0" s.toml --width 200 --height 200 --antialias monte-carlo --samples 200 --json > said & pid=$!
        while ! grep -q start said; do sleep 0.01; done
        kill -HUP $pid; wait $pid"#;
    let run =
        Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_turner")]).current_dir(f.path()).output();
    assert_eq!(run.unwrap().status.code(), Some(0));
    assert!(String::from_utf8(f.read("said")).unwrap().contains("\"complete\":true"));
}
