//! Moving a camera: functions of its description. Angles are in radians, lengths in scene units.

use turner::camera::{CameraDesc, CameraFrame, Handedness, Viewport};
use turner::math::{Bounds, DVec3, elementary::tan, radians};
use turner::schema::transform::rotation;

/// The camera's axes; `None` if its description defines none.
pub fn axes(camera: &CameraDesc) -> Option<CameraFrame> {
    camera.prepare(1.0).ok().map(|camera| camera.frame())
}

/// Twice the tangent of half the vertical field of view: the height of the picture at distance 1. `None` without
/// perspective.
pub fn height_at_one(camera: &CameraDesc, aspect: f64) -> Option<f64> {
    let of = |fov: Option<f64>, viewport: Option<Viewport>, distance: Option<f64>, to_target: f64| {
        match viewport {
            Some(viewport) => viewport.size(aspect).y / distance.unwrap_or(to_target),
            None => 2.0 * tan(radians(0.5 * fov.unwrap_or(40.0))),
        }
    };
    match camera {
        CameraDesc::Pinhole(c) => Some(of(c.fov, c.viewport, c.distance, c.position.distance(c.look_at))),
        CameraDesc::ThinLens(c) => Some(of(c.fov, c.viewport, c.distance, c.position.distance(c.look_at))),
        CameraDesc::Realistic(c) => c.height_at_one(aspect),
        CameraDesc::Orthographic(_) | CameraDesc::Equirectangular(_) | CameraDesc::Fisheye(_) => None,
    }
}

/// Before a camera moves: what its description derives from the distance to the look-at point becomes explicit, so that
/// the angle of view stays.
fn settle(camera: &mut CameraDesc) {
    let (viewport, distance, reach) = match camera {
        CameraDesc::Pinhole(c) => (c.viewport, &mut c.distance, c.position.distance(c.look_at)),
        CameraDesc::ThinLens(c) => (c.viewport, &mut c.distance, c.position.distance(c.look_at)),
        CameraDesc::Orthographic(_)
        | CameraDesc::Equirectangular(_)
        | CameraDesc::Fisheye(_)
        | CameraDesc::Realistic(_) => return,
    };
    if viewport.is_some() && distance.is_none() {
        *distance = Some(reach);
    }
}

fn handedness(camera: &CameraDesc) -> f64 {
    let side = match camera {
        CameraDesc::Pinhole(c) => c.handedness,
        CameraDesc::Orthographic(c) => c.handedness,
        CameraDesc::ThinLens(c) => c.handedness,
        CameraDesc::Equirectangular(c) => c.handedness,
        CameraDesc::Fisheye(c) => c.handedness,
        CameraDesc::Realistic(c) => c.handedness,
    };
    if side == Handedness::Left { -1.0 } else { 1.0 }
}

/// The least angle between the viewing direction and the up direction.
const POLE: f64 = 0.02;

/// Turns a direction by `yaw` about `up` and by `pitch` towards `up`, which it never reaches.
fn turned(direction: DVec3, up: DVec3, yaw: f64, pitch: f64) -> DVec3 {
    let up = up.normalize_or(DVec3::Y);
    let turned = rotation(up, yaw.to_degrees()) * direction;
    let Some(right) = turned.cross(up).try_normalize() else { return direction };
    let angle = turned.angle_between(up);
    let pitch = pitch.clamp(angle - (std::f64::consts::PI - POLE), angle - POLE);
    rotation(right, pitch.to_degrees()) * turned
}

/// Moves the camera about its look-at point: by `right` to the right and by `up` upwards.
pub fn orbit(camera: &mut CameraDesc, right: f64, up: f64) {
    settle(camera);
    let side = handedness(camera);
    let [position, look_at, axis] = camera.placement_mut();
    let back = *position - *look_at;
    *position = *look_at + turned(back, *axis, side * right, up);
}

