//! A second view of the scene: through another camera, or by another integrator.

use std::sync::Arc;

use egui::{Color32, ComboBox, Rect, TextureHandle, TextureOptions, Ui, pos2};
use turner::integrator::IntegratorDesc;
use turner_live::engine::{Engine, Frame, Look, Order};

use crate::studio::Studio;
use crate::viewport;
use crate::widgets::{entry, name};

/// The second view, while it is open.
#[derive(Default)]
pub struct Second {
    engine: Option<Engine>,
    look: Look,
    /// The bookmark that it looks through; `None` for the scene's camera.
    view: Option<usize>,
    texture: Option<(TextureHandle, Arc<Frame>)>,
    ordered: Option<Order>,
    is_shown: bool,
}

impl Second {
    /// Whether it renders, so that the threads are shared.
    pub fn is_open(&self) -> bool {
        self.engine.is_some()
    }

    /// At the end of a frame of the window: without its panel there is nothing to render.
    pub fn end_frame(&mut self) {
        if !std::mem::take(&mut self.is_shown) && self.engine.is_some() {
            *self = Second { look: self.look.clone(), view: self.view, ..Second::default() };
        }
    }
}

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    choices(ui, studio);
    let area = ui.available_rect_before_wrap();
    let scale = ui.pixels_per_point();
    let size = [area.width(), area.height()].map(|side| (side * scale).max(1.0) as u32);
    let (moving, threads) = (studio.is_moving(), studio.threads());
    let paused = studio.paused || studio.jobs.pauses_view();
    let desc = Arc::clone(studio.document.desc());
    let context = studio.wake().clone();
    let second = &mut studio.second;
    second.is_shown = true;
    second.look.camera = second.view.and_then(|i| desc.cameras.get(i)).map(|camera| camera.value.clone());
    let engine = second.engine.get_or_insert_with(|| Engine::new(move || context.request_repaint()));
    let look = second.look.clone();
    let order = Order { look, size, moving, paused, threads, ..Order::new(desc) };
    if !second.ordered.as_ref().is_some_and(|last| is_same(last, &order)) {
        engine.order(order.clone());
        second.ordered = Some(order);
    }
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 0.0, ui.visuals().extreme_bg_color);
    if let Some(frame) = engine.frame() {
        let is_shown = second.texture.as_ref().is_some_and(|(_, of)| Arc::ptr_eq(of, &frame));
        if !is_shown {
            let image = viewport::image(&frame.picture);
            let texture = ui.ctx().load_texture("second view", image, TextureOptions::LINEAR);
            second.texture = Some((texture, Arc::clone(&frame)));
        }
        let placed = viewport::placed(area, [frame.picture.width, frame.picture.height]);
        if let Some((texture, _)) = &second.texture {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture.id(), placed, whole, Color32::WHITE);
        }
    }
    if let Some(error) = engine.status().error {
        ui.label(error.message);
    }
}

/// Whether both orders ask for the same.
fn is_same(a: &Order, b: &Order) -> bool {
    Arc::ptr_eq(&a.desc, &b.desc)
        && (&a.look, a.size, a.threads) == (&b.look, b.size, b.threads)
        && (a.moving, a.paused) == (b.moving, b.paused)
}

fn choices(ui: &mut Ui, studio: &mut Studio) {
    let names: Vec<String> = {
        let desc = studio.document.desc();
        (0..desc.cameras.len()).map(|i| crate::node::Node::View(i).label(desc)).collect()
    };
    let second = &mut studio.second;
    ui.horizontal(|ui| {
        let now = second.look.integrator.as_ref().map_or("the scene's integrator", IntegratorDesc::type_name);
        let combo = ComboBox::from_id_salt("second integrator").selected_text(now).show_ui(ui, |ui| {
            if entry(ui, second.look.integrator.is_none(), "the scene's integrator").clicked() {
                second.look.integrator = None;
            }
            for kind in IntegratorDesc::DOC.entries {
                if entry(ui, now == kind.name, kind.name).clicked() {
                    second.look.integrator = IntegratorDesc::of_type(kind.name);
                }
            }
        });
        name(&combo.response, egui::Role::ComboBox, "Integrator of the second view");
        let of_view = |i: usize| names.get(i).map_or("the scene's camera", String::as_str);
        let combo = ComboBox::from_id_salt("second camera")
            .selected_text(second.view.map_or("the scene's camera", of_view))
            .show_ui(ui, |ui| {
                if entry(ui, second.view.is_none(), "the scene's camera").clicked() {
                    second.view = None;
                }
                for (i, name) in names.iter().enumerate() {
                    if ui.push_id(i, |ui| entry(ui, second.view == Some(i), name)).inner.clicked() {
                        second.view = Some(i);
                    }
                }
            });
        name(&combo.response, egui::Role::ComboBox, "Camera of the second view");
    });
}
