//! The picture and what is done in it with mouse and keys.

mod compared;
pub(crate) use compared::image;
pub(crate) mod gizmo;
pub(crate) mod legend;
mod navigate;
pub(crate) mod overlay;
mod vision;

use std::sync::Arc;

use egui::{Color32, Rect, Sense, TextureHandle, TextureOptions, Vec2, pos2};
use turner::color::Vision;
use turner::light::LightDesc;
use turner_live::engine::{Frame, Stage};
use turner_live::{camera, pick};

use crate::cameras::move_camera;
use crate::node::Node;
use crate::studio::Studio;

/// What a click or a drag in the picture does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Select; drag to look around.
    #[default]
    Select,
    /// Move the selected object along its axes.
    Move,
    /// Rotate the selected object about its axes.
    Rotate,
    /// Scale the selected object along its axes.
    Scale,
    /// Focus the camera at the clicked point.
    Focus,
    /// Aim the selected spot light at the clicked point.
    Aim,
    /// Explain the clicked pixel.
    Explain,
}

/// The viewport's state.
#[derive(Default)]
pub struct ViewportState {
    /// The tool in hand.
    pub tool: Tool,
    /// The text of the command palette, if it is open.
    pub palette: Option<String>,
    /// The pixel under the pointer, in pixels of the film.
    pub under_pointer: Option<[f64; 2]>,
    /// The pixel that was under the pointer last.
    pub last_pixel: Option<[u32; 2]>,
    /// How colours are seen.
    pub vision: Vision,
    /// The pixel that is explained.
    pub explained: Option<[u32; 2]>,
    texture: Option<(TextureHandle, Arc<Frame>, Vision)>,
    gizmo: gizmo::GizmoState,
    compared: compared::Compared,
    boxes: overlay::Boxes,
}

impl ViewportState {
    /// The result of the comparison with the kept picture.
    pub(crate) fn compared_text(&self) -> Option<&str> {
        self.compared.text.as_deref()
    }
}

/// The rectangle of the picture in the window, and its size in pixels of the film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub(crate) rect: Rect,
    pub(crate) film: [f64; 2],
}

impl Placed {
    /// The largest rectangle of the film's aspect inside `area`.
    fn new(area: Rect, film: [u32; 2]) -> Placed {
        let film = film.map(|side| f64::from(side.max(1)));
        let scale = (f64::from(area.width()) / film[0]).min(f64::from(area.height()) / film[1]).max(0.0);
        let size = Vec2::new((film[0] * scale) as f32, (film[1] * scale) as f32);
        Placed { rect: Rect::from_center_size(area.center(), size), film }
    }

    /// From the window to pixels of the film.
    pub(crate) fn to_film(self, at: egui::Pos2) -> [f64; 2] {
        let scale = self.film[0] / f64::from(self.rect.width().max(1e-6));
        [f64::from(at.x - self.rect.left()) * scale, f64::from(at.y - self.rect.top()) * scale]
    }

    /// From pixels of the film to the window.
    pub(crate) fn to_window(self, at: [f64; 2]) -> egui::Pos2 {
        let scale = f64::from(self.rect.width()) / self.film[0];
        pos2(self.rect.left() + (at[0] * scale) as f32, self.rect.top() + (at[1] * scale) as f32)
    }
}

/// The rectangle of a picture of this size inside `area`.
pub(crate) fn placed(area: Rect, size: [u32; 2]) -> Rect {
    Placed::new(area, size).rect
}

/// Shows the picture.
pub(crate) fn show(ui: &mut egui::Ui, studio: &mut Studio) {
    tools(ui, studio);
    let area = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(area, Sense::click_and_drag());
    let scale = ui.pixels_per_point();
    studio.set_size([area.width(), area.height()].map(|side| (side * scale).max(1.0) as u32));
    let film = &studio.document.desc().film;
    let placed = Placed::new(area, [film.width, film.height]);
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 0.0, ui.visuals().extreme_bg_color);
    if let Some(frame) = studio.frame.clone() {
        let has_alpha = frame.picture.has_alpha;
        let texture = texture(ui.ctx(), studio, frame);
        if has_alpha {
            overlay::checkerboard(&painter, placed.rect);
        }
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(texture, placed.rect, whole, Color32::WHITE);
        compared::show(ui.ctx(), &painter, placed.rect, studio);
    }
    response.widget_info(|| {
        let what = format!("Picture of {}", studio.document.name());
        egui::WidgetInfo::labeled(egui::Role::Image, true, what)
    });
    let pointer = response.hover_pos().map(|at| placed.to_film(at));
    studio.viewport.under_pointer = pointer;
    overlay::show(&painter, placed, studio);
    let taken = gizmo::show(ui, &painter, &response, placed, studio);
    if !taken {
        navigate::show(ui, &response, placed, studio);
        click(&response, placed, studio);
    }
    caption(ui, &painter, area, studio);
    if let Some(scale) = studio.frame.as_ref().and_then(|frame| frame.scale.as_ref()) {
        legend::show(ui, &painter, area, scale);
    }
}

