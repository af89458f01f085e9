//! The thin-lens camera: a pinhole camera with depth of field.

use super::aperture::Aperture;
use super::pinhole::{Screen, screen};
use super::{CameraFrame, Handedness, Viewport};
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, params};

params! {
    /// A camera with a lens: what is not at the distance of focus is blurred. Needs several samples per pixel.
    pub struct ThinLensDesc as "thin-lens" {
        /// The middle of the lens.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point in the middle of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Upwards in the picture.
        up: DVec3 = DVec3::Y;
        /// Which hand the axes follow.
        handedness: Handedness = Handedness::Right;
        /// Vertical field of view, degrees; 40 if neither it nor a viewport is given.
        fov: Option<f64> = None, in Range::open(0.0, 180.0);
        /// Instead of `fov`: size of the screen, as for the pinhole camera.
        viewport: Option<Viewport> = None;
        /// Distance of the viewport from the eye; without it the viewport lies at `look_at`.
        distance: Option<f64> = None, in Range::POSITIVE;
        /// Moves the screen sideways, as for the pinhole camera.
        shift: DVec2 = DVec2::ZERO;
        /// Radius of the lens, scene units; 0 is a pinhole.
        lens_radius: f64 = 0.05, in Range::NON_NEGATIVE;
        /// Blades of the aperture: what is out of focus shows its polygon, of so many corners on the circle of `lens_radius`. 0 is a round opening; else 3 or more.
        blades: u32 = 0, in Range::closed(0.0, 1024.0);
        /// Degrees by which the blades are turned, against the clock as the camera sees it; at 0 a corner is straight up.
        blade_rotation: f64 = 0.0;
        /// Distance of the plane in focus, along the direction of view; without it `look_at` is in focus.
        focus_distance: Option<f64> = None, in Range::POSITIVE;
        /// Nothing nearer than this counts, measured along the direction of view.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
    }
    example r#"[camera]
type = "thin-lens"
position = [0, 2, 6]
look_at = [0, 1, 0]
fov = 35
lens_radius = 0.1
blades = 6

[film]
antialias = "monte-carlo"
samples = 64
"#
}

/// A thin-lens camera, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    pub(super) frame: CameraFrame,
    pub(super) screen: Screen,
    lens_radius: f64,
    aperture: Aperture,
    pub(super) focus_distance: f64,
    pub(super) near: f64,
}

impl ThinLensDesc {
    /// Makes it ready for a picture of the given aspect.
    pub fn prepare(&self, aspect: f64) -> Result<ThinLens, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        let to_target = (self.look_at - self.position).length();
        let screen = screen(self.fov, self.viewport, self.distance, self.shift, to_target, aspect)?;
        let focus_distance = self.focus_distance.unwrap_or(to_target);
        let aperture = Aperture::new(self.blades, self.blade_rotation)?;
        Ok(ThinLens {
            frame,
            screen,
            lens_radius: self.lens_radius,
            aperture,
            focus_distance,
            near: self.near,
        })
    }
}

impl ThinLens {
    /// Half the size of what is seen of the plane in focus, which directions lead to.
    pub(super) fn half_focus(&self) -> DVec2 {
        self.screen.half * (self.focus_distance / self.screen.distance)
    }

    /// From the middle of the lens to its point at `lens` in the unit square.
    pub(super) fn offset(&self, lens: DVec2) -> DVec3 {
        let l = self.aperture.point(lens) * self.lens_radius;
        self.frame.right * l.x + self.frame.up * l.y
    }

    /// The ray through a point of the screen and a point `lens` of the unit square, mapped onto the lens.
    pub(super) fn ray(&self, at: DVec2, lens: DVec2) -> Ray {
        let f = &self.frame;
        let d = self.screen.direction(f, at);
        let on_focus = d * (self.focus_distance / self.screen.distance);
        let offset = self.offset(lens);
        let d = on_focus - offset;
        Ray { t_min: self.near / self.focus_distance, ..Ray::new(f.position + offset, d) }
    }
}
