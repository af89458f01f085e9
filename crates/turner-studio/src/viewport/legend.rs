//! The legend of a picture whose colours stand for numbers: the colour map with its values.

use egui::{Color32, Painter, Rect, Sense, Stroke, TextStyle, Vec2, pos2};
use turner::color::{ColorScale, heat};
use turner::explain::number;

/// Size of the colour map.
const SIZE: Vec2 = Vec2::new(220.0, 12.0);

/// The value of a mark, without digits that nobody needs.
fn text(value: f64) -> String {
    number::short(value)
}

/// The scale in words.
pub(crate) fn in_words(scale: &ColorScale) -> String {
    let ends = (scale.marks.first(), scale.marks.last());
    let (Some((_, least)), Some((_, most))) = ends else { return String::new() };
    format!("Black is {}, pale yellow is {} {}", text(*least), text(*most), scale.unit)
}

/// Draws the legend in the lower right corner of an area.
pub(super) fn show(ui: &egui::Ui, painter: &Painter, area: Rect, scale: &ColorScale) {
    let font = TextStyle::Small.resolve(ui.style());
    let line = ui.fonts_mut(|fonts| fonts.row_height(&font));
    // Room for half of a number beyond both ends.
    let margin = Vec2::new(24.0, 5.0);
    let size = Vec2::new(SIZE.x + 2.0 * margin.x, SIZE.y + 2.0 * line + 2.0 * margin.y + 4.0);
    if size.x > area.width() || size.y > area.height() {
        return;
    }
    let back = Rect::from_min_size(area.right_bottom() - size - Vec2::splat(6.0), size);
    painter.rect_filled(back, 3.0, Color32::from_black_alpha(190));
    let title = pos2(back.center().x, back.top() + margin.y);
    painter.text(title, egui::Align2::CENTER_TOP, scale.unit, font.clone(), Color32::WHITE);
    let bar = Rect::from_min_size(pos2(back.left() + margin.x, title.y + line + 2.0), SIZE);
    let steps = SIZE.x as usize / 2;
    for i in 0..steps {
        let [r, g, b] = heat(i as f32 / (steps - 1) as f32).to_array().map(|v| (v * 255.0 + 0.5) as u8);
        let step = Rect::from_min_size(pos2(bar.left() + 2.0 * i as f32, bar.top()), Vec2::new(2.0, SIZE.y));
        painter.rect_filled(step, 0.0, Color32::from_rgb(r, g, b));
    }
    painter.rect_stroke(bar, 0.0, Stroke::new(1.0, Color32::from_gray(200)), egui::StrokeKind::Outside);
    for (place, value) in &scale.marks {
        let x = bar.left() + bar.width() * place;
        painter.vline(x, bar.bottom()..=bar.bottom() + 3.0, Stroke::new(1.0, Color32::WHITE));
        let at = pos2(x, bar.bottom() + 3.0);
        painter.text(at, egui::Align2::CENTER_TOP, text(*value), font.clone(), Color32::WHITE);
    }
    let response = ui.interact(back, ui.scope_id().with("legend"), Sense::hover());
    let words = in_words(scale);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &words));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_is_told_in_words() {
        let scale = ColorScale::linear(0.0, 12.0, "bounces");
        assert_eq!(in_words(&scale), "Black is 0, pale yellow is 12 bounces");
    }
}
