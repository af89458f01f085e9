//! Runs Turner as a program and reads its events.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use turner::schema::{ErrorCode, SceneError};
use turner_cli::failure::Failure;

use crate::message::one_line;
use crate::picture::Picture;

/// A program of Turner.
pub(super) struct Turner {
    /// As tables show it.
    pub(super) name: &'static str,
    /// The version that it states.
    pub(super) version: String,
    program: PathBuf,
    /// Arguments before all others.
    first: Option<&'static str>,
}

/// How a picture is rendered.
#[derive(Clone, Copy)]
pub(super) struct Order<'a> {
    pub(super) scene: &'a Path,
    /// Columns and rows.
    pub(super) size: (u32, u32),
    /// Per pixel.
    pub(super) samples: u32,
    pub(super) seed: u32,
    pub(super) threads: usize,
}

impl Turner {
    /// The program at `path`, or the Turner that this program contains. Fails if it cannot be run.
    pub(super) fn new(name: &'static str, path: Option<&Path>) -> Result<Turner, Failure> {
        let own =
            || std::env::current_exe().map_err(|e| failed(format!("this program cannot be found: {e}")));
        let (program, first) = match path {
            Some(path) => (path.to_owned(), None),
            None => (own()?, Some(crate::TURNER)),
        };
        let mut turner = Turner { name, version: String::new(), program, first };
        let output = turner.run(&["--version".into()])?;
        let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        if !output.status.success() || !version.starts_with("turner ") {
            let shown = turner.program.display();
            return Err(failed(format!(
                "{shown} does not answer --version as Turner does: {}",
                output.status
            )));
        }
        turner.version = one_line(version.trim_start_matches("turner "));
        Ok(turner)
    }

    fn run(&self, args: &[OsString]) -> Result<Output, Failure> {
        let mut command = Command::new(&self.program);
        command.args(self.first).args(args).stdin(Stdio::null());
        command.output().map_err(|e| failed(format!("{} cannot be run: {e}", self.program.display())))
    }

    /// Renders a picture into `folder`. Returns the seconds of rendering, without loading and saving.
    pub(super) fn render(&self, order: Order<'_>, folder: &Path) -> Result<(f64, Vec<[f64; 3]>), Failure> {
        let file = folder.join("picture.exr");
        let mut args: Vec<OsString> =
            vec!["render".into(), order.scene.into(), "--output".into(), file.clone().into()];
        for (option, value) in [
            ("--width", order.size.0.to_string()),
            ("--height", order.size.1.to_string()),
            ("--samples", order.samples.to_string()),
            ("--seed", order.seed.to_string()),
            ("--threads", order.threads.to_string()),
            ("--denoise", "off".into()),
        ] {
            args.extend([option.into(), value.into()]);
        }
        args.extend(["--json".into(), "--allow-outside".into()]);
        let output = self.run(&args)?;
        let why = |what: String| failed(format!("{}: {what}", self.name));
        let seconds = seconds(&String::from_utf8_lossy(&output.stdout))
            .map_err(|event| why(event.unwrap_or_else(|| last_words(&output))))?;
        let picture = Picture::read(&file)?;
        if (picture.width, picture.height) != order.size {
            let (width, height) = order.size;
            return Err(why(format!(
                "an image of {}x{} pixels, expected {width}x{height}",
                picture.width, picture.height
            )));
        }
        Ok((seconds, picture.pixels))
    }
}

fn failed(what: String) -> Failure {
    Failure::new(SceneError::new(ErrorCode::File, what))
}

/// The seconds of rendering in the events of a complete picture; else the message of the first error, if there is one.
fn seconds(events: &str) -> Result<f64, Option<String>> {
    let events: Vec<Value> = events.lines().filter_map(|l| serde_json::from_str(l).ok()).collect();
    let of = |kind: &str| events.iter().find(|e| e.get("event").and_then(Value::as_str) == Some(kind));
    if let Some(error) = of("error") {
        let part = |key: &str| error.get(key).and_then(Value::as_str);
        let place = match (part("file"), error.get("line").and_then(Value::as_u64)) {
            (Some(file), Some(line)) => format!(" ({}, line {line})", one_line(file)),
            _ => String::new(),
        };
        return Err(part("message").map(|message| format!("{}{place}", one_line(message))));
    }
    let done = of("done").ok_or(None)?;
    if done.get("complete").and_then(Value::as_bool) == Some(false) {
        return Err(Some("the picture is not complete".into()));
    }
    let seconds = done.pointer("/seconds/render").and_then(Value::as_f64);
    seconds.filter(|s| *s > 0.0).ok_or_else(|| Some("it reports no seconds of rendering".into()))
}

/// What a program without an error event said at last.
fn last_words(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().rev().map(str::trim).find(|l| !l.is_empty());
    format!("the program ended ({}): {}", output.status, one_line(last.unwrap_or("no message")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_have_the_seconds_or_the_reason() {
        let done = |more: &str| format!("{{\"event\":\"start\"}}\n{{\"event\":\"done\",{more}}}\n");
        assert_eq!(seconds(&done(r#""seconds":{"load":1,"render":2.5},"complete":true"#)), Ok(2.5));
        let cases = [
            ("", None),
            ("not JSON", None),
            ("{\"event\":\"start\"}", None),
            (&done(r#""seconds":{"load":1}"#), Some("it reports no seconds of rendering")),
            (&done(r#""seconds":{"render":1},"complete":false"#), Some("the picture is not complete")),
            (
                r#"{"event":"error","message":"unknown plugin","file":"a.xml","line":7}"#,
                Some("unknown plugin (a.xml, line 7)"),
            ),
            (r#"{"event":"error","message":"no memory","file":null,"line":null}"#, Some("no memory")),
        ];
        for (events, why) in cases {
            assert_eq!(seconds(events), Err(why.map(str::to_owned)), "{events}");
        }
    }
}
