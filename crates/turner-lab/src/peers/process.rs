//! Another renderer in its own process: `benches/peers/render.py` reads one line per image and answers with one.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use clap::ValueEnum;
use serde_json::Value;
use tempfile::TempDir;
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_cli::failure::Failure;

use super::install;
use crate::message::one_line;

/// The script, embedded so that it works from any folder.
const SCRIPT: &str = include_str!("../../../../benches/peers/render.py");

/// Renderers to compare with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PeerKind {
    /// Mitsuba 3, compiled by LLVM, with its stratified sampler `multijitter`
    MitsubaLlvm,
    /// The same with its default sampler `independent`
    MitsubaLlvmIndependent,
    /// Mitsuba 3, one path at a time
    MitsubaScalar,
    /// Blender's Cycles on the CPU
    Cycles,
    /// All except the one with the default sampler
    All,
}

impl PeerKind {
    /// The renderers requested, without duplicates.
    pub(crate) fn expand(requested: &[PeerKind]) -> Vec<PeerKind> {
        const ALL: [PeerKind; 3] = [PeerKind::MitsubaLlvm, PeerKind::MitsubaScalar, PeerKind::Cycles];
        let mut out = Vec::new();
        for &kind in requested {
            for kind in if kind == PeerKind::All { ALL.to_vec() } else { vec![kind] } {
                if !out.contains(&kind) {
                    out.push(kind);
                }
            }
        }
        out
    }

    /// The name, as in arguments.
    pub(crate) fn name(self) -> &'static str {
        match self {
            PeerKind::MitsubaLlvm => "mitsuba-llvm",
            PeerKind::MitsubaLlvmIndependent => "mitsuba-llvm-independent",
            PeerKind::MitsubaScalar => "mitsuba-scalar",
            PeerKind::Cycles => "cycles",
            PeerKind::All => "all",
        }
    }
}

/// An image and its rendering time.
pub(crate) struct PeerPicture {
    /// Seconds of rendering.
    pub(crate) seconds: f64,
    /// Samples per pixel: some samplers round up.
    pub(crate) samples: u32,
    /// Linear colours, row by row from the top.
    pub(crate) pixels: Vec<[f64; 3]>,
}

/// A renderer that has loaded the scene and waits.
pub(crate) struct Peer {
    pub(crate) kind: PeerKind,
    /// The version it reports.
    pub(crate) version: String,
    /// Seconds until it is ready.
    pub(crate) start: f64,
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    /// Script, images and log.
    folder: TempDir,
}

impl Peer {
    /// Starts the renderer with a description of the scene and waits until it has rendered a first image.
    pub(crate) fn start(
        kind: PeerKind,
        python: Option<&Path>,
        description: &Path,
        threads: usize,
    ) -> Result<Peer, Failure> {
        let mut peer = Peer::spawn(kind, python, description, threads)?;
        peer.wait_until_ready()?;
        Ok(peer)
    }

    /// Starts Mitsuba with a scene in its own format, with an image of about `pixels` pixels in the proportions of the
    /// scene's film. Returns the size of the image, too.
    pub(crate) fn start_scaled(
        kind: PeerKind,
        python: Option<&Path>,
        scene: &Path,
        threads: usize,
        pixels: u32,
    ) -> Result<(Peer, (u32, u32)), Failure> {
        let mut peer = Peer::spawn(kind, python, scene, threads)?;
        let loaded = peer.answer()?;
        let film =
            film_size(&loaded).ok_or_else(|| peer.failed("it reports no size of the scene's film", None))?;
        let size = scaled(film, pixels);
        let requested = peer.request(&format!("{} {}", size.0, size.1));
        // If the process has ended, its answer says why.
        peer.wait_until_ready()?;
        requested?;
        Ok((peer, size))
    }

    fn wait_until_ready(&mut self) -> Result<(), Failure> {
        let ready = self.answer()?;
        self.start = ready.get("start_seconds").and_then(Value::as_f64).unwrap_or(f64::NAN);
        self.version = ready.get("version").and_then(Value::as_str).map(escape).unwrap_or_default();
        Ok(())
    }

