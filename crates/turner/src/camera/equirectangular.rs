//! The equirectangular panorama: all directions in one picture (latitude-longitude map).

use std::f64::consts::{FRAC_PI_2, PI};

use super::{CameraFrame, Handedness};
use crate::math::elementary::sin_cos;
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, Transform, params};

params! {
    /// A panorama of all directions around a point. Columns are longitudes and rows latitudes, evenly spaced. The
    /// centre of the picture is the viewing direction, the left and right edges are behind the camera, the upper edge
    /// is straight up. Use a picture twice as wide as high; other aspect ratios are stretched. With the camera
    /// looking along −z and y up, the picture can be used unchanged as the environment map of another scene.
    pub struct EquirectangularDesc as "equirectangular" {
        /// Position of the camera.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point at the centre of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Up direction in the picture. The poles are along its component perpendicular to the viewing direction.
        up: DVec3 = DVec3::Y;
        /// Handedness of the axes.
        handedness: Handedness = Handedness::Right;
        /// Surfaces nearer to the camera than this, in scene units, are invisible.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Motion blur: what moves the camera, in the space of the scene, from where it is at time 0 of the shutter to
        /// where it is at time 1.
        motion: Option<Transform> = None;
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

/// A prepared equirectangular camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equirectangular {
    pub(super) frame: CameraFrame,
    pub(super) near: f64,
}

impl EquirectangularDesc {
    /// Prepares it.
    pub fn prepare(&self) -> Result<Equirectangular, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        Ok(Equirectangular { frame, near: self.near })
    }
}

impl Equirectangular {
    /// The ray through a screen position, of unit direction. Positions above or below the screen continue across the
    /// pole.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let (sin_lon, cos_lon) = sin_cos(PI * at.x);
        let (sin_lat, cos_lat) = sin_cos(FRAC_PI_2 * at.y);
        let d = (f.forward * cos_lon + f.right * sin_lon) * cos_lat + f.up * sin_lat;
        Ray { t_min: self.near, ..Ray::new(f.position, d) }
    }
}
