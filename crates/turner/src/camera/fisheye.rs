//! The fisheye camera: a circular picture in which the radius is proportional to the angle from the axis.

use super::clip::Clip;
use super::{CameraFrame, Handedness};
use crate::math::elementary::sin_cos;
use crate::math::{DVec2, DVec3, Ray, radians};
use crate::schema::{Range, SceneError, Transform, params};

params! {
    /// An equidistant fisheye: the distance from the picture's centre is proportional to the angle from the viewing
    /// direction. The circle touches the nearer edges of the picture; outside the circle the picture is black, or
    /// transparent if the background is.
    pub struct FisheyeDesc as "fisheye" {
        /// Position of the camera.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point at the centre of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Up direction in the picture.
        up: DVec3 = DVec3::Y;
        /// Handedness of the axes.
        handedness: Handedness = Handedness::Right;
        /// Angle of view across the circle, in degrees: 180 shows the hemisphere in front of the camera, 360 all
        /// directions.
        fov: f64 = 180.0, in Range { min: 0.0, open_min: true, max: 360.0, open_max: false };
        /// Surfaces nearer to the camera than this, in scene units, are invisible.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Surfaces farther from the camera than this, in scene units, are invisible. By default there is no limit.
        far: Option<f64> = None, in Range::POSITIVE;
        /// Motion blur: what moves the camera, in the space of the scene, from where it is at time 0 of the shutter to
        /// where it is at time 1.
        motion: Option<Transform> = None;
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

/// A prepared fisheye camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fisheye {
    pub(super) frame: CameraFrame,
    /// Half the size of the screen, in radii of the circle.
    pub(super) half: DVec2,
    /// Angle from the axis at the circle's edge, in radians.
    pub(super) rim: f64,
    pub(super) clip: Clip,
}

impl FisheyeDesc {
    /// Prepares it for a picture of the given aspect ratio (width over height).
    pub fn prepare(&self, aspect: f64) -> Result<Fisheye, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        let half = DVec2::new(aspect.max(1.0), aspect.recip().max(1.0));
        Ok(Fisheye { frame, half, rim: radians(0.5 * self.fov), clip: Clip::new(self.near, self.far)? })
    }
}

impl Fisheye {
    /// Half the angles of view of the picture's width and height, in radians.
    pub(super) fn half_angles(&self) -> DVec2 {
        self.half * self.rim
    }

    /// The ray through a screen position, of unit direction. Outside the circle it is an empty ray (`t_max` < 0).
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let at = at * self.half;
        let r = at.length();
        if r > 1.0 {
            return Ray { t_max: -1.0, ..Ray::new(f.position, f.forward) };
        }
        let (sin, cos) = sin_cos(self.rim * r);
        // sin(rim·r)/r, whose limit at the centre is `rim`.
        let across = if r > 1e-9 { sin / r } else { self.rim };
        let d = f.forward * cos + (f.right * at.x + f.up * at.y) * across;
        self.clip.of_ray(Ray::new(f.position, d), 1.0)
    }
}
