//! Cameras, in world space.

use turner::camera::{CameraDesc, Handedness, OrthographicDesc, PinholeDesc, Viewport};
use turner::math::{DAffine3, DVec3};
use turner::schema::Named;

use super::fault::{Fault, Outcome};
use super::json::{Document, Index};
use super::report::Report;

/// The camera with this index on a node with this transform; `None` if it is degenerate.
pub(super) fn camera(
    document: &Document,
    index: Index,
    world: &DAffine3,
    node_name: Option<&str>,
    report: &mut Report,
    pointer: &str,
) -> Outcome<Option<Named<CameraDesc>>> {
    let Some(json) = document.cameras.get(index.index()) else {
        return Err(Fault::dangling(pointer, "camera", index.0, document.cameras.len()));
    };
    let position = world.translation;
    // A glTF camera looks along −z; +y is up.
    let axis = |v: DVec3| (world.matrix3 * v).try_normalize();
    let (Some(forward), Some(up), true) = (axis(DVec3::NEG_Z), axis(DVec3::Y), position.is_finite()) else {
        report.doubtful("a camera whose node has no direction");
        return Ok(None);
    };
    if forward.cross(up).length() < 1e-6 {
        report.doubtful("a camera whose node has no direction");
        return Ok(None);
    }
    // Far enough away that rounding does not change the direction.
    let look_at = position + forward * (1.0 + position.abs().max_element());
    let mirrored = world.matrix3.determinant() < 0.0;
    let handedness = if mirrored { Handedness::Left } else { Handedness::Right };
    let value = match (&json.perspective, &json.orthographic) {
        (Some(p), _) => {
            let fov = p.yfov.to_degrees();
            if !(fov > 0.0 && fov < 180.0) {
                report.doubtful("a camera whose field of view is not between 0 and 180 degrees");
                return Ok(None);
            }
            CameraDesc::Pinhole(PinholeDesc {
                motion: None,
                position,
                look_at,
                up,
                handedness,
                fov: Some(fov),
                near: p.znear.max(0.0),
                far: beyond(p.znear, p.zfar),
                ..PinholeDesc::default()
            })
        }
        (None, Some(o)) => {
            // A negative magnification mirrors the picture; 0 is degenerate.
            let height = 2.0 * o.ymag.abs();
            if !(height > 0.0 && o.xmag != 0.0) {
                report.doubtful("an orthographic camera of size 0");
                return Ok(None);
            }
            CameraDesc::Orthographic(OrthographicDesc {
                motion: None,
                position,
                look_at,
                up,
                handedness,
                viewport: Viewport::Height(height),
                near: o.znear.max(0.0),
                far: beyond(o.znear, o.zfar),
            })
        }
        (None, None) => {
            report.doubtful("a camera that is neither perspective nor orthographic");
            return Ok(None);
        }
    };
    let name = node_name.or(json.name.as_deref()).map(str::to_owned);
    Ok(Some(Named { name, span: None, value }))
}

/// The far distance, where it is valid.
fn beyond(near: f64, far: Option<f64>) -> Option<f64> {
    far.filter(|far| far.is_finite() && *far > near.max(0.0))
}
