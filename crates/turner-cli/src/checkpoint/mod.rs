//! Checkpoints of renders: options, names, and the checks when one is continued.
//!
//! ```text
//! render ── Writer ─> .picture.png.turner-checkpoint      every 30 s, and after an interrupt
//! resume, render --resume, merge ── read ── check ─> film
//! ```
//!
//! `turner_io::checkpoint` is the file format.

pub(crate) mod arguments;
mod writer;

use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use turner::schema::error::escape;
use turner::schema::{ErrorCode, Limits, SceneError};
use turner_io::checkpoint::{Checkpoint, EXTENSION, Header};
use turner_io::image::OutputFile;

use crate::failure::{Failure, two_lines};
use crate::output::Output;
use crate::render::RenderArgs;
pub(crate) use writer::Writer;

/// The version of this program.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Options for checkpoints.
#[derive(Debug, Default, Args)]
pub(crate) struct CheckpointArgs {
    /// Checkpoint file; it stays when the picture is done [default: .PICTURE.turner-checkpoint, after a minute]
    #[arg(long, value_name = "FILE")]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Write the checkpoint every SECONDS from the beginning [default: 30, after a minute]
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub(crate) checkpoint_interval: Option<f64>,
    /// Continue from checkpoints, and skip pictures that are complete
    #[arg(long)]
    pub(crate) resume: bool,
    /// Trace only the samples FIRST to END - 1 of every pixel, for `turner merge`
    #[arg(long, value_name = "FIRST..END", value_parser = parse_range)]
    pub(crate) sample_range: Option<SampleRange>,
    /// Trace only part I of N equal parts of the samples, counted from 1, for `turner merge` [output: SCENE-I-of-N.turner-checkpoint]
    #[arg(long, value_name = "I/N", value_parser = parse_part, conflicts_with = "sample_range")]
    pub(crate) part: Option<Part>,
}

impl CheckpointArgs {
    /// Whether only a part of the samples is traced.
    pub(crate) fn is_part(&self) -> bool {
        self.sample_range.is_some() || self.part.is_some()
    }

    /// The sample indices of a picture with `samples` samples per pixel that are traced.
    pub(crate) fn samples(&self, samples: u32) -> Result<Range<u32>, Failure> {
        match (self.sample_range, self.part) {
            (Some(range), _) => range.within(samples),
            (None, Some(part)) => part.within(samples),
            (None, None) => Ok(0..samples),
        }
    }
}

/// The part of the samples of `--part`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// Its number, from 1.
    number: u32,
    /// How many there are.
    count: u32,
}

impl Part {
    /// The sample indices: parts differ by at most one sample.
    fn within(self, samples: u32) -> Result<Range<u32>, Failure> {
        let at = |n: u32| (u64::from(samples) * u64::from(n) / u64::from(self.count)) as u32;
        if self.count <= samples {
            return Ok(at(self.number - 1)..at(self.number));
        }
        let message =
            format!("--part {}/{}: the picture has {samples} samples per pixel", self.number, self.count);
        let help = format!("make at most {samples} parts, or raise the number with `--samples`");
        Err(Failure::usage(SceneError::new(ErrorCode::OutOfRange, message).help(help)))
    }

    /// The checkpoint of the part, in the current folder: `room-03-of-16.turner-checkpoint`. Names sort by number.
    pub(crate) fn file(self, scene: &Path) -> PathBuf {
        let digits = self.count.to_string().len();
        let stem = scene.file_stem().unwrap_or(scene.as_os_str()).to_string_lossy();
        PathBuf::from(format!("{stem}-{:0digits$}-of-{}.{EXTENSION}", self.number, self.count))
    }
}

/// The samples of `--sample-range`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleRange {
    /// The first index.
    first: u32,
    /// The index after the last.
    end: u32,
}

