//! The pinhole camera, given by a field of view or by the viewport of the classic documents.

use turner_bvh::lanes::{F64x8, Simd, Vec3x8};

use super::clip::Clip;
use super::{CameraFrame, Handedness};
use crate::math::elementary::tan;
use crate::math::{DVec2, DVec3, Ray, radians};
use crate::schema::value::{Data, Value};
use crate::schema::{
    ErrorCode, ParamType, Range, ReadContext, SceneError, Transform, WriteContext, params, wrong_type,
};

params! {
    /// A pinhole (perspective) camera. The angle of view is given by `fov`, or by the size of a `viewport` at a
    /// `distance` from the camera, as in the classic documents.
    pub struct PinholeDesc as "pinhole" {
        /// Position of the camera.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point at the centre of the picture (unless `shift` moves it).
        look_at: DVec3 = DVec3::ZERO;
        /// Up direction in the picture.
        up: DVec3 = DVec3::Y;
        /// Handedness of the axes: with "left", a camera that looks along +z has x to its right.
        handedness: Handedness = Handedness::Right;
        /// Vertical field of view in degrees; 40 if neither `fov` nor `viewport` is given.
        fov: Option<f64> = None, in Range::open(0.0, 180.0);
        /// Instead of `fov`: size of the screen in scene units. `[width, height]` is stretched over the picture
        /// whatever its aspect ratio; the height alone gives square pixels.
        viewport: Option<Viewport> = None;
        /// Distance of the viewport from the camera, in scene units. By default the viewport is at `look_at`.
        distance: Option<f64> = None, in Range::POSITIVE;
        /// Shifts the screen without rotating the camera, as the shift of a view camera does: [right, up], as
        /// fractions of the picture's width and height. With [0, 0.5] the look-at point is at the lower edge.
        /// Vertical lines stay parallel.
        shift: DVec2 = DVec2::ZERO;
        /// Surfaces nearer than this, in scene units along the viewing direction, are invisible.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Surfaces farther than this, in scene units along the viewing direction, are invisible. By default there is no limit.
        far: Option<f64> = None, in Range::POSITIVE;
        /// Motion blur: what moves the camera, in the space of the scene, from where it is at time 0 of the shutter to
        /// where it is at time 1.
        motion: Option<Transform> = None;
    }
    example r#"[camera]
position = [0, 2, 6]
look_at = [0, 1, 0]
fov = 35
"#
}

/// Size of the screen in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewport {
    /// Its height; its width follows from the aspect ratio.
    Height(f64),
    /// Width and height.
    Size(DVec2),
}

impl ParamType for Viewport {
    fn kind() -> String {
        "[width, height] | height".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Viewport, SceneError> {
        let read = match value.data {
            Data::Array(_) => Viewport::Size(DVec2::read(value, cx)?),
            Data::Integer(_) | Data::Number(_) => Viewport::Height(f64::read(value, cx)?),
            _ => return Err(wrong_type(value, &Self::kind())),
        };
        let size = read.size(1.0);
        if size.x > 0.0 && size.y > 0.0 {
            return Ok(read);
        }
        Err(SceneError::at(ErrorCode::OutOfRange, value.span, "the viewport's size must be greater than 0"))
    }
    fn show(&self) -> String {
        match self {
            Viewport::Height(h) => h.show(),
            Viewport::Size(s) => s.show(),
        }
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        match self {
            Viewport::Height(h) => h.write(cx),
            Viewport::Size(s) => s.write(cx),
        }
    }
}

impl Viewport {
    /// Width and height for a picture of the given aspect ratio (width over height).
    pub fn size(self, aspect: f64) -> DVec2 {
        match self {
            Viewport::Height(h) => DVec2::new(h * aspect, h),
            Viewport::Size(s) => s,
        }
    }
}

/// The screen of a perspective camera: half its size, its distance from the camera, and the offset of its centre from
/// the viewing direction in half sizes, to the right and up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Screen {
    pub(super) half: DVec2,
    pub(super) distance: f64,
    pub(super) shift: DVec2,
}

