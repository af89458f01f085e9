//! The pinhole camera, by field of view or by the documents' viewport.

use turner_bvh::lanes::{F64x8, Simd, Vec3x8};

use super::{CameraFrame, Handedness};
use crate::math::elementary::tan;
use crate::math::{DVec2, DVec3, Ray, radians};
use crate::schema::value::{Data, Value};
use crate::schema::{ErrorCode, ParamType, Range, ReadContext, SceneError, WriteContext, params, wrong_type};

params! {
    /// A pinhole camera. What it sees is given by `fov`, or by the size of a `viewport` at a `distance` from the eye, as in the classic documents.
    pub struct PinholeDesc as "pinhole" {
        /// The eye.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point in the middle of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Upwards in the picture.
        up: DVec3 = DVec3::Y;
        /// Which hand the axes follow: with "left", a camera that looks along +z has x to its right.
        handedness: Handedness = Handedness::Right;
        /// Vertical field of view, degrees; 40 if neither it nor a viewport is given.
        fov: Option<f64> = None, in Range::open(0.0, 180.0);
        /// Instead of `fov`: width and height of the screen, `[width, height]`, stretched over the picture whatever its shape, or the height alone, with square pixels.
        viewport: Option<Viewport> = None;
        /// Distance of the viewport from the eye; without it the viewport lies at `look_at`.
        distance: Option<f64> = None, in Range::POSITIVE;
        /// Moves the screen sideways, [right, up], as shares of the picture's width and height, without turning the camera: with [0, 0.5] the point looked at lies at the lower edge. Upright lines stay
        /// parallel, as with the shift of a view camera.
        shift: DVec2 = DVec2::ZERO;
        /// Nothing nearer than this counts, measured along the direction of view.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
    }
    example r#"[camera]
position = [0, 2, 6]
look_at = [0, 1, 0]
fov = 35
"#
}

/// The size of the screen in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewport {
    /// Its height; its width follows the picture's shape.
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
    /// Width and height for a picture of the given aspect (width over height).
    pub fn size(self, aspect: f64) -> DVec2 {
        match self {
            Viewport::Height(h) => DVec2::new(h * aspect, h),
            Viewport::Size(s) => s,
        }
    }
}

/// The screen of a perspective camera: `half` its half size, `distance` from the eye, its middle `shift` half sizes to the right and above the direction of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Screen {
    pub(super) half: DVec2,
    pub(super) distance: f64,
    pub(super) shift: DVec2,
}

/// Most that a screen may be shifted, in pictures.
pub const MAX_SHIFT: f64 = 1000.0;

impl Screen {
    /// From the eye to a point of the screen, (−1, −1) its lower left, (1, 1) its upper right corner.
    #[inline]
    pub(super) fn direction(&self, f: &CameraFrame, at: DVec2) -> DVec3 {
        let at = at + self.shift;
        f.forward * self.distance + f.right * (at.x * self.half.x) + f.up * (at.y * self.half.y)
    }
}

/// The screen from the two ways to give it.
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
            "`fov` and `viewport` are two ways to say the same: give one of them",
        )),
        (None, Some(viewport)) => {
            Ok(Screen { half: 0.5 * viewport.size(aspect), distance: distance.unwrap_or(to_target), shift })
        }
        (fov, None) => {
            let distance = distance.unwrap_or(1.0);
            let half = tan(radians(fov.unwrap_or(40.0)) / 2.0) * distance;
            Ok(Screen { half: DVec2::new(half * aspect, half), distance, shift })
        }
    }
}

/// A pinhole camera, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    pub(super) frame: CameraFrame,
    pub(super) screen: Screen,
    pub(super) near: f64,
}

impl PinholeDesc {
    /// Makes it ready for a picture of the given aspect.
    pub fn prepare(&self, aspect: f64) -> Result<Pinhole, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        let to_target = (self.look_at - self.position).length();
        let screen = screen(self.fov, self.viewport, self.distance, self.shift, to_target, aspect)?;
        Ok(Pinhole { frame, screen, near: self.near })
    }
}

impl Pinhole {
    /// Half the size of the screen, which directions lead to.
    pub(super) fn half_screen(&self) -> DVec2 {
        self.screen.half
    }

    /// The eye.
    #[inline]
    pub(super) fn position(&self) -> DVec3 {
        self.frame.position
    }

    /// As [`Pinhole::ray`], eight at a time: the directions, and what `t_min` is for all of them.
    #[inline(always)]
    pub(super) fn directions<S: Simd>(&self, simd: S, x: F64x8<S>, y: F64x8<S>) -> (Vec3x8<S>, f64) {
        let f = &self.frame;
        let vector = |v: DVec3| Vec3x8::splat(simd, v.to_array());
        let splat = |v: f64| F64x8::splat(simd, v);
        let d = vector(f.forward * self.screen.distance)
            + vector(f.right) * ((x + splat(self.screen.shift.x)) * splat(self.screen.half.x))
            + vector(f.up) * ((y + splat(self.screen.shift.y)) * splat(self.screen.half.y));
        (d, self.near / self.screen.distance)
    }

    /// The ray through a point of the screen, (−1, −1) its lower left, (1, 1) its upper right corner. The
    /// direction leads from the eye to the screen.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let d = self.screen.direction(f, at);
        Ray { t_min: self.near / self.screen.distance, ..Ray::new(f.position, d) }
    }
}