impl SampleRange {
    /// The sample indices, which must be below `samples`.
    pub(crate) fn within(self, samples: u32) -> Result<Range<u32>, Failure> {
        if self.end <= samples {
            return Ok(self.first..self.end);
        }
        let message = format!(
            "--sample-range {}..{} reaches beyond the {samples} samples per pixel",
            self.first, self.end
        );
        let help = format!("end at {samples}, or raise the number with `--samples {}`", self.end);
        Err(Failure::usage(SceneError::new(ErrorCode::OutOfRange, message).help(help)))
    }
}

pub(crate) fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.01..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds from 0.01 to 1000000; write `--checkpoint-interval 30`".to_owned()),
    }
}

pub(crate) fn parse_part(text: &str) -> Result<Part, String> {
    let numbers = text.split_once('/').map(|(a, b)| (a.trim().parse(), b.trim().parse()));
    match numbers {
        Some((Ok(number), Ok(count))) if (1..=count).contains(&number) => Ok(Part { number, count }),
        _ => {
            Err("expected the number of the part, from 1, and how many there are; write `--part 1/64`"
                .to_owned())
        }
    }
}

pub(crate) fn parse_range(text: &str) -> Result<SampleRange, String> {
    let numbers = text.split_once("..").map(|(a, b)| (a.trim().parse(), b.trim().parse()));
    match numbers {
        Some((Ok(first), Ok(end))) if first < end => Ok(SampleRange { first, end }),
        _ => {
            Err("expected the first index and the one after the last; write `--sample-range 0..64`"
                .to_owned())
        }
    }
}

/// Whether a path has the extension of checkpoints.
pub(crate) fn has_extension(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == EXTENSION)
}

/// The checkpoint beside a picture: `.picture.png.turner-checkpoint`; with a number if `number` is above 1.
pub(crate) fn beside(picture: &Path, number: u32) -> PathBuf {
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    let more = if number > 1 { format!("-{number}") } else { String::new() };
    picture.with_file_name(format!(".{name}{more}.{EXTENSION}"))
}

/// The most checkpoints of earlier renders beside a picture that are left alone.
const MOST: u32 = 100;

/// The checkpoints beside a picture.
pub(crate) fn all_beside(picture: &Path) -> Vec<PathBuf> {
    (1..=MOST).map(|n| beside(picture, n)).take_while(|path| path.exists()).collect()
}

/// The first name for a checkpoint beside a picture at which there is no file.
fn free_beside(picture: &Path) -> PathBuf {
    let free = (1..MOST).map(|n| beside(picture, n)).find(|path| !path.exists());
    free.unwrap_or_else(|| beside(picture, MOST))
}

/// Reads a checkpoint of this version of Turner.
pub(crate) fn read(path: &Path, limits: &Limits) -> Result<Checkpoint, Failure> {
    let checkpoint = turner_io::checkpoint::read(path, limits).map_err(Failure::new)?;
    let version = &checkpoint.header.turner;
    if version != VERSION {
        let message = format!("{}: written by Turner {}; this is {VERSION}", path.display(), escape(version));
        return Err(Failure::new(
            SceneError::new(ErrorCode::Film, message)
                .help("samples may differ between versions: finish it with that version, or render again"),
        ));
    }
    Ok(checkpoint)
}

/// An error unless the checkpoint belongs to a scene with this hash.
pub(crate) fn check_scene(path: &Path, header: &Header, shared_hash: &str) -> Result<(), SceneError> {
    if header.scene_hash == shared_hash {
        return Ok(());
    }
    let short = |hash: &str| escape(hash).chars().take(16).collect::<String>();
    let message = format!(
        "{}: the scene or its options changed since: its hash was {} and is {}",
        path.display(),
        short(&header.scene_hash),
        short(shared_hash)
    );
    Err(SceneError::new(ErrorCode::Conflict, message)
        .help("restore the files of the scene (scene, models, textures), or render again"))
}

/// The command that continues a checkpoint.
pub(crate) fn command(path: &Path) -> String {
    format!("turner resume {}", crate::text::shell_word(&path.to_string_lossy()))
}

