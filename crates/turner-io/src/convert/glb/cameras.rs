//! Cameras and lights, each on its own root node.

use std::f64::consts::FRAC_PI_2;

use serde_json::{Value, json};
use turner::camera::{CameraDesc, Handedness, PinholeDesc, Viewport};
use turner::color::Spectrum;
use turner::description::SceneDesc;
use turner::light::{Attenuation, LightDesc};
use turner::math::elementary::atan2;
use turner::math::{DAffine3, DMat3, DVec2, DVec3, radians};

use super::nodes::{Nodes, Source};
use super::remarks::Remarks;

/// Adds the cameras and lights of a scene; returns the document's lists of them.
pub(super) fn add(desc: &SceneDesc, nodes: &mut Nodes, remarks: &mut Remarks) -> (Vec<Value>, Vec<Value>) {
    let (mut cameras, mut lights) = (Vec::new(), Vec::new());
    let aspect = f64::from(desc.film.width) / f64::from(desc.film.height.max(1));
    for (i, camera) in desc.camera.iter().chain(&desc.cameras).enumerate() {
        let Some((json, transform)) = camera_json(&camera.value, aspect, remarks) else { continue };
        if nodes.root((camera.name.as_deref(), Source::Camera(i)), &transform, "camera", json!(cameras.len()))
        {
            cameras.push(json);
        }
    }
    for (i, light) in desc.lights.iter().enumerate() {
        let Some((json, transform)) = light_json(&light.value, remarks) else { continue };
        let on_node = json!({ "KHR_lights_punctual": { "light": lights.len() } });
        if nodes.root((light.name.as_deref(), Source::Light(i)), &transform, "extensions", on_node) {
            lights.push(json);
        }
    }
    (cameras, lights)
}

/// The placement of a camera's node.
pub(super) fn camera_placement(camera: &CameraDesc) -> Option<DAffine3> {
    camera_json(camera, 1.0, &mut Remarks::default()).map(|(_, placed)| placed)
}

/// The placement of a light's node.
pub(super) fn light_placement(light: &LightDesc) -> Option<DAffine3> {
    light_json(light, &mut Remarks::default()).map(|(_, placed)| placed)
}

/// A transform whose −z axis points forward and +y axis up.
fn looking(position: DVec3, forward: DVec3, up: DVec3, mirrored: bool) -> Option<DAffine3> {
    let z = -forward.try_normalize()?;
    let x = up.cross(z).try_normalize()?;
    let y = z.cross(x);
    let x = if mirrored { -x } else { x };
    Some(DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: position })
}

fn camera_json(camera: &CameraDesc, aspect: f64, remarks: &mut Remarks) -> Option<(Value, DAffine3)> {
    let mut placed = camera.clone();
    let [position, look_at, up] = placed.placement_mut().map(|v| *v);
    let distance = (look_at - position).length();
    let shifted = match camera {
        CameraDesc::Pinhole(c) => c.shift != DVec2::ZERO,
        CameraDesc::ThinLens(c) => c.shift != DVec2::ZERO,
        CameraDesc::Orthographic(_)
        | CameraDesc::Equirectangular(_)
        | CameraDesc::Fisheye(_)
        | CameraDesc::Realistic(_) => false,
    };
    if shifted {
        remarks.approximated("shifted cameras: written without shift");
    }
    let (handedness, json) = match camera {
        CameraDesc::Pinhole(c) => (c.handedness, perspective(c, distance, aspect)),
        CameraDesc::ThinLens(c) => {
            remarks.approximated("thin-lens cameras: written without depth of field");
            let pinhole = PinholeDesc {
                motion: None,
                position,
                look_at,
                up,
                handedness: c.handedness,
                fov: c.fov,
                viewport: c.viewport,
                distance: c.distance,
                shift: c.shift,
                near: c.near,
                far: c.far,
            };
            (c.handedness, perspective(&pinhole, distance, aspect))
        }
        CameraDesc::Orthographic(c) => {
            let size = c.viewport.size(aspect);
            let far = c.far.unwrap_or(c.near + 1000.0 * distance.max(size.y));
            let json = json!({ "type": "orthographic", "orthographic": {
                "xmag": 0.5 * size.x, "ymag": 0.5 * size.y, "znear": c.near, "zfar": far,
            } });
            (c.handedness, json)
        }
        CameraDesc::Realistic(c) => {
            remarks.approximated("cameras with a lens: written as perspective cameras");
            let pinhole = PinholeDesc {
                position,
                look_at,
                up,
                handedness: c.handedness,
                viewport: Some(Viewport::Height(c.height_at_one(aspect)?)),
                distance: Some(1.0),
                ..PinholeDesc::default()
            };
            (c.handedness, perspective(&pinhole, distance, aspect))
        }
        CameraDesc::Equirectangular(_) | CameraDesc::Fisheye(_) => {
            remarks.ignored("panoramic and fisheye cameras");
            return None;
        }
    };
    let mirrored = handedness == Handedness::Left;
    Some((json, looking(position, look_at - position, up, mirrored)?))
}

