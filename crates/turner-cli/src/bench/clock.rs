//! `turner bench clock`: whether renders keep their time: budgets, first picture, time left, interrupts. The program runs
//! itself, as a person or a script would.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};
use turner::schema::{ErrorCode, SceneError};

use super::{median, reported};
use crate::failure::Failure;
use crate::text;

/// Measure budgets, the first picture, the time left and the end after an interrupt
#[derive(Debug, Args)]
#[command(
    after_help = "Seconds by the clock, with loading and writing. budget: the largest deviation from --budget. first: from the \
                  start of `turner watch` to its first picture. left: the largest error of the time left, relative to the whole time, \
                  after its first tenth. interrupt: from the signal to the end of the program, median and longest."
)]
pub(crate) struct ClockBenchArgs {
    /// Scenes and models
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Budgets to try, in seconds
    #[arg(long, value_name = "SECONDS,…", value_delimiter = ',', default_value = "1,3", value_parser = parse_seconds)]
    budgets: Vec<f64>,
    /// How many renders are interrupted, at moments spread over two seconds
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Width and height of the pictures, e.g. 1920x1080 [default: those of the scenes]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Print one JSON object per line
    #[arg(long)]
    json: bool,
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.trim().parse().ok().filter(|seconds| (0.01..=1e6).contains(seconds));
    seconds.ok_or_else(|| "expected seconds from 0.01 to 1000000, such as 1,3,10".to_owned())
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').map(|(width, height)| [width, height].map(|side| side.trim().parse().ok()));
    match sides {
        Some([Some(width), Some(height)]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("expected columns and rows, such as 1920x1080".to_owned()),
    }
}

/// Runs the command.
pub(crate) fn run(args: &ClockBenchArgs) -> u8 {
    reported(args.json, measure(args))
}

fn measure(args: &ClockBenchArgs) -> Result<(), Failure> {
    let folder = tempfile::tempdir().map_err(failed)?;
    let width = args.files.iter().map(|file| name(file).chars().count()).max().unwrap_or(0).max(5);
    if !args.json {
        text::print(&format!("{:width$}   budget    first   left   interrupt\n", "scene"));
    }
    for file in &args.files {
        let trial = Trial { file, size: args.size, out: folder.path().join("clock.png") };
        let mut budgets = Vec::new();
        for budget in &args.budgets {
            budgets.push(trial.budget(*budget)?);
        }
        let worst = budgets.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let (first, left) = (trial.first_picture()?, trial.time_left()?);
        let mut ends = Vec::new();
        for i in 0..args.repeat {
            ends.extend(trial.interrupt(Duration::from_millis(u64::from(50 + i * 1950 / args.repeat)))?);
        }
        let longest = ends.iter().copied().max_by(f64::total_cmp);
        if args.json {
            text::print(&format!(
                "{}\n",
                json!({ "file": file, "budgets": args.budgets, "over": budgets, "first": first, "left": left, "interrupt": ends })
            ));
            continue;
        }
        let shown = |v: Option<f64>, unit: &str| v.map_or("-".to_owned(), |v| format!("{v:.2}{unit}"));
        text::print(&format!(
            "{:width$}  {:>+5.2} s  {:>7}  {:>5}   {} to {}\n",
            name(file),
            worst.unwrap_or(0.0),
            shown(first, " s"),
            left.map_or("-".to_owned(), |v| format!("{:.0} %", 100.0 * v)),
            shown(median(&ends), " s"),
            shown(longest, " s"),
        ));
    }
    Ok(())
}

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn failed(error: impl ToString) -> Failure {
    Failure::new(SceneError::new(ErrorCode::File, error.to_string()))
}

/// Runs of the program with one scene.
struct Trial<'a> {
    file: &'a Path,
    size: Option<[u32; 2]>,
    /// The picture, in a folder of its own.
    out: PathBuf,
}