/// An error where options for checkpoints contradict the rest.
pub(crate) fn refusal(args: &RenderArgs, output: &Output) -> Option<Failure> {
    let usage = |message: &str, help: &str| {
        Some(Failure::usage(SceneError::new(ErrorCode::Usage, message).help(help)))
    };
    let CheckpointArgs { checkpoint, .. } = &args.checkpoints;
    let part = output.file().filter(|_| output.is_part());
    let Some(file) = checkpoint.as_deref().or(part) else {
        let help = "add `--checkpoint part.turner-checkpoint`, or write it to `-o part.turner-checkpoint`";
        let message = "--sample-range renders a part: it needs a checkpoint file for `turner merge`";
        return args.checkpoints.is_part().then(|| usage(message, help)).flatten();
    };
    if args.is_sequence() {
        let help = "omit it: checkpoints of a sequence lie beside its pictures";
        return usage("one checkpoint cannot hold several pictures", help);
    }
    if part.is_some_and(|part| part != file) {
        return usage("there are two checkpoint files", "name it once: `-o FILE` or `--checkpoint FILE`");
    }
    if args.scene.scene.to_str().is_none_or(|scene| scene == "-") || args.recorded.is_none() {
        let message =
            "a scene from standard input, or with names that are not UTF-8, cannot have a checkpoint";
        return usage(message, "write the scene to a file, or omit the checkpoint");
    }
    if !is_free(file) {
        let message = format!("{}: exists and is not a checkpoint", file.display());
        return usage(&message, "name another file for the checkpoint");
    }
    match OutputFile::create(file) {
        Ok(_) => None,
        Err(error) => Some(Failure::new(two_lines(ErrorCode::Output, &error.to_string()))),
    }
}

/// Whether a file does not exist or is a checkpoint that may be replaced.
fn is_free(path: &Path) -> bool {
    let mut start = [0; 32];
    match std::fs::File::open(path).and_then(|mut file| file.read(&mut start)) {
        Ok(length) => length == 0 || turner_io::checkpoint::is_checkpoint(&start[..length]),
        Err(_) => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_intervals() {
        assert_eq!(parse_range("0..64"), Ok(SampleRange { first: 0, end: 64 }));
        for bad in ["", "3", "4..4", "9..3", "a..b", "-1..2", "0..99999999999"] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_seconds("0.5"), Ok(0.5));
        for bad in ["", "0", "-1", "nan", "inf", "1e9"] {
            assert!(parse_seconds(bad).is_err(), "{bad}");
        }
        assert!(SampleRange { first: 3, end: 9 }.within(8).is_err());
    }

    #[test]
    fn parts_are_all_samples_once() {
        for bad in ["", "3", "0/4", "5/4", "1/0", "a/b", "-1/2", "1/99999999999"] {
            assert!(parse_part(bad).is_err(), "{bad}");
        }
        for (samples, count) in [(64, 64), (64, 7), (1 << 24, 1000), (5, 2)] {
            let mut next = 0;
            for number in 1..=count {
                let range = Part { number, count }.within(samples).unwrap();
                assert_eq!(range.start, next);
                assert!((samples / count..=samples / count + 1).contains(&(range.end - range.start)));
                next = range.end;
            }
            assert_eq!(next, samples);
        }
        assert!(Part { number: 1, count: 9 }.within(8).is_err());
        let file = Part { number: 3, count: 16 }.file(Path::new("scenes/room.toml"));
        assert_eq!(file, Path::new("room-03-of-16.turner-checkpoint"));
    }

    #[test]
    fn names_beside_pictures() {
        assert_eq!(beside(Path::new("a/b.png"), 1), Path::new("a/.b.png.turner-checkpoint"));
        assert_eq!(beside(Path::new("b.png"), 2), Path::new(".b.png-2.turner-checkpoint"));
        assert!(has_extension(&beside(Path::new("b"), 1)) && !has_extension(Path::new("turner-checkpoint")));
    }
}
