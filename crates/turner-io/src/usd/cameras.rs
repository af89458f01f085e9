//! Cameras (UsdGeomCamera). Focal length and apertures are in tenths of the stage's unit, so that millimetres and
//! centimetres fit.

use turner::camera::{CameraDesc, Handedness, OrthographicDesc, PinholeDesc, ThinLensDesc, Viewport};
use turner::math::elementary::atan2;
use turner::math::{DVec2, DVec3};
use turner::schema::{Named, WarningKind};

use super::scene::{Scene, State};
use super::stage::Prim;
use super::value::Value;
use crate::scene_import::report::Fault;

/// Adds a camera.
pub(super) fn add(scene: &mut Scene<'_>, prim: &Prim, state: &State) -> Result<(), Fault> {
    if scene.depth > 0 {
        scene.ignored("cameras in instances");
        return Ok(());
    }
    let stage = scene.stage;
    let number = |name: &str, otherwise: f64| -> Result<f64, Fault> {
        let v = stage.value(prim, name)?.as_ref().and_then(Value::real);
        Ok(v.filter(|v| v.is_finite()).unwrap_or(otherwise))
    };
    let focal = number("focalLength", 50.0)?;
    let aperture = DVec2::new(number("horizontalAperture", 20.955)?, number("verticalAperture", 15.2908)?);
    let offset = DVec2::new(number("horizontalApertureOffset", 0.0)?, number("verticalApertureOffset", 0.0)?);
    let (f_stop, focus) = (number("fStop", 0.0)?, number("focusDistance", 0.0)?);
    let projection = stage.value(prim, "projection")?;
    let is_parallel = projection.as_ref().and_then(Value::text) == Some("orthographic");
    let range = match stage.value(prim, "clippingRange")? {
        Some(Value::Vector(range)) => range,
        _ => Vec::new(),
    };
    let distance = |i: usize| range.get(i).copied().filter(|v| v.is_finite());
    let world = state.transform;
    let scale = scene.unit;
    let axis = |v: DVec3| (world.matrix3 * v).try_normalize();
    let (Some(forward), Some(up), true) = (axis(DVec3::NEG_Z), axis(DVec3::Y), world.is_finite()) else {
        scene.warn(WarningKind::Doubtful, format!("{}: a camera without a direction", prim.path));
        return Ok(());
    };
    if forward.cross(up).length() < 1e-6 || !(aperture.y > 0.0 && (focal > 0.0 || is_parallel)) {
        scene.warn(WarningKind::Doubtful, format!("{}: a camera without an angle of view", prim.path));
        return Ok(());
    }
    let position = world.translation;
    // Far enough away that rounding does not change the direction.
    let look_at = position + forward * (1.0 + position.abs().max_element());
    let mirrored = world.matrix3.determinant() < 0.0;
    let handedness = if mirrored { Handedness::Left } else { Handedness::Right };
    let near = (distance(0).unwrap_or(0.0) * scale).max(0.0);
    let far = distance(1).map(|far| far * scale).filter(|far| *far > near);
    let shift = DVec2::new(offset.x / aperture.x.max(f64::MIN_POSITIVE), offset.y / aperture.y);
    let shift = if shift.is_finite() { shift } else { DVec2::ZERO };
    // The height of the picture is that of the aperture.
    let half: f64 = atan2(0.5 * aperture.y, focal);
    let fov = Some((2.0 * half).to_degrees());
    let value = if is_parallel {
        if shift != DVec2::ZERO {
            scene.ignored("the aperture offset of orthographic cameras");
        }
        let viewport = Viewport::Height(0.1 * aperture.y * scale);
        let desc = OrthographicDesc { motion: None, position, look_at, up, handedness, viewport, near, far };
        CameraDesc::Orthographic(desc)
    } else if f_stop > 0.0 && focus > 0.0 {
        CameraDesc::ThinLens(ThinLensDesc {
            position,
            look_at,
            up,
            handedness,
            fov,
            shift,
            lens_radius: 0.5 * (0.1 * focal * scale) / f_stop,
            focus_distance: Some(focus * scale),
            near,
            far,
            ..ThinLensDesc::default()
        })
    } else {
        CameraDesc::Pinhole(PinholeDesc {
            position,
            look_at,
            up,
            handedness,
            fov,
            shift,
            near,
            far,
            ..PinholeDesc::default()
        })
    };
    let name = Some(super::paths::name(&prim.path).to_owned());
    scene.cameras.push(Named { name, span: None, value });
    Ok(())
}
