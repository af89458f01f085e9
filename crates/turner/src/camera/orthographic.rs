//! The orthographic camera: parallel rays.

use super::{CameraFrame, Handedness, Viewport};
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, params};

params! {
    /// An orthographic camera: all rays are parallel, and distance does not shrink.
    pub struct OrthographicDesc as "orthographic" {
        /// The middle of the screen, where rays begin.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// A point in the middle of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Upwards in the picture.
        up: DVec3 = DVec3::Y;
        /// Which hand the axes follow.
        handedness: Handedness = Handedness::Right;
        /// Width and height of the screen in scene units, or its height alone, with square pixels.
        viewport: Viewport = Viewport::Height(4.0);
        /// Nothing nearer than this to the screen counts.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
    }
    example r#"[camera]
type = "orthographic"
position = [5, 5, 5]
viewport = 4
"#
}

/// An orthographic camera, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthographic {
    pub(super) frame: CameraFrame,
    pub(super) half: DVec2,
    pub(super) near: f64,
}

impl OrthographicDesc {
    /// Makes it ready for a picture of the given aspect.
    pub fn prepare(&self, aspect: f64) -> Result<Orthographic, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        Ok(Orthographic { frame, half: 0.5 * self.viewport.size(aspect), near: self.near })
    }
}

impl Orthographic {
    /// Half the size of the screen.
    pub(super) fn half_screen(&self) -> DVec2 {
        self.half
    }

    /// The ray from a point of the screen.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let origin = f.position + f.right * (at.x * self.half.x) + f.up * (at.y * self.half.y);
        let mut ray = Ray::new(origin, f.forward);
        ray.t_min = self.near;
        ray
    }
}