    fn spawn(
        kind: PeerKind,
        python: Option<&Path>,
        description: &Path,
        threads: usize,
    ) -> Result<Peer, Failure> {
        let failed = |what: String| Failure::new(SceneError::new(ErrorCode::File, what));
        let folder =
            tempfile::tempdir().map_err(|e| failed(format!("cannot create a temporary folder: {e}")))?;
        let script = folder.path().join("render.py");
        let log = folder.path().join("log");
        let written = std::fs::write(&script, SCRIPT).and_then(|()| File::create(&log));
        let log = written.map_err(|e| failed(format!("{}: {e}", script.display())))?;
        let python: PathBuf = python.map_or_else(install::python, Path::to_owned);
        let mut child = Command::new(&python)
            .arg(&script)
            .arg(kind.name())
            .arg(description)
            .arg(threads.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()
            .map_err(|e| {
                let error = format!("{} cannot be run: {e}", python.display());
                let help = "pass a Python that has the renderers with --python, or add --install-peers";
                Failure::new(SceneError::new(ErrorCode::File, error).help(help))
            })?;
        let (input, output) = (child.stdin.take(), child.stdout.take());
        let Some(output) = output else { return Err(failed("the process has no output".into())) };
        let output = BufReader::new(output);
        Ok(Peer { kind, version: String::new(), start: 0.0, child, input, output, folder })
    }

    /// Renders an image of the scene's size.
    pub(crate) fn render(
        &mut self,
        samples: u32,
        seed: u32,
        (width, height): (u32, u32),
    ) -> Result<PeerPicture, Failure> {
        let path = self.folder.path().join("picture");
        let requested = self.request(&format!("{samples} {seed} {}", path.display()));
        // If the process has ended, its answer says why.
        let answer = self.answer()?;
        requested?;
        let number = |key: &str| answer.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let (seconds, samples) = (number("seconds"), number("samples"));
        if (number("width"), number("height")) != (f64::from(width), f64::from(height)) {
            let what = format!(
                "an image of {}x{} pixels, expected {width}x{height}",
                number("width"),
                number("height")
            );
            return Err(self.failed(&what, None));
        }
        let bytes = std::fs::read(&path).map_err(|e| self.failed(&format!("no image: {e}"), None))?;
        if bytes.len() as u64 != u64::from(width) * u64::from(height) * 12
            || !(seconds > 0.0 && samples >= 1.0)
        {
            return Err(self.failed("an incomplete image", None));
        }
        let value = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let pixels =
            bytes.chunks_exact(12).map(|p| [value(&p[..4]), value(&p[4..8]), value(&p[8..])]).collect();
        Ok(PeerPicture { seconds, samples: samples as u32, pixels })
    }

    /// Writes a line.
    fn request(&mut self, line: &str) -> Result<(), Failure> {
        let Some(input) = &mut self.input else { return Ok(()) };
        let written = writeln!(input, "{line}").and_then(|()| input.flush());
        written.map_err(|e| self.failed(&e.to_string(), None))
    }

    /// Reads the next line.
    fn answer(&mut self) -> Result<Value, Failure> {
        let mut line = String::new();
        let read = self.output.read_line(&mut line);
        let json = serde_json::from_str::<Value>(&line);
        match (read, json) {
            (Ok(1..), Ok(json)) => match json.get("error").and_then(Value::as_str) {
                Some(error) => {
                    let help = json.get("help").and_then(Value::as_str).filter(|h| !h.is_empty());
                    Err(self.failed(error, help))
                }
                None => Ok(json),
            },
            _ => {
                let log = std::fs::read(self.folder.path().join("log")).unwrap_or_default();
                let log = String::from_utf8_lossy(&log).into_owned();
                let message =
                    log.lines().find(|l| l.contains("ERROR") || l.contains("Error")).or(log.lines().last());
                let llvm = message.is_some_and(|l| l.contains("LLVM"));
                let help = llvm.then_some(
                    "Mitsuba needs libLLVM 16 or newer, best 19: name it with DRJIT_LIBLLVM_PATH, or choose another renderer, such as mitsuba-scalar",
                );
                Err(self.failed(&format!("the process ended: {}", message.unwrap_or("no message")), help))
            }
        }
    }

    fn failed(&self, what: &str, help: Option<&str>) -> Failure {
        let error = SceneError::new(ErrorCode::File, format!("{}: {}", self.kind.name(), one_line(what)));
        Failure::new(match help {
            Some(help) => error.help(help.to_owned()),
            None => error,
        })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // Closing its input ends the process; kill it in case it hangs.
        drop(self.input.take());
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// `width` and `height` of an answer, if both are positive whole numbers.
fn film_size(answer: &Value) -> Option<(u32, u32)> {
    let of = |key: &str| {
        let value = answer.get(key).and_then(Value::as_u64)?;
        u32::try_from(value).ok().filter(|v| *v > 0)
    };
    Some((of("width")?, of("height")?))
}

/// About `pixels` pixels in the proportions of a film of `width` × `height`.
fn scaled((width, height): (u32, u32), pixels: u32) -> (u32, u32) {
    let (width, height) = (f64::from(width), f64::from(height));
    let factor = (f64::from(pixels) / (width * height)).sqrt();
    let of = |length: f64| (length * factor).round().max(1.0) as u32;
    (of(width), of(height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_are_scaled_in_their_proportions() {
        for (film, expected) in [
            ((1280, 720), (320, 180)),
            ((720, 1280), (180, 320)),
            ((1024, 1024), (240, 240)),
            ((1536, 1024), (294, 196)),
            ((32, 32), (240, 240)),
            ((100_000, 1), (75_895, 1)),
        ] {
            assert_eq!(scaled(film, 57_600), expected, "{film:?}");
        }
    }

    #[test]
    fn sizes_of_films_are_positive_whole_numbers() {
        let of = |text: &str| film_size(&serde_json::from_str(text).unwrap());
        assert_eq!(of(r#"{"width": 768, "height": 576}"#), Some((768, 576)));
        for wrong in
            [r#"{"width": 768}"#, r#"{"width": 0, "height": 5}"#, r#"{"width": 1.5, "height": 5}"#, "[]"]
        {
            assert_eq!(of(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn all_expands_to_three_without_duplicates() {
        let names = |requested: &[PeerKind]| -> Vec<_> {
            PeerKind::expand(requested).iter().map(|k| k.name()).collect()
        };
        assert_eq!(names(&[PeerKind::Cycles, PeerKind::All]), ["cycles", "mitsuba-llvm", "mitsuba-scalar"]);
        for kind in PeerKind::value_variants() {
            assert_eq!(kind.to_possible_value().unwrap().get_name(), kind.name());
        }
    }
}
