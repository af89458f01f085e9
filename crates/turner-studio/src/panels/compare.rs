//! A kept picture beside the present one.

use egui::Ui;

use crate::insight::Comparison;
use crate::studio::Studio;

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    ui.horizontal(|ui| {
        let possible = studio.frame.is_some();
        if ui.add_enabled(possible, egui::Button::new("Keep the picture")).clicked() {
            studio.insight.snapshot = studio.frame.clone();
            studio.insight.comparison = Comparison::Wipe(0.5);
        }
        if studio.insight.snapshot.is_some() && ui.button("Forget it").clicked() {
            studio.insight.snapshot = None;
            studio.insight.comparison = Comparison::Off;
        }
    });
    if studio.insight.snapshot.is_none() {
        ui.weak("Keep a picture, change the scene, and compare: by a wipe, as a difference, or by FLIP.");
        return;
    }
    let now = studio.insight.comparison;
    for (comparison, name, help) in [
        (Comparison::Off, "Off", "The picture alone"),
        (Comparison::Wipe(0.5), "Wipe", "The kept picture on the left, the present one on the right"),
        (Comparison::Difference, "Difference", "Differences of display values, four times as large"),
        (Comparison::Flip, "FLIP", "The difference that an observer sees when the pictures alternate"),
    ] {
        let is_on = std::mem::discriminant(&now) == std::mem::discriminant(&comparison);
        if ui.radio(is_on, name).on_hover_text(help).clicked() && !is_on {
            studio.insight.comparison = comparison;
        }
    }
    if let Comparison::Wipe(at) = &mut studio.insight.comparison {
        let slider = ui.add(egui::Slider::new(at, 0.0..=1.0).text("edge"));
        crate::widgets::name_number(&slider, "Edge of the wipe", f64::from(*at));
    }
    if let Some(text) = studio.viewport.compared_text() {
        ui.label(text);
    }
}
