//! The orthographic camera: parallel rays.

use super::clip::Clip;
use super::{CameraFrame, Handedness, Viewport};
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, Transform, params};

params! {
    /// An orthographic camera: all rays are parallel, so objects keep their size at any distance.
    pub struct OrthographicDesc as "orthographic" {
        /// Centre of the screen, where rays start.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point at the centre of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Up direction in the picture.
        up: DVec3 = DVec3::Y;
        /// Handedness of the axes.
        handedness: Handedness = Handedness::Right;
        /// Size of the screen in scene units: `[width, height]`, or the height alone for square pixels.
        viewport: Viewport = Viewport::Height(4.0);
        /// Surfaces nearer to the screen than this, in scene units, are invisible.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Surfaces farther from the screen than this, in scene units, are invisible. By default there is no limit.
        far: Option<f64> = None, in Range::POSITIVE;
        /// Motion blur: what moves the camera, in the space of the scene, from where it is at time 0 of the shutter to
        /// where it is at time 1.
        motion: Option<Transform> = None;
    }
    example r#"[camera]
type = "orthographic"
position = [5, 5, 5]
viewport = 4
"#
}

/// A prepared orthographic camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthographic {
    pub(super) frame: CameraFrame,
    pub(super) half: DVec2,
    pub(super) clip: Clip,
}

impl OrthographicDesc {
    /// Prepares it for a picture of the given aspect ratio (width over height).
    pub fn prepare(&self, aspect: f64) -> Result<Orthographic, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        Ok(Orthographic {
            frame,
            half: 0.5 * self.viewport.size(aspect),
            clip: Clip::new(self.near, self.far)?,
        })
    }
}

impl Orthographic {
    /// Half the size of the screen.
    pub(super) fn half_screen(&self) -> DVec2 {
        self.half
    }

    /// The ray from a screen position.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let origin = f.position + f.right * (at.x * self.half.x) + f.up * (at.y * self.half.y);
        self.clip.of_ray(Ray::new(origin, f.forward), 1.0)
    }
}
