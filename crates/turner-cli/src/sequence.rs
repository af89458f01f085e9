//! Sequences of pictures of a scene: turntables and animation frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use turner::camera::CameraDesc;
use turner::description::default_studio::Orbit;
use turner::description::framing::Subject;
use turner::description::{SceneDesc, StudioDesc};
use turner::integrator::{Integrator, Prepared};
use turner::math::elementary::{cos, sin};
use turner::math::{Bounds, DVec3, radians};
use turner::scene::Scene;
use turner::schema::SceneError;

use crate::scene::{Hashes, Ready};
use crate::studio::StudioArgs;

/// Options for sequences of pictures.
#[derive(Debug, Default, Args)]
pub(crate) struct SequenceArgs {
    /// Render N pictures from a camera that circles the scene once, starting at the scene's camera or at
    /// --camera orbit:A,E: numbered, or an animation (`-o turn.webp`, .gif, .apng, .mp4, .webm)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    turntable: Option<u32>,
    /// Render the animation frames FIRST to LAST: numbered pictures, or an animation (`-o walk.mp4`)
    #[arg(long, value_name = "FIRST-LAST", value_parser = parse_frames, conflicts_with_all = ["turntable", "time", "frame"])]
    frames: Option<(u32, u32)>,
    /// The index of the only picture to render, for a checkpoint of a sequence.
    #[arg(skip)]
    only: Option<u32>,
}

/// One picture of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// The only picture.
    Only,
    /// A picture of a turntable: index and angle in degrees.
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
    /// Restricts the sequence to the picture with this index.
    pub(crate) fn restrict(&mut self, index: u32) {
        self.only = Some(index);
    }

    /// The index in the complete sequence of a picture of [`SequenceArgs::steps`].
    pub(crate) fn index(&self, i: u32) -> u32 {
        self.only.unwrap_or(i)
    }

    /// Whether it is restricted to one picture, whose name has its number already.
    pub(crate) fn is_restricted(&self) -> bool {
        self.only.is_some()
    }

    /// The pictures to render, in order.
    pub(crate) fn steps(&self) -> Vec<Step> {
        let all = self.all();
        match self.only {
            Some(index) => all.get(index as usize).copied().into_iter().collect(),
            None => all,
        }
    }

    /// All pictures in order.
    fn all(&self) -> Vec<Step> {
        match (self.turntable, self.frames) {
            (Some(n), _) => (0..n).map(|i| Step::Turn(i, 360.0 * f64::from(i) / f64::from(n))).collect(),
            (None, Some((first, last))) => (first..=last).map(Step::Frame).collect(),
            (None, None) => vec![Step::Only],
        }
    }
}

impl Step {
    /// The hashes of this picture, given any picture of the sequence.
    pub(crate) fn hashes(&self, scene: &Ready, studio: &StudioArgs) -> Hashes {
        match self {
            Step::Only => scene.hash.clone(),
            Step::Frame(frame) => scene.timeless.clone().at_time(Some(studio.time_of(*frame))),
            Step::Turn(_, degrees) => {
                let mut hashes = scene.hash.clone();
                hashes.add(format!("turntable {degrees:?}").as_bytes());
                hashes
            }
        }
    }

    /// Its number, if it is one of several.
    pub(crate) fn number(&self) -> Option<u32> {
        match self {
            Step::Only => None,
            Step::Turn(n, _) | Step::Frame(n) => Some(*n),
        }
    }

    /// The file name of this picture: the number replaces the `#`s in the name, or precedes the extension.
    pub(crate) fn path(&self, path: &Path) -> PathBuf {
        let Some(number) = self.number() else { return path.to_owned() };
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
        turntable: &Turntable,
    ) -> Result<(), SceneError> {
        let Step::Turn(_, degrees) = self else { return Ok(()) };
        let camera = turntable.camera(*degrees, prepared);
        // As on a turntable in front of fixed lights.
        if let Turntable::Orbit(start) = turntable
            && let Some(scene) = start.scene.with_turned_studio(*degrees)
        {
            prepared.scene = scene.into();
        }
        *prepared = prepared.with_camera(camera, integrator)?;
        Ok(())
    }
}

/// The camera of a turntable at its start.
#[derive(Clone, Debug)]
pub(crate) enum Turntable {
    /// An orbit of the options or of `[studio]`; otherwise the default orbit.
    Orbit(Box<Start>),
    /// The camera of the scene.
    Camera(Box<CameraDesc>),
}