/// Turns the camera about its own position: to the right and upwards.
pub fn look(camera: &mut CameraDesc, right: f64, up: f64) {
    settle(camera);
    let side = handedness(camera);
    let [position, look_at, axis] = camera.placement_mut();
    *look_at = *position + turned(*look_at - *position, *axis, -side * right, up);
}

/// Moves the camera and its look-at point along the camera's axes: to the right, up and forwards.
pub fn fly(camera: &mut CameraDesc, by: DVec3) {
    settle(camera);
    let Some(axes) = axes(camera) else { return };
    let by = axes.right * by.x + axes.up * by.y + axes.forward * by.z;
    let [position, look_at, _] = camera.placement_mut();
    *position += by;
    *look_at += by;
}

/// Moves the picture by fractions of its height, so that the look-at point follows the hand.
pub fn pan(camera: &mut CameraDesc, right: f64, up: f64, aspect: f64) {
    let height = match &*camera {
        CameraDesc::Orthographic(c) => c.viewport.size(aspect).y,
        other => height_at_one(other, aspect).unwrap_or(1.0) * distance(other),
    };
    fly(camera, DVec3::new(-right * height, -up * height, 0.0));
}

/// The distance to the look-at point.
pub fn distance(camera: &CameraDesc) -> f64 {
    let mut camera = camera.clone();
    let [position, look_at, _] = camera.placement_mut();
    position.distance(*look_at)
}

/// Brings the look-at point nearer by a factor: 0.5 halves the distance, or the height of an orthographic picture.
pub fn dolly(camera: &mut CameraDesc, factor: f64) {
    settle(camera);
    let factor = factor.clamp(1e-3, 1e3);
    if let CameraDesc::Orthographic(c) = camera {
        c.viewport = match c.viewport {
            Viewport::Height(height) => Viewport::Height(height * factor),
            Viewport::Size(size) => Viewport::Size(size * factor),
        };
        return;
    }
    let [position, look_at, _] = camera.placement_mut();
    let back = (*position - *look_at) * factor;
    if back.length() > 1e-9 && back.length() < 1e9 {
        *position = *look_at + back;
    }
}

/// Moves the camera along its viewing direction until the picture shows all of the bounds.
pub fn frame(camera: &mut CameraDesc, bounds: &Bounds, aspect: f64) {
    settle(camera);
    if bounds.is_empty() || !bounds.is_finite() {
        return;
    }
    let radius = (0.5 * bounds.size().length()).max(1e-6);
    if let CameraDesc::Orthographic(c) = camera {
        c.viewport = Viewport::Height(2.2 * radius / aspect.min(1.0));
    }
    let half = 0.5 * height_at_one(camera, aspect).unwrap_or(2.0) * aspect.min(1.0);
    // The sphere around the bounds touches the edges of the picture: sin of half the angle of view.
    let away = 1.1 * radius * (1.0 + half * half).sqrt() / half;
    let [position, look_at, _] = camera.placement_mut();
    let back = (*position - *look_at).normalize_or(DVec3::Z);
    *look_at = bounds.center();
    *position = *look_at + back * away;
}

/// Makes a point sharp: sets the distance of the plane of focus. A pinhole becomes a thin lens, with a lens small enough
/// to keep what it showed recognizable.
pub fn focus(camera: &mut CameraDesc, point: DVec3) {
    settle(camera);
    let Some(axes) = axes(camera) else { return };
    let depth = (point - axes.position).dot(axes.forward);
    if depth <= 1e-9 {
        return;
    }
    if let CameraDesc::Pinhole(c) = camera {
        *camera = CameraDesc::ThinLens(c.with_lens(depth * 0.01, None));
    }
    match camera {
        CameraDesc::ThinLens(c) => c.focus_distance = Some(depth),
        CameraDesc::Realistic(c) => c.focus_distance = Some(depth),
        CameraDesc::Pinhole(_)
        | CameraDesc::Orthographic(_)
        | CameraDesc::Equirectangular(_)
        | CameraDesc::Fisheye(_) => {}
    }
}

#[cfg(test)]
mod tests;
