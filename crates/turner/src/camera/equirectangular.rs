//! The equirectangular panorama: all directions in one picture.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{CameraFrame, Handedness};
use crate::math::elementary::sin_cos;
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, params};

params! {
    /// All directions around a point in one picture, twice as wide as high: columns are longitudes, rows latitudes, evenly spaced. Its middle lies in the direction of
    /// view, its left and right edges behind, its upper edge is straight up. With look_at along −z and y up the picture is an environment light
    /// for another scene as it stands. A picture of another shape is stretched.
    pub struct EquirectangularDesc as "equirectangular" {
        /// The eye.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// A point in the middle of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Upwards in the picture; the poles lie along it as far as it is at right angles to the direction of view.
        up: DVec3 = DVec3::Y;
        /// Which hand the axes follow.
        handedness: Handedness = Handedness::Right;
        /// Nothing nearer than this to the eye counts.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
    }
    example r#"[camera]
type = "equirectangular"
position = [0, 1, 0]
look_at = [0, 1, -1]

[film]
width = 64
height = 32
"#
}

/// An equirectangular camera, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equirectangular {
    pub(super) frame: CameraFrame,
    pub(super) near: f64,
}

impl EquirectangularDesc {
    /// Makes it ready.
    pub fn prepare(&self) -> Result<Equirectangular, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        Ok(Equirectangular { frame, near: self.near })
    }
}

impl Equirectangular {
    /// The ray through a point of the screen, of unit direction. Beyond the upper and lower edges the picture goes on over the pole.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let (sin_lon, cos_lon) = sin_cos(PI * at.x);
        let (sin_lat, cos_lat) = sin_cos(FRAC_PI_2 * at.y);
        let d = (f.forward * cos_lon + f.right * sin_lon) * cos_lat + f.up * sin_lat;
        Ray { t_min: self.near, ..Ray::new(f.position, d) }
    }
}
