//! Sequences as one file: GIF, APNG and WebP are built in; ffmpeg encodes videos where it is installed.
//!
//! The frames are rendered as numbered PNG files into a hidden folder beside the animation, so an interrupted render
//! continues with `--resume`. When all are there, they become the file, and the folder is removed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::json;
use turner::image::Pixels;
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::animation::{AnimationFormat, Frame, encode};
use turner_io::image::{DecodeLimits, ImageError, OutputFile, decode};

use crate::failure::{Failure, two_lines};
use crate::report::Reporter;
use crate::sequence::Step;

/// The program that encodes videos.
const FFMPEG: &str = "ffmpeg";

/// Containers of videos: extension, and options of ffmpeg for good quality that browsers play.
const VIDEOS: [(&str, &[&str]); 4] = [
    ("mp4", H264),
    ("mov", H264),
    ("mkv", H264),
    ("webm", &["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-pix_fmt", "yuva420p", "-row-mt", "1"]),
];

/// Browsers need an even size and this pixel format; the metadata at the beginning lets a video start at once.
const H264: &[&str] =
    &["-c:v", "libx264", "-crf", "16", "-preset", "slow", "-pix_fmt", "yuv420p", "-movflags", "+faststart"];

/// How frames become a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    BuiltIn(AnimationFormat),
    /// By ffmpeg, with these options.
    Video(&'static [&'static str]),
}

/// An animation to be written.
#[derive(Clone, Debug)]
pub(crate) struct Animation {
    path: PathBuf,
    kind: Kind,
    /// Frames per second.
    rate: f64,
}

impl Kind {
    /// By the extension of a path without `#`, which stands for the numbers of single pictures.
    fn of(path: &Path) -> Option<Kind> {
        let name = path.file_name()?.to_string_lossy();
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        if name.contains('#') {
            return None;
        }
        let video = || VIDEOS.iter().find(|(e, _)| *e == extension).map(|(_, options)| Kind::Video(options));
        AnimationFormat::of_extension(&extension).map(Kind::BuiltIn).or_else(video)
    }

    /// Whether a single picture can have this extension as well.
    fn is_picture(self) -> bool {
        self == Kind::BuiltIn(AnimationFormat::WebP)
    }
}

