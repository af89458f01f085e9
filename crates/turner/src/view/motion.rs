//! Cameras that move while the shutter is open.

use crate::animation::motion::Displacement;
use crate::camera::{CameraDesc, CameraFrame};
use crate::math::{DAffine3, DMat3, DVec3};
use crate::scene::RayBatch;
use crate::schema::SceneError;

/// The motion of a camera from its placement at time 0 of the shutter to that at time 1.
#[derive(Clone, Debug)]
pub(crate) struct CameraMotion {
    displacement: Displacement,
}

impl CameraMotion {
    /// `None` if the camera does not move.
    ///
    /// Errors: a motion that is not invertible, or that mirrors.
    pub(crate) fn new(camera: &CameraDesc, frame: &CameraFrame) -> Result<Option<CameraMotion>, SceneError> {
        let Some(moved) = camera.motion().filter(|motion| !motion.is_identity()) else { return Ok(None) };
        let CameraFrame { position, right, up, forward } = *frame;
        let start = DAffine3 { matrix3: DMat3::from_cols(right, up, -forward), translation: position };
        Ok(Some(CameraMotion { displacement: Displacement::new(&start, &moved.0)? }))
    }

    /// Whether a shutter opens and closes at once.
    pub(crate) fn is_instant(&self, [open, close]: [f64; 2]) -> bool {
        open == close
    }

    /// From the placement at time 0 to that at another time, in world space.
    pub(crate) fn at(&self, time: f64) -> DAffine3 {
        self.displacement.at(time)
    }

    /// The camera as it is at a time.
    pub(crate) fn placed(&self, camera: &CameraDesc, time: f64) -> CameraDesc {
        let moved = self.at(time);
        let mut placed = camera.clone();
        let [position, look_at, up] = placed.placement_mut();
        *position = moved.transform_point3(*position);
        *look_at = moved.transform_point3(*look_at);
        *up = moved.transform_vector3(*up);
        placed
    }

    /// A point as the camera at time 0 would see what the camera at `time` sees of `p`.
    pub(crate) fn still(&self, time: f64, p: DVec3) -> DVec3 {
        self.at(time).inverse().transform_point3(p)
    }

    /// Moves a camera ray of unit direction to where the camera is at the ray's time.
    pub(super) fn move_ray(&self, rays: &mut RayBatch, i: usize) {
        let Some(ray) = rays.get(i) else { return };
        let moved = self.at(f64::from(ray.time));
        let direction = moved.transform_vector3(ray.direction).normalize();
        rays.place(i, moved.transform_point3(ray.origin), direction);
    }
}
