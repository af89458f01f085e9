//! The fisheye: a circle of up to all directions, angles from the axis kept.

use super::{CameraFrame, Handedness};
use crate::math::elementary::sin_cos;
use crate::math::{DVec2, DVec3, Ray, radians};
use crate::schema::{Range, SceneError, params};

params! {
    /// An equidistant fisheye: the distance from the picture's middle is proportional to the angle from the direction of view. The circle
    /// touches the nearer edges of the picture; beyond it the picture is black, or transparent as the background is.
    pub struct FisheyeDesc as "fisheye" {
        /// The eye.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// A point in the middle of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Upwards in the picture.
        up: DVec3 = DVec3::Y;
        /// Which hand the axes follow.
        handedness: Handedness = Handedness::Right;
        /// Angle from one side of the circle to the other, degrees: 180 shows what is before the camera, 360 everything.
        fov: f64 = 180.0, in Range { min: 0.0, open_min: true, max: 360.0, open_max: false };
        /// Nothing nearer than this to the eye counts.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
    }
    example r#"[camera]
type = "fisheye"
position = [0, 1, 3]
look_at = [0, 1, 0]
fov = 200

[film]
width = 48
height = 48
"#
}

/// A fisheye camera, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fisheye {
    pub(super) frame: CameraFrame,
    /// Half the size of the screen, in radii of the circle.
    pub(super) half: DVec2,
    /// Angle from the axis at the circle, radians.
    pub(super) rim: f64,
    pub(super) near: f64,
}

impl FisheyeDesc {
    /// Makes it ready for a picture of the given aspect.
    pub fn prepare(&self, aspect: f64) -> Result<Fisheye, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        let half = DVec2::new(aspect.max(1.0), aspect.recip().max(1.0));
        Ok(Fisheye { frame, half, rim: radians(0.5 * self.fov), near: self.near })
    }
}

impl Fisheye {
    /// Half the angles of the picture's sides, radians.
    pub(super) fn half_angles(&self) -> DVec2 {
        self.half * self.rim
    }

    /// The ray through a point of the screen, of unit direction; one that ends before it begins beyond the circle.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let at = at * self.half;
        let r = at.length();
        if r > 1.0 {
            return Ray { t_max: -1.0, ..Ray::new(f.position, f.forward) };
        }
        let (sin, cos) = sin_cos(self.rim * r);
        // sin(rim·r)/r: its limit in the middle is the rim's angle.
        let across = if r > 1e-9 { sin / r } else { self.rim };
        let d = f.forward * cos + (f.right * at.x + f.up * at.y) * across;
        Ray { t_min: self.near, ..Ray::new(f.position, d) }
    }
}
