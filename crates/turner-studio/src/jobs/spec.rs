//! What a job renders, as arguments of the command line.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The name of the scene in a job's folder.
pub(super) const SCENE: &str = "scene.toml";

/// The name of the checkpoint in a job's folder.
pub(super) const CHECKPOINT: &str = "render.turner-checkpoint";

/// When a render ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum End {
    /// After the samples of the scene.
    #[default]
    Scene,
    /// After this many samples per pixel.
    Samples(u32),
    /// After this many seconds.
    Seconds(f64),
    /// When 95 % of the pixels are this accurate, as a fraction.
    Noise(f64),
}

/// Several pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Sequence {
    /// One picture.
    #[default]
    Single,
    /// Frames of the animation: the first, the last, frames per second.
    Frames(u32, u32, f64),
    /// A camera that circles the scene once: the number of pictures.
    Turntable(u32),
}

/// What a job renders.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// The picture or animation file; its extension chooses the format.
    pub output: PathBuf,
    /// When it ends.
    pub end: End,
    /// Size in pixels; that of the scene for `None`.
    pub size: Option<[u32; 2]>,
    /// The name of a denoiser, or "off"; that of the scene for `None`.
    pub denoise: Option<&'static str>,
    /// Whether it can be stopped and continued.
    pub checkpoint: bool,
    /// Whether it renders several pictures.
    pub sequence: Sequence,
    /// Whether programs in use come first.
    pub nice: bool,
}

impl Spec {
    /// The finished picture of the scene, with a checkpoint and low priority.
    pub fn new(output: PathBuf) -> Spec {
        Spec {
            output,
            end: End::Scene,
            size: None,
            denoise: None,
            checkpoint: true,
            sequence: Sequence::Single,
            nice: true,
        }
    }

    /// The number of pictures.
    pub fn pictures(&self) -> u32 {
        match self.sequence {
            Sequence::Single => 1,
            Sequence::Frames(first, last, _) => last.saturating_sub(first).saturating_add(1),
            Sequence::Turntable(count) => count.max(1),
        }
    }

    /// What keeps it from being rendered, in words.
    pub fn problem(&self) -> Option<&'static str> {
        let is_sequence = self.sequence != Sequence::Single;
        match () {
            () if self.output.file_name().is_none() || self.output.is_dir() => Some("Name a file"),
            () if self.output.extension().is_none() => {
                Some("Give the file an extension, such as .png or .exr")
            }
            () if !self.output.parent().is_some_and(Path::is_dir) => Some("The folder does not exist"),
            () if is_sequence
                && matches!(self.sequence, Sequence::Frames(first, last, _) if first > last) =>
            {
                Some("The last frame comes before the first")
            }
            () => None,
        }
    }

    /// The arguments of the command line. The scene is read in `folder`; what was rendered before is continued.
    pub(super) fn args(&self, folder: &Path) -> Vec<OsString> {
        let mut args: Vec<OsString> = vec!["render".into(), folder.join(SCENE).into(), "--json".into()];
        let mut add = |option: &str, value: OsString| args.extend([OsString::from(option), value]);
        add("--output", self.output.clone().into());
        match self.end {
            End::Scene => {}
            End::Samples(samples) => add("--samples", samples.to_string().into()),
            End::Seconds(seconds) => add("--budget", format!("{seconds}s").into()),
            End::Noise(noise) => add("--noise", noise.to_string().into()),
        }
        if let Some([width, height]) = self.size {
            add("--width", width.to_string().into());
            add("--height", height.to_string().into());
        }
        if let Some(denoise) = self.denoise {
            add("--denoise", denoise.into());
        }
        match self.sequence {
            Sequence::Single if self.checkpoint => {
                add("--checkpoint", folder.join(CHECKPOINT).into());
                add("--checkpoint-interval", "5".into());
            }
            Sequence::Single => {}
            Sequence::Frames(first, last, fps) => {
                add("--frames", format!("{first}-{last}").into());
                add("--fps", fps.to_string().into());
            }
            Sequence::Turntable(count) => add("--turntable", count.to_string().into()),
        }
        if self.checkpoint {
            args.push("--resume".into());
        }
        args
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(spec: &Spec) -> String {
        let words = spec.args(Path::new("j"));
        words.iter().map(|word| word.to_string_lossy().replace('\\', "/")).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_job_is_a_command_line() {
        let mut spec = Spec::new("a.exr".into());
        assert_eq!(
            line(&spec),
            "render j/scene.toml --json --output a.exr --checkpoint j/render.turner-checkpoint --checkpoint-interval 5 --resume"
        );
        spec.end = End::Seconds(1.5);
        spec.size = Some([32, 16]);
        spec.denoise = Some("fast");
        spec.sequence = Sequence::Frames(2, 4, 24.0);
        assert_eq!(
            line(&spec),
            "render j/scene.toml --json --output a.exr --budget 1.5s --width 32 --height 16 --denoise fast --frames 2-4 --fps 24 --resume"
        );
        assert_eq!(spec.pictures(), 3);
        (spec.checkpoint, spec.sequence, spec.end) = (false, Sequence::Turntable(8), End::Noise(0.02));
        assert!(line(&spec).ends_with("--noise 0.02 --width 32 --height 16 --denoise fast --turntable 8"));
    }

    #[test]
    fn what_cannot_be_rendered_is_known_before() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str| Spec::new(folder.path().join(name)).problem();
        assert_eq!(of("a.png"), None);
        assert!(of("").is_some() && of("a").is_some() && of("b/a.png").is_some());
        let mut spec = Spec::new(folder.path().join("a.png"));
        spec.sequence = Sequence::Frames(4, 2, 24.0);
        assert!(spec.problem().is_some());
    }
}