/// Largest shift of a screen, in picture sizes.
pub const MAX_SHIFT: f64 = 1000.0;

impl Screen {
    /// From the camera to a screen position, (−1, −1) the lower left and (1, 1) the upper right corner.
    #[inline]
    pub(super) fn direction(&self, f: &CameraFrame, at: DVec2) -> DVec3 {
        let at = at + self.shift;
        f.forward * self.distance + f.right * (at.x * self.half.x) + f.up * (at.y * self.half.y)
    }
}

/// The screen given by a field of view or by a viewport.
pub(super) fn screen(
    fov: Option<f64>,
    viewport: Option<Viewport>,
    distance: Option<f64>,
    shift: DVec2,
    to_target: f64,
    aspect: f64,
) -> Result<Screen, SceneError> {
    if !shift.is_finite() || shift.abs().max_element() > MAX_SHIFT {
        let message =
            format!("`shift` of the camera is {shift}: expected numbers from -{MAX_SHIFT} to {MAX_SHIFT}");
        return Err(SceneError::new(ErrorCode::OutOfRange, message));
    }
    let shift = 2.0 * shift;
    match (fov, viewport) {
        (Some(_), Some(_)) => Err(SceneError::new(
            ErrorCode::Conflict,
            "`fov` and `viewport` exclude each other: give one of them",
        )),
        (None, Some(viewport)) => {
            Ok(Screen { half: 0.5 * viewport.size(aspect), distance: distance.unwrap_or(to_target), shift })
        }
        (fov, None) => {
            let distance = distance.unwrap_or(1.0);
            let half = tan(radians(fov.unwrap_or(super::DEFAULT_FOV)) / 2.0) * distance;
            Ok(Screen { half: DVec2::new(half * aspect, half), distance, shift })
        }
    }
}

/// A prepared pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    pub(super) frame: CameraFrame,
    pub(super) screen: Screen,
    pub(super) clip: Clip,
}

impl PinholeDesc {
    /// Prepares it for a picture of the given aspect ratio (width over height).
    pub fn prepare(&self, aspect: f64) -> Result<Pinhole, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        let to_target = (self.look_at - self.position).length();
        let screen = screen(self.fov, self.viewport, self.distance, self.shift, to_target, aspect)?;
        Ok(Pinhole { frame, screen, clip: Clip::new(self.near, self.far)? })
    }
}

impl Pinhole {
    /// Half the size of the screen.
    pub(super) fn half_screen(&self) -> DVec2 {
        self.screen.half
    }

    /// Position of the camera.
    #[inline]
    pub(super) fn position(&self) -> DVec3 {
        self.frame.position
    }

    /// As [`Pinhole::ray`] for eight screen positions: the directions, and the common `t_min` and `t_max`.
    #[inline(always)]
    pub(super) fn directions<S: Simd>(&self, simd: S, x: F64x8<S>, y: F64x8<S>) -> (Vec3x8<S>, [f64; 2]) {
        let f = &self.frame;
        let vector = |v: DVec3| Vec3x8::splat(simd, v.to_array());
        let splat = |v: f64| F64x8::splat(simd, v);
        let d = vector(f.forward * self.screen.distance)
            + vector(f.right) * ((x + splat(self.screen.shift.x)) * splat(self.screen.half.x))
            + vector(f.up) * ((y + splat(self.screen.shift.y)) * splat(self.screen.half.y));
        (d, [self.clip.near, self.clip.far].map(|v| v / self.screen.distance))
    }

    /// The ray through a screen position, (−1, −1) the lower left and (1, 1) the upper right corner. The direction
    /// leads from the camera to the screen.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let d = self.screen.direction(f, at);
        self.clip.of_ray(Ray::new(f.position, d), self.screen.distance)
    }
}