impl Trial<'_> {
    /// The program in its own process, with the scene, its size and these options.
    fn start(&self, command: &str, options: &[&str]) -> Result<Child, Failure> {
        let program = std::env::current_exe().map_err(failed)?;
        let mut run = Command::new(program);
        run.arg(command).arg(self.file).args(options).arg("-o").arg(&self.out);
        if let Some([width, height]) = self.size {
            run.args(["--width", &width.to_string(), "--height", &height.to_string()]);
        }
        let _ = std::fs::remove_file(&self.out);
        run.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().map_err(failed)
    }

    /// Waits for the end, and for its success.
    fn end(&self, mut child: Child) -> Result<(), Failure> {
        let status = child.wait().map_err(failed)?;
        if status.success() {
            return Ok(());
        }
        let file = self.file.display();
        let message = format!("{file}: the render failed: {status}");
        Err(Failure::new(SceneError::new(ErrorCode::File, message).help(format!("try `turner {file}`"))))
    }

    /// Seconds beyond a budget of so many seconds.
    fn budget(&self, seconds: f64) -> Result<f64, Failure> {
        let start = Instant::now();
        let mut child = self.start("render", &["--quiet", "--budget", &format!("{seconds}s")])?;
        drop(child.stdout.take());
        self.end(child)?;
        Ok(start.elapsed().as_secs_f64() - seconds)
    }

    /// Seconds to the first picture of `turner watch`; `None` if there is none after half a minute.
    fn first_picture(&self) -> Result<Option<f64>, Failure> {
        let start = Instant::now();
        let mut child = self.start("watch", &[])?;
        let mut found = None;
        while found.is_none() && start.elapsed() < Duration::from_secs(30) {
            std::thread::sleep(Duration::from_millis(2));
            found = self.out.exists().then(|| start.elapsed().as_secs_f64());
        }
        child.kill().and_then(|()| child.wait()).map_err(failed)?;
        Ok(found)
    }

    /// The largest error of the time left relative to the whole time, after its first tenth.
    fn time_left(&self) -> Result<Option<f64>, Failure> {
        let mut child = self.start("render", &["--json"])?;
        let lines = child.stdout.take().map(|out| BufReader::new(out).lines().map_while(Result::ok));
        let events: Vec<Value> =
            lines.into_iter().flatten().filter_map(|line| serde_json::from_str(&line).ok()).collect();
        self.end(child)?;
        let whole = events.iter().find_map(|e| e["seconds"]["render"].as_f64());
        let Some(whole) = whole else { return Ok(None) };
        let estimates =
            events.iter().filter_map(|e| Some((e["seconds"].as_f64()?, e["seconds_left"].as_f64()?)));
        let late = estimates.filter(|(seconds, _)| *seconds >= 0.1 * whole);
        Ok(late.map(|(seconds, left)| (seconds + left - whole).abs() / whole).max_by(f64::total_cmp))
    }

    /// Seconds from an interrupt `after` the start to the end of the program; `None` if it had ended before, or if this
    /// system has no signals.
    fn interrupt(&self, after: Duration) -> Result<Option<f64>, Failure> {
        let mut child = self.start("render", &["--quiet", "--samples", "65536"])?;
        drop(child.stdout.take());
        std::thread::sleep(after);
        let start = Instant::now();
        if !interrupt(&child) {
            child.kill().and_then(|()| child.wait()).map_err(failed)?;
            return Ok(None);
        }
        let status = child.wait().map_err(failed)?;
        Ok((!status.success()).then(|| start.elapsed().as_secs_f64()))
    }
}

/// Asks a program to end.
#[cfg(unix)]
fn interrupt(child: &Child) -> bool {
    use rustix::process::{Pid, Signal, kill_process};
    let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    pid.is_some_and(|pid| kill_process(pid, Signal::INT).is_ok())
}

#[cfg(not(unix))]
fn interrupt(_: &Child) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_budgets() {
        assert_eq!(parse_size("1920x1080"), Ok([1920, 1080]));
        for bad in ["", "x", "1920", "0x5", "5x0", "-1x2", "1x2x3"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_seconds("2.5"), Ok(2.5));
        for bad in ["", "0", "-1", "nan", "inf"] {
            assert!(parse_seconds(bad).is_err(), "{bad}");
        }
    }
}
