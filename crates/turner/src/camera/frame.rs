//! Position and orientation of a camera.

use crate::math::DVec3;
use crate::schema::{ErrorCode, SceneError, choice};

choice! {
    /// Handedness of the camera's axes.
    pub enum Handedness {
        /// right = forward × up: if the camera looks along −z with y up, x is to the right.
        Right = "right",
        /// right = up × forward: if the camera looks along +z with y up, x is to the right.
        Left = "left",
    }
}

/// Position and unit axes of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFrame {
    /// Position of the camera.
    pub position: DVec3,
    /// To the right in the picture.
    pub right: DVec3,
    /// Upwards in the picture.
    pub up: DVec3,
    /// Into the picture: the viewing direction.
    pub forward: DVec3,
}

impl CameraFrame {
    /// A camera at `position` that looks at `target`, with `up` upwards in the picture. An error if they do not
    /// define an orientation.
    pub fn new(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        handedness: Handedness,
    ) -> Result<CameraFrame, SceneError> {
        let error = |what: &str, help: &str| {
            Err(SceneError::new(ErrorCode::Camera, what.to_owned()).help(help.to_owned()))
        };
        let Some(forward) = (target - position).try_normalize() else {
            return error("the camera's `position` and `look_at` are the same point", "move one of them");
        };
        let Some(up) = up.try_normalize() else {
            return error("the camera's `up` is zero", "write up = [0, 1, 0]");
        };
        let right = match handedness {
            Handedness::Right => forward.cross(up),
            Handedness::Left => up.cross(forward),
        };
        if right.length().is_nan() || right.length() <= 1e-9 {
            return error(
                "the camera's `up` is parallel to its viewing direction",
                "choose another `up`, e.g. [0, 0, 1] when looking straight down",
            );
        }
        let right = right.normalize();
        let up = match handedness {
            Handedness::Right => right.cross(forward),
            Handedness::Left => forward.cross(right),
        };
        Ok(CameraFrame { position, right, up, forward })
    }
}
