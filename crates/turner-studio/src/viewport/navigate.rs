//! Looking around: orbit, pan, dolly and fly.
//!
//! Drag with the left button: orbit. With the middle button, or with Shift: pan. Wheel: dolly. Hold the right button to
//! look around and fly with W, A, S, D, E, Q; Shift flies four times as fast.

use egui::{Key, PointerButton};
use turner::math::DVec3;
use turner_live::camera;

use super::Placed;
use crate::cameras::{camera_of, move_camera};
use crate::studio::Studio;

/// Radians per height of the picture.
const TURN: f64 = 3.0;

pub(super) fn show(ui: &egui::Ui, response: &egui::Response, placed: Placed, studio: &mut Studio) {
    let height = f64::from(placed.rect.height().max(1.0));
    let aspect = placed.film[0] / placed.film[1];
    let by = response.drag_delta();
    let (right, down) = (f64::from(by.x) / height, f64::from(by.y) / height);
    let shift = ui.input(|i| i.modifiers.shift);
    if by != egui::Vec2::ZERO {
        if response.dragged_by(PointerButton::Middle) || response.dragged_by(PointerButton::Primary) && shift
        {
            move_camera(studio, "Pan", |c| camera::pan(c, right, -down, aspect));
        } else if response.dragged_by(PointerButton::Primary) {
            move_camera(studio, "Orbit", |c| camera::orbit(c, -right * TURN, down * TURN));
        } else if response.dragged_by(PointerButton::Secondary) {
            move_camera(studio, "Look around", |c| camera::look(c, right * TURN, -down * TURN));
        }
    }
    if response.dragged_by(PointerButton::Secondary)
        || response.is_pointer_button_down_on() && down_on_secondary(ui)
    {
        fly(ui, shift, studio);
    }
    if response.drag_stopped() {
        studio.document.end_gesture();
    }
    if response.hovered() {
        let scroll = f64::from(ui.input(|i| i.smooth_scroll_delta().y));
        let pinch = f64::from(ui.input(|i| i.zoom_delta()));
        let factor = (1.0 - scroll * 0.002).clamp(0.5, 2.0) / pinch.clamp(0.5, 2.0);
        if factor != 1.0 {
            move_camera(studio, "Dolly", |c| camera::dolly(c, factor));
        }
    }
}

fn down_on_secondary(ui: &egui::Ui) -> bool {
    ui.input(|i| i.pointer.secondary_down())
}

/// Moves by the keys that are held. The speed is half the distance to the look-at point per second.
fn fly(ui: &egui::Ui, fast: bool, studio: &mut Studio) {
    let axis = |plus: Key, minus: Key| {
        ui.input(|i| f64::from(i8::from(i.key_down(plus)) - i8::from(i.key_down(minus))))
    };
    let by = DVec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S));
    if by == DVec3::ZERO {
        return;
    }
    let Some(camera) = camera_of(studio) else { return };
    let speed = 0.5 * camera::distance(&camera.value) * if fast { 4.0 } else { 1.0 };
    let step = f64::from(ui.input(|i| i.stable_dt).min(0.1)) * speed;
    move_camera(studio, "Fly", |c| camera::fly(c, by * step));
    ui.ctx().request_repaint();
}