fn perspective(c: &PinholeDesc, to_target: f64, aspect: f64) -> Value {
    let (fov, aspect) = match (c.fov, c.viewport) {
        (None, Some(viewport)) => {
            let size = viewport.size(aspect);
            let shape = match viewport {
                Viewport::Size(size) => size.x / size.y,
                Viewport::Height(_) => aspect,
            };
            (2.0 * atan2(0.5 * size.y, c.distance.unwrap_or(to_target)), shape)
        }
        (fov, _) => (radians(fov.unwrap_or(40.0)), aspect),
    };
    // glTF requires a near plane above 0.
    let near = if c.near > 0.0 { c.near } else { 1e-4 * to_target.max(1e-30) };
    let mut out = json!({ "yfov": fov, "aspectRatio": aspect, "znear": near });
    if let Some(far) = c.far.filter(|far| *far > near) {
        out["zfar"] = far.into();
    }
    json!({ "type": "perspective", "perspective": out })
}

/// Splits colour times intensity into a colour with components of at most 1 and an intensity.
fn strength(color: Spectrum, intensity: f64) -> (Value, f64) {
    let most = color.max_component().max(1.0);
    let color = color.to_array().map(|v| f64::from(v.max(0.0) / most));
    (json!(color), intensity * f64::from(most))
}

fn light_json(light: &LightDesc, remarks: &mut Remarks) -> Option<(Value, DAffine3)> {
    let check_falloff = |attenuation: &Attenuation, remarks: &mut Remarks| {
        if attenuation.coefficients != [0.0, 0.0, 1.0] {
            remarks
                .approximated("lights without inverse-square falloff: written with inverse-square falloff");
        }
    };
    match light {
        LightDesc::Point(l) => {
            check_falloff(&l.attenuation, remarks);
            if l.ies.is_some() {
                remarks.ignored("IES profiles");
            }
            let (color, intensity) = strength(l.color, l.intensity);
            let json = json!({ "type": "point", "color": color, "intensity": intensity });
            Some((json, DAffine3::from_translation(l.position)))
        }
        LightDesc::Spot(l) => {
            check_falloff(&l.attenuation, remarks);
            if l.ies.is_some() {
                remarks.ignored("IES profiles");
            }
            if l.radius > 0.0 {
                remarks.approximated("spot lights with a radius: shadows become sharp");
            }
            let (color, intensity) = strength(l.color, l.intensity);
            let outer = radians(l.angle).clamp(1e-6, FRAC_PI_2);
            let inner = radians((l.angle - l.penumbra).max(0.0)).min(outer * 0.999_999);
            let json = json!({ "type": "spot", "color": color, "intensity": intensity,
                "spot": { "innerConeAngle": inner, "outerConeAngle": outer } });
            Some((json, facing(l.position, l.look_at - l.position)?))
        }
        LightDesc::Directional(l) => {
            let direction = l.direction.or(l.from.map(|from| -from))?;
            if l.angle > 0.0 {
                remarks.approximated("directional lights with an angular size: shadows become sharp");
            }
            let (color, intensity) = strength(l.color, l.intensity);
            let json = json!({ "type": "directional", "color": color, "intensity": intensity });
            Some((json, facing(DVec3::ZERO, direction)?))
        }
        LightDesc::Ambient(_) => {
            remarks.ignored("ambient lights");
            None
        }
        LightDesc::Environment(_) | LightDesc::Sky(_) => {
            remarks.ignored("environment lights and skies");
            None
        }
        LightDesc::Rectangle(_) | LightDesc::Disk(_) | LightDesc::Sphere(_) => {
            remarks.ignored("invisible area lights; emissive surfaces are written");
            None
        }
    }
}

/// A transform whose −z axis points along `direction`.
fn facing(position: DVec3, direction: DVec3) -> Option<DAffine3> {
    let direction = direction.try_normalize()?;
    looking(position, direction, direction.any_orthonormal_vector(), false)
}
