//! Several pictures of one scene: turntables and animation frames.

use std::path::{Path, PathBuf};

use clap::Args;
use turner::description::default_studio::Orbit;
use turner::integrator::{Integrator, Prepared};
use turner::math::Bounds;
use turner::schema::SceneError;

/// Which pictures to render, if not one.
#[derive(Debug, Default, Args)]
pub(crate) struct SequenceArgs {
    /// Render N numbered pictures from a camera that circles the scene once
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    turntable: Option<u32>,
    /// Render the animation frames FIRST to LAST as numbered pictures
    #[arg(long, value_name = "FIRST-LAST", value_parser = parse_frames, conflicts_with_all = ["turntable", "time", "frame"])]
    frames: Option<(u32, u32)>,
}

/// One picture of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// The only one.
    Only,
    /// Number and angle on a turntable, degrees.
    Turn(u32, f64),
    /// An animation frame.
    Frame(u32),
}

fn parse_frames(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once('-').map(|(a, b)| (a.trim().parse(), b.trim().parse()));
    match numbers {
        Some((Ok(first), Ok(last))) if first <= last && last - first < 100_000 => Ok((first, last)),
        _ => Err("expected the first and the last frame; write `--frames 0-47`".to_owned()),
    }
}

impl SequenceArgs {
    /// All of them in order.
    pub(crate) fn steps(&self) -> Vec<Step> {
        match (self.turntable, self.frames) {
            (Some(n), _) => (0..n).map(|i| Step::Turn(i, 360.0 * f64::from(i) / f64::from(n))).collect(),
            (None, Some((first, last))) => (first..=last).map(Step::Frame).collect(),
            (None, None) => vec![Step::Only],
        }
    }
}

impl Step {
    /// The file name of this picture: the number replaces the `#`s in the name, or precedes the extension.
    pub(crate) fn path(&self, path: &Path) -> PathBuf {
        let number = match self {
            Step::Only => return path.to_owned(),
            Step::Turn(n, _) | Step::Frame(n) => n,
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let numbered = match name.find('#') {
            Some(start) => {
                let width = name[start..].bytes().take_while(|b| *b == b'#').count();
                format!("{}{number:0width$}{}", &name[..start], &name[start + width..])
            }
            None => match name.rsplit_once('.') {
                Some((stem, extension)) => format!("{stem}_{number:04}.{extension}"),
                None => format!("{name}_{number:04}"),
            },
        };
        path.with_file_name(numbered)
    }

    /// Moves the camera to the position of this picture and prepares the integrator for the new view.
    pub(crate) fn turn(
        &self,
        prepared: &mut Prepared,
        integrator: &dyn Integrator,
        orbit: Option<Orbit>,
        fov: f64,
    ) -> Result<(), SceneError> {
        let Step::Turn(_, degrees) = self else { return Ok(()) };
        let orbit = orbit.unwrap_or(Orbit::DEFAULT);
        let aspect = prepared.view.film.aspect();
        let bounds = prepared.scene.stats.bounds.unwrap_or(Bounds::EMPTY);
        // The same distance from all sides, at which the bounding sphere fits.
        let distance = orbit.distance.unwrap_or_else(|| {
            let half = turner::math::radians(0.5 * fov);
            1.02 / turner::math::elementary::sin(half)
        });
        let orbit = Orbit { azimuth: orbit.azimuth + degrees, distance: Some(distance), ..orbit };
        *prepared = prepared.with_camera(orbit.camera(&bounds, fov, aspect), integrator)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_numbered() {
        let name = |step: Step, path: &str| step.path(Path::new(path)).to_string_lossy().into_owned();
        assert_eq!(name(Step::Only, "a/b.png"), "a/b.png");
        assert_eq!(name(Step::Frame(7), "a/b.png"), "a/b_0007.png");
        assert_eq!(name(Step::Frame(123), "b-##.x.exr"), "b-123.x.exr");
        assert_eq!(name(Step::Turn(3, 0.0), "###b"), "003b");
    }

    #[test]
    fn ranges_of_frames() {
        assert_eq!(parse_frames("3-12"), Ok((3, 12)));
        for bad in ["", "3", "4-3", "a-b", "0-100000", "-1-2"] {
            assert!(parse_frames(bad).is_err(), "{bad}");
        }
    }
}