/// The orbit of a turntable at its start.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    orbit: Orbit,
    studio: StudioDesc,
    /// The camera of the scene, whose lens stays.
    own: Option<CameraDesc>,
    /// With the lights of the first picture.
    scene: Arc<Scene>,
    /// What the camera shows in a full turn: it is framed once for all pictures.
    subject: Subject,
}

impl Turntable {
    /// `orbit` is that of `--camera`, which comes first. The next is `camera` of `[studio]`, then the scene's camera.
    pub(crate) fn new(desc: &SceneDesc, prepared: &Prepared, orbit: Option<Orbit>) -> Turntable {
        let studio = desc.studio.as_ref();
        let of_studio = || Orbit::parse(studio?.camera.as_deref()?)?.ok();
        let has_camera = desc.camera.is_some() || studio.is_some() && !desc.cameras.is_empty();
        match orbit.or_else(of_studio) {
            None if has_camera => Turntable::Camera(Box::new(prepared.view.camera_desc.clone())),
            orbit => {
                let scene = prepared.scene.clone();
                let bounds = scene.stats.bounds.unwrap_or(Bounds::EMPTY);
                Turntable::Orbit(Box::new(Start {
                    orbit: orbit.unwrap_or(Orbit::DEFAULT),
                    studio: studio.cloned().unwrap_or_default(),
                    own: desc.camera.as_ref().map(|camera| camera.value.clone()),
                    subject: Subject::new(scene.hull_points(), &bounds).turned(),
                    scene,
                }))
            }
        }
    }

    /// The camera after a rotation by `degrees`.
    fn camera(&self, degrees: f64, prepared: &Prepared) -> CameraDesc {
        let bounds = prepared.scene.stats.bounds.unwrap_or(Bounds::EMPTY);
        match self {
            Turntable::Orbit(start) => {
                let orbit = Orbit { azimuth: start.orbit.azimuth + degrees, ..start.orbit };
                let aspect = prepared.view.film.aspect();
                start.studio.framed(&orbit, &start.subject, start.own.as_ref(), aspect)
            }
            Turntable::Camera(camera) => circled((**camera).clone(), &bounds, degrees),
        }
    }
}

/// Rotates a camera about a vertical axis, counter-clockwise as seen from above. The axis goes through `look_at` if
/// that lies within the bounds, otherwise through their centre: `look_at` of an imported camera is an arbitrary point
/// on its axis.
fn circled(mut camera: CameraDesc, bounds: &Bounds, degrees: f64) -> CameraDesc {
    let [position, look_at, up] = camera.placement_mut();
    let slack = 1e-6 * bounds.size().max_element().max(0.0);
    let contains = (look_at.cmpge(bounds.min - slack) & look_at.cmple(bounds.max + slack)).all();
    let finite = !bounds.is_empty() && bounds.is_finite();
    let center = if contains || !finite { *look_at } else { bounds.center() };
    let (sin, cos) = (sin(radians(degrees)), cos(radians(degrees)));
    let rotated = |v: DVec3| DVec3::new(v.x * cos + v.z * sin, v.y, v.z * cos - v.x * sin);
    *position = center + rotated(*position - center);
    *look_at = center + rotated(*look_at - center);
    *up = rotated(*up);
    camera
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
    fn a_turntable_circles_the_point_looked_at() {
        use turner::camera::PinholeDesc;
        let desc = |position, look_at| {
            CameraDesc::Pinhole(PinholeDesc { position, look_at, ..PinholeDesc::default() })
        };
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let turned = |position, look_at, degrees| {
            let mut camera = circled(desc(position, look_at), &bounds, degrees);
            camera.placement_mut().map(|v| *v)
        };
        let close = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} {b}");
        let [position, look_at, up] = turned(DVec3::new(0.0, 2.0, 5.0), DVec3::new(0.0, 0.5, 0.0), 90.0);
        close(position, DVec3::new(5.0, 2.0, 0.0));
        close(look_at, DVec3::new(0.0, 0.5, 0.0));
        close(up, DVec3::Y);
        // `look_at` between camera and objects: the axis goes through the centre of the bounds.
        let [position, look_at, _] = turned(DVec3::new(0.0, 0.0, 5.0), DVec3::new(0.0, 0.0, 4.0), 180.0);
        close(position, DVec3::new(0.0, 0.0, -5.0));
        close(look_at, DVec3::new(0.0, 0.0, -4.0));
    }

    #[test]
    fn ranges_of_frames() {
        assert_eq!(parse_frames("3-12"), Ok((3, 12)));
        for bad in ["", "3", "4-3", "a-b", "0-100000", "-1-2"] {
            assert!(parse_frames(bad).is_err(), "{bad}");
        }
    }
}