/// The newest frame as a texture.
fn texture(ctx: &egui::Context, studio: &mut Studio, frame: Arc<Frame>) -> egui::TextureId {
    let state = &mut studio.viewport;
    let vision = state.vision;
    if let Some((texture, shown, seen)) = &state.texture
        && Arc::ptr_eq(&shown.picture, &frame.picture)
        && *seen == vision
    {
        return texture.id();
    }
    let mut image = compared::image(&frame.picture);
    vision::apply(&mut image, vision);
    // A preview may be smaller than the window's part; pixels of the film are shown as they are.
    let options = match frame.stage {
        Stage::Preview => TextureOptions::LINEAR,
        _ => TextureOptions { magnification: egui::TextureFilter::Nearest, ..TextureOptions::LINEAR },
    };
    match &mut state.texture {
        Some((texture, shown, seen)) => {
            texture.set(image, options);
            (*shown, *seen) = (frame, vision);
            texture.id()
        }
        none => {
            let texture = ctx.load_texture("picture", image, options);
            let id = texture.id();
            *none = Some((texture, frame, vision));
            id
        }
    }
}

/// The row of tools above the picture.
fn tools(ui: &mut egui::Ui, studio: &mut Studio) {
    use crate::actions::Action;
    ui.horizontal(|ui| {
        ui.add_space(4.0);
        let tools = [
            (Tool::Select, "Select", Action::ToolSelect),
            (Tool::Move, "Move", Action::ToolMove),
            (Tool::Rotate, "Rotate", Action::ToolRotate),
            (Tool::Scale, "Scale", Action::ToolScale),
            (Tool::Focus, "Focus", Action::ToolFocus),
            (Tool::Aim, "Aim", Action::ToolAim),
            (Tool::Explain, "Explain", Action::ToolExplain),
        ];
        for (tool, name, action) in tools {
            let key = action.shortcut().map(|s| ui.ctx().format_shortcut(&s)).unwrap_or_default();
            let button = ui.selectable_label(studio.viewport.tool == tool, name);
            if button.on_hover_text(format!("{} ({key})", action.label())).clicked() {
                studio.viewport.tool = tool;
            }
        }
        ui.separator();
        let pause = if studio.paused { "Continue" } else { "Pause" };
        if ui.button(pause).on_hover_text("Pause or continue rendering (Space)").clicked() {
            studio.paused = !studio.paused;
        }
    });
}

fn click(response: &egui::Response, placed: Placed, studio: &mut Studio) {
    let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) else { return };
    let at = placed.to_film(at);
    let Some(frame) = studio.frame.clone() else { return };
    let picked = pick::pick(&frame.stand, at);
    match studio.viewport.tool {
        Tool::Focus => match picked {
            Some(picked) => {
                studio.document.end_gesture();
                move_camera(studio, "Focus", |c| camera::focus(c, picked.point));
                studio.document.end_gesture();
                studio.say(format!("Focused at {:.3} from the camera, on {}", picked.distance, picked.label));
            }
            None => studio.say("Nothing to focus on there"),
        },
        Tool::Aim => aim(studio, picked.map(|picked| picked.point)),
        Tool::Explain => {
            let inside = at[0] >= 0.0 && at[1] >= 0.0 && at[0] < placed.film[0] && at[1] < placed.film[1];
            studio.viewport.explained = inside.then(|| at.map(|v| v as u32));
        }
        Tool::Select | Tool::Move | Tool::Rotate | Tool::Scale => {
            let node = picked.and_then(|picked| picked.object).map(Node::Object);
            let more = response.ctx.input(|i| i.modifiers.command || i.modifiers.shift);
            studio.select(node, more);
        }
    }
}

/// Aims the selected spot light at a point.
fn aim(studio: &mut Studio, point: Option<turner::math::DVec3>) {
    let spot = match studio.selection {
        Some(Node::Light(i)) => Some(i),
        _ => None,
    };
    let (Some(i), Some(point)) = (spot, point) else {
        studio.say("Select a spot light in the list, then click what it should light");
        return;
    };
    if !matches!(studio.document.desc().lights.get(i).map(|l| &l.value), Some(LightDesc::Spot(_))) {
        studio.say("Only spot lights are aimed; move the others");
        return;
    }
    let result = studio.document.edit("Aim", None, |desc| {
        if let LightDesc::Spot(spot) = &mut desc.lights[i].value {
            spot.look_at = point;
        }
        Ok(())
    });
    studio.check(result);
}

/// What the picture is, in its lower corner.
fn caption(ui: &egui::Ui, painter: &egui::Painter, area: Rect, studio: &Studio) {
    let Some(frame) = &studio.frame else { return };
    let status = &studio.status;
    let kind = match frame.stage {
        Stage::Preview => format!("preview {} x {}", frame.picture.width, frame.picture.height),
        Stage::Film { samples, denoised } => {
            let clean = if denoised { ", denoised" } else { "" };
            format!("{samples} of {} samples{clean}", status.samples.1)
        }
        Stage::Settled => format!("finished: {} samples", status.samples.1),
    };
    let noise = frame.noise.map_or_else(String::new, |noise| format!(" · noise {:.1} %", 100.0 * noise));
    let left = status.left.filter(|left| *left > 0.5 && !status.settled);
    let left = left.map_or_else(String::new, |left| format!(" · about {} left", duration(left)));
    let paused = if studio.paused { " · paused" } else { "" };
    let seen = match studio.viewport.vision {
        Vision::Normal => String::new(),
        vision => format!(" · as seen with {}", vision.name()),
    };
    let text = format!("{kind}{noise}{left}{paused}{seen}");
    let font = egui::TextStyle::Small.resolve(ui.style());
    let galley = painter.layout_no_wrap(text, font, Color32::WHITE);
    let at = area.left_bottom() + Vec2::new(6.0, -6.0 - galley.size().y);
    let back = Rect::from_min_size(at, galley.size()).expand(3.0);
    painter.rect_filled(back, 3.0, Color32::from_black_alpha(170));
    painter.galley(at, galley, Color32::WHITE);
}

/// Seconds for people.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
