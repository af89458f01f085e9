//! The distances between which a camera sees surfaces.

use crate::math::Ray;
use crate::schema::{ErrorCode, Remedy, SceneError};

/// The distances between which surfaces are visible, in scene units: along the viewing direction for flat screens, from the
/// camera for panoramas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clip {
    pub(super) near: f64,
    /// Infinite without a limit.
    pub(super) far: f64,
}

impl Clip {
    /// From the parameters of a camera.
    ///
    /// Errors: `far` is not beyond `near`.
    pub(super) fn new(near: f64, far: Option<f64>) -> Result<Clip, SceneError> {
        let far = far.unwrap_or(f64::INFINITY);
        if far.is_nan() || far <= near {
            let message = format!("`far`, {far}, is not beyond `near`, {near}: the camera would see nothing");
            return Err(SceneError::new(ErrorCode::Conflict, message)
                .help("without `far` there is no limit")
                .remedy(Remedy::set("camera.near", 0.0)));
        }
        Ok(Clip { near, far })
    }

    /// The part of a ray between the distances, of which one is `unit` at t = 1.
    #[inline]
    pub(super) fn of_ray(&self, ray: Ray, unit: f64) -> Ray {
        Ray { t_min: self.near / unit, t_max: self.far / unit, ..ray }
    }

    /// The fraction beyond `near` of the segment from a point at this distance to the camera; `None` if the camera does not
    /// see the point.
    #[inline]
    pub(super) fn free(&self, distance: f64) -> Option<f64> {
        (distance > self.near && distance <= self.far).then(|| 1.0 - self.near / distance)
    }
}
