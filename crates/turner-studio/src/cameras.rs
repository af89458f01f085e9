//! What actions and tools do with the camera.

use turner::camera::CameraDesc;
use turner::light::LightDesc;
use turner::math::{Bounds, DVec3};
use turner::schema::Named;
use turner_live::{camera, pick};

use crate::changes::change;
use crate::node::Node;
use crate::studio::Studio;

/// The camera that the picture shows, also one that Turner added.
pub(crate) fn camera_of(studio: &Studio) -> Option<Named<CameraDesc>> {
    let own = studio.document.desc().camera.clone();
    let shown = || studio.frame.as_ref().map(|frame| frame.stand.prepared.view.camera_desc.clone().into());
    own.or_else(shown)
}

/// Changes the camera. Movements that follow one another are one step of the history.
pub(crate) fn move_camera(studio: &mut Studio, label: &str, change: impl FnOnce(&mut CameraDesc)) {
    let Some(mut camera) = camera_of(studio) else { return };
    change(&mut camera.value);
    if camera.value.prepare(1.0).is_err() {
        return;
    }
    studio.moving();
    let _ = studio.document.edit(label, Some("camera"), |desc| {
        desc.camera = Some(camera);
        Ok(())
    });
}

/// A step of the camera by a key: radians, or a fraction of the picture's height or of the distance.
pub(crate) const STEP: f64 = 0.1;

pub(crate) fn pan(studio: &mut Studio, right: f64, up: f64) {
    let aspect = studio.document.desc().film.aspect();
    move_camera(studio, "Pan", |c| camera::pan(c, right, up, aspect));
}

/// Focuses the camera on the middle of the selected object.
pub(crate) fn focus(studio: &mut Studio) {
    let (Some(Node::Object(i)), Some(frame)) = (studio.selection, &studio.frame) else {
        studio.say("Select an object to focus on");
        return;
    };
    let Some(bounds) = pick::object_bounds(&frame.stand, i) else { return };
    move_camera(studio, "Focus", |c| camera::focus(c, bounds.center()));
}

pub(crate) fn frame(studio: &mut Studio, node: Option<Node>) {
    let Some(frame) = &studio.frame else { return };
    let stand = frame.stand.clone();
    let of_node = match node {
        Some(Node::Object(i)) => pick::object_bounds(&stand, i),
        Some(Node::Light(i)) => stand.desc.lights.get(i).and_then(|light| {
            let at = position_of(&light.value)?;
            Some(Bounds { min: at - DVec3::splat(0.5), max: at + DVec3::splat(0.5) })
        }),
        _ => None,
    };
    let Some(bounds) = of_node.or_else(|| pick::scene_bounds(&stand)) else { return };
    let aspect = stand.desc.film.aspect();
    studio.document.end_gesture();
    move_camera(studio, "Frame", |c| camera::frame(c, &bounds, aspect));
    studio.document.end_gesture();
}

/// The position of a light that has one.
pub(crate) fn position_of(light: &LightDesc) -> Option<DVec3> {
    match light {
        LightDesc::Point(l) => Some(l.position),
        LightDesc::Spot(l) => Some(l.position),
        _ => None,
    }
}

pub(crate) fn bookmark(studio: &mut Studio) {
    let Some(camera) = camera_of(studio) else { return };
    change(studio, "Bookmark", |desc| Ok(desc.add_view("view", camera.value)));
    if let Some(Node::View(i)) = studio.selection {
        let name = Node::View(i).label(studio.document.desc());
        studio.say(format!("Camera kept as \"{name}\""));
    }
}
