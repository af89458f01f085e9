//! A run of the program with limits on time and memory.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Largest CPU time of a run, seconds.
const TIME: f64 = 10.0;
/// Largest wall-clock time, for a busy machine.
const WAIT: Duration = Duration::from_secs(100);
/// Largest memory: 1 GB.
const MEMORY: u64 = 1_000_000_000;
/// Content of files next to the folder of a case.
pub(super) const SECRET: &str = "outside-7f3a91";

/// The expected result of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Expected {
    /// A picture, or an error.
    Either,
    /// A picture.
    Picture,
    /// An error.
    Error,
}

/// Files, and the one that is rendered.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) name: String,
    main: String,
    files: Vec<(String, Vec<u8>)>,
    expected: Expected,
}

impl Case {
    pub(super) fn new(name: impl Into<String>, main: &str, files: Vec<(String, Vec<u8>)>) -> Case {
        Case { name: name.into(), main: main.to_owned(), files, expected: Expected::Either }
    }

    /// A single file.
    pub(super) fn one(name: impl Into<String>, file: &str, bytes: impl Into<Vec<u8>>) -> Case {
        Case::new(name, file, vec![(file.to_owned(), bytes.into())])
    }

    pub(super) fn must(mut self, expected: Expected) -> Case {
        self.expected = expected;
        self
    }
}

/// Runs all cases on all cores, and names those that fail.
#[track_caller]
pub(super) fn try_all(cases: Vec<Case>) {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut faults = Vec::new();
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let folder = tempfile::tempdir().unwrap();
            for (name, bytes) in &case.files {
                std::fs::write(folder.path().join(name), bytes).unwrap();
            }
            if let Err(fault) = try_one(folder.path(), &case.main, case.expected) {
                keep(folder, &case.name);
                faults.push(format!("{}: {fault}", case.name));
            }
        }
        faults
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let faults: Vec<String> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|w| w.join().unwrap()).collect()
    });
    assert!(faults.is_empty(), "{} of {} cases:\n{}", faults.len(), cases.len(), faults.join("\n"));
}

/// `TURNER_HOSTILE_KEEP=DIR` keeps the files of cases that fail.
fn keep(folder: tempfile::TempDir, name: &str) {
    let Ok(at) = std::env::var("TURNER_HOSTILE_KEEP") else { return };
    let name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    std::fs::create_dir_all(&at).unwrap();
    std::fs::rename(folder.keep(), Path::new(&at).join(name)).unwrap();
}

/// Renders a file at a small size; returns what is wrong with the run.
pub(super) fn try_one(folder: &Path, main: &str, expected: Expected) -> Result<(), String> {
    let out = folder.join("out.png");
    let mut child = Command::new(env!("CARGO_BIN_EXE_turner"))
        .current_dir(folder)
        .args(["render", main, "-o", "out.png", "--width", "16", "--height", "12", "--samples", "1"])
        .args(["--max-depth", "4", "--quiet"])
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::from(std::fs::File::create(folder.join("stderr")).unwrap()))
        .spawn()
        .unwrap();
    let (start, mut most, mut busy) = (Instant::now(), 0, 0.0);
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        most = most.max(peak(child.id()));
        busy = seconds(child.id()).max(busy);
        if busy > TIME || start.elapsed() > WAIT || most > MEMORY {
            child.kill().unwrap();
            child.wait().unwrap();
            let wall = start.elapsed().as_secs();
            return Err(format!("ended after {busy} s ({wall} s) with {} MB", most / 1_000_000));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let said = std::fs::read(folder.join("stderr")).unwrap();
    let said = String::from_utf8(said).map_err(|_| "stderr is not UTF-8".to_owned())?;
    if said.contains(SECRET) {
        return Err(format!("tells what lies outside: {said}"));
    }
    match status.code() {
        Some(0) if expected == Expected::Error => Err("a picture instead of an error".to_owned()),
        Some(0) => {
            let picture = std::fs::read(&out).map_err(|e| format!("no picture: {e}"))?;
            turner_io::image::decode(&picture, "out.png", &Default::default())
                .map(drop)
                .map_err(|e| format!("a damaged picture: {e}"))
        }
        Some(1) if expected == Expected::Picture => Err(format!("an error instead of a picture: {said}")),
        Some(1) => is_clear(&said),
        Some(code) => Err(format!("exit code {code}: {said}")),
        None => Err(format!("ended by {status}: {said}")),
    }
}

/// Checks for 1 to 20 errors with a code and a few lines each, no terminal control characters, and no internal error.
fn is_clear(said: &str) -> Result<(), String> {
    let errors = said.matches("error[E").count();
    let hidden = said.chars().any(|c| (c.is_control() && c != '\n') || matches!(c, '\u{202a}'..='\u{202e}'));
    let fault = [
        (!(1..=20).contains(&errors), "not 1 to 20 errors"),
        (!said.starts_with("error[E"), "does not begin with its code"),
        (said.contains("E0901") || said.contains("panicked"), "a fault of the program"),
        (said.lines().count() > 8 * errors + 2 || said.len() > 3000 * errors, "long"),
        (hidden, "control characters"),
    ];
    match fault.iter().find(|(is, _)| *is) {
        Some((_, what)) => Err(format!("{what}: {said:?}")),
        None => Ok(()),
    }
}

/// Peak memory of a process, bytes; 0 where the system does not report it.
fn peak(id: u32) -> u64 {
    // Between fork and exec the child still has the memory of this process.
    let this = std::env::current_exe().ok();
    if this.is_some() && std::fs::read_link(format!("/proc/{id}/exe")).ok() == this {
        return 0;
    }
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_ascii_whitespace().next().and_then(|n| n.parse::<u64>().ok()).unwrap_or(0) * 1024
}

/// CPU time of a process, in kernel ticks of 1/100 s; 0 where the system does not report it.
fn seconds(id: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    // The fields follow the name, which is in brackets and may contain spaces.
    let rest = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    rest.split_ascii_whitespace().skip(11).take(2).filter_map(|n| n.parse::<f64>().ok()).sum::<f64>() / 100.0
}
