//! Handles at the selected object: drag an axis to move, rotate or scale it.

use egui::{Color32, CursorIcon, Painter, PointerButton, Pos2, Response, Vec2};
use turner::camera::Camera;
use turner::light::LightDesc;
use turner::math::{DAffine3, DVec3};
use turner::schema::transform::rotation;
use turner_live::engine::Stand;

use super::{Placed, Tool, overlay};
use crate::cameras::position_of;
use crate::node::Node;
use crate::studio::Studio;

/// Length of a handle in the window.
const LENGTH: f32 = 70.0;

/// Axes by colour: red, green and blue of the axes, light enough for the colour-blind to tell by their letters.
const AXES: [(DVec3, Color32, &str); 3] = [
    (DVec3::X, Color32::from_rgb(240, 90, 90), "X"),
    (DVec3::Y, Color32::from_rgb(110, 220, 90), "Y"),
    (DVec3::Z, Color32::from_rgb(100, 150, 255), "Z"),
];

/// A drag in progress.
#[derive(Default)]
pub(crate) struct GizmoState {
    drag: Option<Drag>,
}

#[derive(Clone, Copy)]
struct Drag {
    axis: usize,
    /// The transform when it began.
    start: DAffine3,
    center: DVec3,
    from: Pos2,
}

/// The window's direction and length of a world axis of length 1 at `at`.
fn axis_on_screen(stand: &Stand, placed: Placed, at: DVec3, axis: DVec3, unit: f64) -> Option<(Pos2, Vec2)> {
    let from = overlay::seen(&stand.prepared, placed, at)?;
    let to = overlay::seen(&stand.prepared, placed, at + axis * unit)?;
    Some((from, (to - from) / unit as f32))
}

fn position(camera: &Camera) -> DVec3 {
    camera.frame().position
}

/// Shows the handles. Returns whether they take the pointer.
pub(super) fn show(
    ui: &egui::Ui,
    painter: &Painter,
    response: &Response,
    placed: Placed,
    studio: &mut Studio,
) -> bool {
    let tool = studio.viewport.tool;
    let node = studio.selection.filter(|_| matches!(tool, Tool::Move | Tool::Rotate | Tool::Scale));
    let (Some(node), Some(frame)) = (node, studio.frame.clone()) else {
        studio.viewport.gizmo.drag = None;
        return false;
    };
    let stand = &frame.stand;
    let desc = studio.document.desc();
    let (transform, center) = match node {
        Node::Object(i) => {
            let Some(listed) = desc.objects.get(i) else { return false };
            let transform = listed.transform.0;
            let bounds = turner_live::pick::object_bounds(stand, i);
            (transform, bounds.map_or(transform.translation, |b| b.center()))
        }
        // Lights have a position at most.
        Node::Light(i) if tool == Tool::Move => {
            let Some(at) = desc.lights.get(i).and_then(|l| position_of(&l.value)) else { return false };
            (DAffine3::from_translation(at), at)
        }
        _ => return false,
    };
    // About a tenth of the distance to the camera: handles have a constant size in the window.
    let unit = (0.1 * position(&stand.prepared.view.camera).distance(center)).max(1e-6);
    let mut ends = Vec::new();
    for (axis, color, letter) in AXES {
        let Some((from, per_unit)) = axis_on_screen(stand, placed, center, axis, unit) else { continue };
        let length = (per_unit.length() * unit as f32).max(1e-3);
        // An axis that points at the viewer is shorter, like the object's own edges.
        let end = from + per_unit * unit as f32 * (LENGTH / length.max(LENGTH * 0.5));
        overlay::line(painter, [from, end], 2.5, color);
        match tool {
            Tool::Scale => {
                painter.rect_filled(egui::Rect::from_center_size(end, Vec2::splat(9.0)), 1.0, color);
            }
            Tool::Rotate => {
                painter.circle_stroke(end, 6.0, egui::Stroke::new(2.5, color));
            }
            _ => {
                painter.circle_filled(end, 5.0, color);
            }
        }
        let font = egui::TextStyle::Small.resolve(ui.style());
        painter.text(end + Vec2::new(8.0, -8.0), egui::Align2::LEFT_BOTTOM, letter, font, color);
        ends.push((from, end, per_unit));
    }
    if ends.len() < 3 {
        return false;
    }
    drag(ui, response, &ends, studio, node, (transform, center))
}

