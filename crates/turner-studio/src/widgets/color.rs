//! Colours: a button with a picker, and numbers for values that no display shows.

use egui::{DragValue, Ui};
use turner::schema::Range;

use super::{name, name_number};

/// Edits a colour. With `encoded`, values are display values as in classic scenes; else they are linear. Returns whether
/// it changed.
pub(crate) fn edit(
    ui: &mut Ui,
    rgb: &mut [f64; 3],
    encoded: bool,
    range: Option<Range>,
    label: &str,
) -> bool {
    let mut changed = false;
    ui.horizontal(|ui| {
        // Colours brighter than 1 keep their brightness in the picker.
        let scale = rgb.iter().copied().fold(1.0, f64::max);
        let shown = rgb.map(|v| (v / scale).clamp(0.0, 1.0) as f32);
        let response = if encoded {
            let mut srgb = shown.map(|v| (v * 255.0).round() as u8);
            let response = ui.color_edit_button_srgb(&mut srgb);
            if response.changed() {
                *rgb = srgb.map(|v| f64::from(v) / 255.0 * scale);
            }
            response
        } else {
            let mut linear = shown;
            let response = ui.color_edit_button_rgb(&mut linear);
            if response.changed() {
                *rgb = linear.map(|v| f64::from(v) * scale);
            }
            response
        };
        changed |= response.changed();
        name(&response, egui::Role::ColorWell, label);
        let range = range.unwrap_or(Range::FINITE);
        for (value, channel) in rgb.iter_mut().zip(["red", "green", "blue"]) {
            let speed = (value.abs() * 0.01).max(0.002);
            let drag = DragValue::new(&mut *value).speed(speed).range(range.min..=range.max).max_decimals(4);
            let response = ui.add(drag);
            name_number(&response, &format!("{label}, {channel}"), *value);
            changed |= response.changed();
        }
    });
    changed
}
