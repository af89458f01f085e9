//! The camera as JSON, for programs: the metadata `turner:camera`, the event `done`, `turner info --json`.
//! docs/reference/header.md documents the keys.

use serde_json::{Value, json};
use turner::camera::{CameraModel, ProjectionKind};
use turner::view::View;

/// Signs of right, up and forward for x right, y down, z forward.
const OPENCV: [f64; 3] = [1.0, -1.0, 1.0];

/// The same for x right, y up, z backward.
const OPENGL: [f64; 3] = [1.0, 1.0, -1.0];

/// The camera of a view. Pixels are those of the written picture: of the crop, if there is one.
pub fn json(view: &View) -> Value {
    let film = &view.film;
    let model = view.camera.model(film.width, film.height);
    let [x, y, width, height] = film.crop.unwrap_or([0, 0, film.width, film.height]);
    let center = [model.center.x - f64::from(x), model.center.y - f64::from(y)];
    let convention = |signs| {
        json!({
            "world_to_camera": model.world_to_camera(signs),
            "camera_to_world": model.camera_to_world(signs),
        })
    };
    let mut out = json!({
        "type": view.camera_desc.type_name(),
        "model": word(model.kind),
        "width": width,
        "height": height,
        "full_width": film.width,
        "full_height": film.height,
        "crop": film.crop,
        "opencv": convention(OPENCV),
        "opengl": convention(OPENGL),
        "mirrored": model.is_mirrored(),
        "near": model.near,
        "far": Some(model.far).filter(|far| far.is_finite()),
        "lens": model.lens.map(|(radius, focus)| json!({ "radius": radius, "focus_distance": focus })),
        "shutter": film.shutter,
    });
    parameters(&mut out, &model, center);
    out
}

/// `K` of a perspective camera, the parameters of another.
fn parameters(out: &mut Value, model: &CameraModel, center: [f64; 2]) {
    let scale = model.scale.to_array();
    if model.kind == ProjectionKind::Perspective {
        out["K"] = json!([[scale[0], 0.0, center[0]], [0.0, scale[1], center[1]], [0.0, 0.0, 1.0]]);
        return;
    }
    out["center"] = json!(center);
    let unit = match model.kind {
        ProjectionKind::Perspective | ProjectionKind::Orthographic => "pixels_per_unit",
        ProjectionKind::Fisheye | ProjectionKind::Equirectangular => "pixels_per_radian",
        ProjectionKind::EqualArea => "pixels_per_half_side",
    };
    out[unit] = json!(scale);
    if let Some(rim) = model.rim {
        out["largest_angle"] = json!(rim);
    }
}

fn word(kind: ProjectionKind) -> &'static str {
    match kind {
        ProjectionKind::Perspective => "perspective",
        ProjectionKind::Orthographic => "orthographic",
        ProjectionKind::Fisheye => "fisheye",
        ProjectionKind::Equirectangular => "equirectangular",
        ProjectionKind::EqualArea => "equal-area",
    }
}