impl Animation {
    /// The animation that `path` names; `None` if it names pictures.
    ///
    /// Errors: a video without ffmpeg; an animation of one picture; a path that cannot be written.
    pub(crate) fn of(
        path: Option<&Path>,
        is_sequence: bool,
        rate: f64,
    ) -> Result<Option<Animation>, Failure> {
        let Some((path, kind)) = path.and_then(|path| Some((path, Kind::of(path)?))) else { return Ok(None) };
        let shown = path.display();
        let usage = |message: String, help: &str| {
            Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)))
        };
        if !is_sequence {
            if kind.is_picture() {
                return Ok(None);
            }
            return usage(
                format!("{shown}: an animation needs several pictures"),
                "add `--turntable 48` or `--frames 0-47`, or name a picture such as picture.png",
            );
        }
        if matches!(kind, Kind::Video(_)) && !has_ffmpeg() {
            return usage(
                format!("{shown}: videos are encoded by the program ffmpeg, which is not installed"),
                "install ffmpeg, or write an animation that needs no other program: .webp, .apng or .gif",
            );
        }
        OutputFile::create(path).map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        Ok(Some(Animation { path: path.to_owned(), kind, rate }))
    }

    /// The hidden folder of the frames.
    fn folder(&self) -> PathBuf {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        self.path.with_file_name(format!(".{name}.frames"))
    }

    /// The name of the frames, numbered by [`Step::path`].
    pub(crate) fn frames(&self) -> Result<PathBuf, Failure> {
        let folder = self.folder();
        std::fs::create_dir_all(&folder).map_err(|e| self.failed("create the folder of its frames", &e))?;
        Ok(folder.join("frame_####.png"))
    }

    /// Writes the file from the frames of `steps`, and removes them.
    ///
    /// Errors: a frame that cannot be read; ffmpeg fails; the file cannot be written. The frames stay then.
    pub(crate) fn assemble(&self, steps: &[Step], reporter: &Reporter) -> Result<(), Failure> {
        let pattern = self.frames()?;
        match self.kind {
            Kind::BuiltIn(format) => {
                let frame = |i: u32| match steps.get(i as usize) {
                    Some(step) => read(&step.path(&pattern)),
                    None => Ok(Frame { width: 0, height: 0, pixels: Vec::new() }),
                };
                let bytes = encode(format, steps.len() as u32, self.rate, frame)
                    .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
                OutputFile::create(&self.path)
                    .and_then(|file| file.commit(&bytes))
                    .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
            }
            Kind::Video(options) => self.encode_video(options, steps)?,
        }
        // What is left there was not rendered by this program: it stays.
        for step in steps {
            let _ = std::fs::remove_file(step.path(&pattern));
        }
        let _ = std::fs::remove_dir(self.folder());
        let (name, frames) = (self.path.display().to_string(), steps.len());
        match reporter.events {
            Some(events) => events.send(json!({
                "event": "animation",
                "output": name,
                "frames": frames,
                "frames_per_second": self.rate,
            })),
            None => reporter.line(&format!("{name}: {frames} frames, {} per second", self.rate)),
        }
        Ok(())
    }

    /// Encodes the frames with ffmpeg into a hidden file, which then gets its name.
    fn encode_video(&self, options: &[&str], steps: &[Step]) -> Result<(), Failure> {
        let folder = self.folder();
        let extension = self.path.extension().unwrap_or_default();
        let temporary = folder.join("video").with_extension(extension);
        let first = steps.first().and_then(Step::number).unwrap_or(0);
        let result = Command::new(FFMPEG)
            .args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"])
            .args(["-framerate", &self.rate.to_string(), "-start_number", &first.to_string()])
            .arg("-i")
            .arg(folder.join("frame_%04d.png"))
            // An even number of columns and rows.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-fflags", "+bitexact", "-map_metadata", "-1"])
            .args(options)
            .args(["-flags:v", "+bitexact"])
            .arg(&temporary)
            .stdin(Stdio::null())
            .output()
            .map_err(|e| self.failed("start ffmpeg", &e))?;
        if !result.status.success() {
            let text = String::from_utf8_lossy(&result.stderr);
            let last = text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no message").trim();
            let message = format!("{}: ffmpeg failed: {last}", self.path.display());
            let help = format!("the frames were kept in {}; render again with --resume", folder.display());
            return Err(Failure::new(SceneError::new(ErrorCode::Output, message).help(help)));
        }
        std::fs::rename(&temporary, &self.path).map_err(|e| self.failed("move the video to its name", &e))
    }

    fn failed(&self, step: &str, error: &std::io::Error) -> Failure {
        let message = format!("{}: cannot {step}: {error}", self.path.display());
        Failure::new(SceneError::new(ErrorCode::Output, message).help("choose another path"))
    }
}

fn has_ffmpeg() -> bool {
    let run = Command::new(FFMPEG).arg("-version").stdin(Stdio::null()).output();
    run.is_ok_and(|output| output.status.success())
}

/// Reads a frame.
fn read(path: &Path) -> Result<Frame, ImageError> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path)
        .map_err(|e| ImageError::Encode { format: "animation", problem: format!("{name}: {e}") })?;
    let image = decode(&bytes, &name, &DecodeLimits::default())?;
    let bytes: Vec<u8> = match &image.pixels {
        Pixels::U8(samples) => samples.clone(),
        Pixels::U16(samples) => samples.iter().map(|v| ((u32::from(*v) + 128) / 257) as u8).collect(),
        Pixels::F32(_) => Vec::new(),
    };
    let pixels = match image.channels {
        4 => bytes.as_chunks().0.to_vec(),
        3 => bytes.as_chunks::<3>().0.iter().map(|[r, g, b]| [*r, *g, *b, 255]).collect(),
        _ => Vec::new(),
    };
    Ok(Frame { width: image.width, height: image.height, pixels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_choose_the_kind() {
        let kind = |path: &str| Kind::of(Path::new(path));
        assert_eq!(kind("a.GIF"), Some(Kind::BuiltIn(AnimationFormat::Gif)));
        assert_eq!(kind("a.webp"), Some(Kind::BuiltIn(AnimationFormat::WebP)));
        assert_eq!(kind("a.mov"), Some(Kind::Video(H264)));
        for pictures in ["a.png", "a_##.webp", "a", "a.exr"] {
            assert_eq!(kind(pictures), None, "{pictures}");
        }
        let single = |path: &str| Animation::of(Some(Path::new(path)), false, 24.0);
        assert!(single("a.gif").is_err() && single("a.webp").unwrap().is_none());
    }
}
