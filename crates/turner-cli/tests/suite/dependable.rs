//! Existing files and finished tiles survive a killed program, a full disk and a failed worker.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Folder, Run, folder, pixels};

const SIZE: [&str; 6] = ["--width", "160", "--height", "120", "--samples", "2"];
const MANY: [&str; 2] = ["--antialias", "monte-carlo"];

fn render(f: &Folder, seed: &str) -> Vec<u8> {
    let args = [&["s.toml", "--seed", seed], &SIZE[..], &MANY].concat();
    f.turner(&args).ok();
    f.read("s.png")
}

/// Kills a render at fifty times, from its start to beyond its end.
#[test]
fn a_killed_program_leaves_the_old_file_or_the_new_one() {
    let f = folder();
    let new = render(&f, "2");
    let start = Instant::now();
    let old = render(&f, "1");
    let duration = start.elapsed();
    assert_ne!(old, new);
    let (mut kept, mut replaced) = (0, 0);
    for round in 0..50_u32 {
        std::fs::write(f.path().join("s.png"), &old).unwrap();
        let args = [&["s.toml", "--quiet", "--seed", "2"], &SIZE[..], &MANY].concat();
        let mut child = f.command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // A low-discrepancy sequence, so that the times are spread evenly over 1.3 times the render.
        let fraction = f64::from(round) * 0.618_034 % 1.0;
        std::thread::sleep(duration.mul_f64(fraction * 1.3));
        let _ = child.kill();
        child.wait().unwrap();
        let found = f.read("s.png");
        assert!(found == old || found == new, "round {round}: {} bytes", found.len());
        if found == old {
            kept += 1
        } else {
            replaced += 1
        }
        let strange: Vec<String> = f.names().into_iter().filter(|n| !n.ends_with(".tmp")).collect();
        assert_eq!(strange, ["s.png", "s.toml"]);
    }
    assert!(kept > 0, "no render was killed in time: {kept} kept, {replaced} replaced");
    // The next render removes temporary files, except those that are still being written.
    f.write(".turner-left.tmp", "half a picture");
    render(&f, "1");
    assert_eq!(f.names(), ["s.png", "s.toml"]);
}

#[test]
fn a_fault_in_a_worker_saves_what_is_finished_and_fails() {
    let f = folder();
    let args = [&["s.toml", "--json", "--threads", "2"], &SIZE[..], &MANY].concat();
    let run = Run::of(f.command(&args).env("TURNER_FAULT_AFTER", "5").output().unwrap());
    let run = run.fails(1, &["a fault while rendering", "TURNER_FAULT_AFTER", "report it"]);
    let done = run.stdout.lines().find(|line| line.contains("\"done\"")).expect("what came of it");
    let done: serde_json::Value = serde_json::from_str(done).unwrap();
    assert_eq!(done["complete"], false);
    let fraction = done["finished"].as_f64().unwrap();
    assert!(fraction > 0.0 && fraction < 1.0, "{fraction}");
    let (width, height, found) = pixels(&f.read("s.png"));
    assert_eq!((width, height), (160, 120));
    let complete = {
        let args = [&["s.toml", "-o", "complete.png"], &SIZE[..], &MANY].concat();
        f.turner(&args).ok();
        pixels(&f.read("complete.png")).2
    };
    // Finished tiles equal those of the complete picture.
    let same = found.iter().zip(&complete).filter(|(a, b)| a == b).count();
    assert!(same > 16 * 16 && same < complete.len(), "{same} of {}", complete.len());
}

#[test]
fn what_cannot_be_written_is_kept_elsewhere() {
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    let f = folder();
    let temporary = f.path().join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let run = f.command(&["s.toml", "-o", "/dev/full", "--format", "png"]).env("TMPDIR", &temporary).output();
    let run = Run::of(run.unwrap()).fails(1, &["/dev/full", "free some space", "was kept as"]);
    let kept: Vec<_> = std::fs::read_dir(&temporary).unwrap().map(|e| e.unwrap().path()).collect();
    assert_eq!(kept.len(), 1, "{run:?}");
    assert_eq!(pixels(&std::fs::read(&kept[0]).unwrap()).0, 24);
}

/// A file system of 64 KiB, where an ordinary user may mount one.
#[test]
fn a_full_disk_is_found_before_rendering() {
    let f = folder();
    std::fs::create_dir(f.path().join("tiny")).unwrap();
    let script = r#"
        mount -t tmpfs -o size=64k tmpfs tiny || exit 77
        echo old > tiny/s.png
        "$0" s.toml -o tiny/s.png --width 24 --height 16 || exit 78
        echo old > tiny/s.png
        "$0" s.toml -o tiny/s.png --width 4000 --height 4000 --antialias monte-carlo --samples 100000 2> said
        [ $? = 1 ] || exit 79
        [ "$(cat tiny/s.png)" = old ] || exit 80
        [ "$(ls -A tiny)" = s.png ] || exit 81
        head -c 100000 /dev/zero > tiny/filler 2> /dev/null
        "$0" s.toml -o tiny/s.png --width 24 --height 16 2>> said
        [ $? = 1 ] || exit 82
        [ "$(cat tiny/s.png)" = old ] || exit 83
    "#;
    let mut unshare = Command::new("unshare");
    unshare.args(["--user", "--map-root-user", "--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_turner")]);
    let start = Instant::now();
    let Ok(output) = unshare.current_dir(f.path()).output() else { return };
    let run = Run::of(output);
    // Mounting may not be permitted.
    if run.code == Some(77) || run.stderr.starts_with("unshare") {
        return;
    }
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(start.elapsed() < Duration::from_secs(20), "it was found late");
    let said = String::from_utf8(f.read("said")).unwrap();
    assert!(said.contains("may take 48.0 MB") && said.contains("free some space"), "{said}");
}
