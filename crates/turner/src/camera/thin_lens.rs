//! The thin-lens camera: a pinhole camera with depth of field.
//!
//! All rays of a screen position pass the same point q of the plane of focus, and start at different points of the
//! lens. Objects at q are sharp; others are spread over the projected lens, the circle of confusion (pbrt § 5.2.3).
//!
//! ```text
//!       lens              plane of focus
//!     l  o--__                  |
//!        |    ``--__            |        c   centre of the lens
//!        |          ``--__      |        l   sampled point of the lens
//!     c  o----------------``----o q      q   where the pinhole ray from c crosses the plane
//!        |                      |
//! ```

use super::aperture::Aperture;
use super::clip::Clip;
use super::pinhole::{Screen, screen};
use super::{CameraFrame, Handedness, PinholeDesc, Viewport};
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, Transform, params};

params! {
    /// A perspective camera with a lens: objects away from the plane of focus are blurred. Needs many samples per
    /// pixel.
    pub struct ThinLensDesc as "thin-lens" {
        /// Centre of the lens.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point at the centre of the picture (unless `shift` moves it).
        look_at: DVec3 = DVec3::ZERO;
        /// Up direction in the picture.
        up: DVec3 = DVec3::Y;
        /// Handedness of the axes.
        handedness: Handedness = Handedness::Right;
        /// Vertical field of view in degrees; 40 if neither `fov` nor `viewport` is given.
        fov: Option<f64> = None, in Range::open(0.0, 180.0);
        /// Instead of `fov`: size of the screen, as for the pinhole camera.
        viewport: Option<Viewport> = None;
        /// Distance of the viewport from the camera, in scene units. By default the viewport is at `look_at`.
        distance: Option<f64> = None, in Range::POSITIVE;
        /// Shifts the screen without rotating the camera, as for the pinhole camera.
        shift: DVec2 = DVec2::ZERO;
        /// Radius of the lens in scene units; 0 is a pinhole.
        lens_radius: f64 = 0.05, in Range::NON_NEGATIVE;
        /// Number of aperture blades. Out-of-focus highlights take the shape of the polygon, whose corners are on the
        /// circle of `lens_radius`. 0 is a round aperture; otherwise at least 3.
        blades: u32 = 0, in Range::closed(0.0, 1024.0);
        /// Rotation of the blades in degrees, counter-clockwise as seen by the camera; at 0 a corner is at the top.
        blade_rotation: f64 = 0.0;
        /// Distance of the plane of focus along the viewing direction, in scene units. By default `look_at` is in
        /// focus.
        focus_distance: Option<f64> = None, in Range::POSITIVE;
        /// Surfaces nearer than this, in scene units along the viewing direction, are invisible.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Surfaces farther than this, in scene units along the viewing direction, are invisible. By default there is no limit.
        far: Option<f64> = None, in Range::POSITIVE;
        /// Motion blur: what moves the camera, in the space of the scene, from where it is at time 0 of the shutter to
        /// where it is at time 1.
        motion: Option<Transform> = None;
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

impl PinholeDesc {
    /// The same view through a lens of a radius. `focus_distance`: see [`ThinLensDesc::focus_distance`].
    pub fn with_lens(&self, lens_radius: f64, focus_distance: Option<f64>) -> ThinLensDesc {
        let PinholeDesc { position, look_at, up, handedness, fov, .. } = *self;
        let PinholeDesc { viewport, distance, shift, near, far, motion, .. } = *self;
        ThinLensDesc {
            position,
            look_at,
            up,
            handedness,
            fov,
            viewport,
            distance,
            shift,
            near,
            far,
            motion,
            lens_radius,
            focus_distance,
            ..ThinLensDesc::default()
        }
    }
}

/// A prepared thin-lens camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    pub(super) frame: CameraFrame,
    pub(super) screen: Screen,
    lens_radius: f64,
    aperture: Aperture,
    pub(super) focus_distance: f64,
    pub(super) clip: Clip,
}

impl ThinLensDesc {
    /// Prepares it for a picture of the given aspect ratio (width over height).
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
            clip: Clip::new(self.near, self.far)?,
        })
    }
}

impl ThinLens {
    /// Radius of the lens.
    pub(super) fn lens_radius(&self) -> f64 {
        self.lens_radius
    }

    /// Half the size of the visible part of the plane of focus.
    pub(super) fn half_focus(&self) -> DVec2 {
        self.screen.half * (self.focus_distance / self.screen.distance)
    }

    /// From the centre of the lens to its point given by `lens` in the unit square.
    pub(super) fn offset(&self, lens: DVec2) -> DVec3 {
        let l = self.aperture.point(lens) * self.lens_radius;
        self.frame.right * l.x + self.frame.up * l.y
    }

    /// The ray through a screen position, from the point of the lens given by `lens` in the unit square.
    pub(super) fn ray(&self, at: DVec2, lens: DVec2) -> Ray {
        let f = &self.frame;
        let d = self.screen.direction(f, at);
        let on_focus = d * (self.focus_distance / self.screen.distance);
        let offset = self.offset(lens);
        let d = on_focus - offset;
        self.clip.of_ray(Ray::new(f.position + offset, d), self.focus_distance)
    }
}