fn drag(
    ui: &egui::Ui,
    response: &Response,
    ends: &[(Pos2, Pos2, Vec2)],
    studio: &mut Studio,
    node: Node,
    (transform, center): (DAffine3, DVec3),
) -> bool {
    let near = |at: Pos2| {
        let far = |&(from, end, _): &(Pos2, Pos2, Vec2)| {
            let along = end - from;
            let t = ((at - from).dot(along) / along.length_sq().max(1e-6)).clamp(0.25, 1.0);
            (from + along * t).distance(at)
        };
        let nearest = (0..3).min_by(|&a, &b| far(&ends[a]).total_cmp(&far(&ends[b])))?;
        (far(&ends[nearest]) < 10.0).then_some(nearest)
    };
    let over = response.hover_pos().and_then(near);
    if over.is_some() || studio.viewport.gizmo.drag.is_some() {
        ui.ctx().set_cursor_icon(CursorIcon::Grab);
    }
    if response.drag_started_by(PointerButton::Primary)
        && let Some(from) = ui.input(|i| i.pointer.press_origin())
        && let Some(axis) = near(from)
    {
        studio.document.end_gesture();
        studio.viewport.gizmo.drag = Some(Drag { axis, start: transform, center, from });
    }
    let Some(Drag { axis, start, center, from }) = studio.viewport.gizmo.drag else { return over.is_some() };
    if response.drag_stopped() || !response.dragged() {
        studio.viewport.gizmo.drag = None;
        studio.document.end_gesture();
        return true;
    }
    let Some(now) = response.interact_pointer_pos() else { return true };
    let (origin, _, per_unit) = ends[axis];
    let along = f64::from((now - from).dot(per_unit) / per_unit.length_sq().max(1e-6));
    let (direction, _, _) = AXES[axis];
    let (label, by) = match studio.viewport.tool {
        Tool::Rotate => {
            let angle = |at: Pos2| f64::from((at - origin).angle());
            // Seen from the tip of the axis, a rotation is counter-clockwise; the window's y axis points down.
            let towards =
                studio.frame.as_ref().map_or(DVec3::Z, |f| position(&f.stand.prepared.view.camera) - center);
            let side = if towards.dot(direction) < 0.0 { 1.0 } else { -1.0 };
            let turn = side * (angle(now) - angle(from)).to_degrees();
            let about = DAffine3::from_mat3(rotation(direction, turn));
            let place = DAffine3::from_translation(center);
            ("Rotate", place * about * DAffine3::from_translation(-center))
        }
        Tool::Scale => {
            let reach = f64::from((from - origin).dot(per_unit) / per_unit.length_sq().max(1e-6));
            let factor = ((reach + along) / if reach.abs() < 1e-9 { 1e-9 } else { reach }).clamp(0.01, 100.0);
            // With Shift along one axis, else all.
            let one = ui.input(|i| i.modifiers.shift);
            let scale = if one { DVec3::ONE + direction * (factor - 1.0) } else { DVec3::splat(factor) };
            let place = DAffine3::from_translation(center);
            ("Scale", place * DAffine3::from_scale(scale) * DAffine3::from_translation(-center))
        }
        _ => ("Move", DAffine3::from_translation(direction * along)),
    };
    studio.moving();
    let result = studio.document.edit(label, Some("gizmo"), |desc| {
        let moved = by * start;
        match node {
            Node::Object(i) => desc.objects[i].transform.0 = moved,
            Node::Light(i) => match &mut desc.lights[i].value {
                LightDesc::Point(l) => l.position = moved.translation,
                LightDesc::Spot(l) => l.position = moved.translation,
                _ => {}
            },
            _ => {}
        }
        Ok(())
    });
    studio.check(result);
    true
}
