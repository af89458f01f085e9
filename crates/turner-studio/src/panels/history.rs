//! The steps that can be undone and redone.

use egui::Ui;

use crate::actions::Action;
use crate::studio::Studio;

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    ui.horizontal(|ui| {
        for action in [Action::Undo, Action::Redo] {
            let possible = action.is_possible(studio);
            if ui.add_enabled(possible, egui::Button::new(action.label())).clicked() {
                action.run(studio);
            }
        }
    });
    let (done, undone) = studio.document.steps();
    let (count, done): (usize, Vec<String>) = (done.len(), done.iter().map(|s| (*s).to_owned()).collect());
    let undone: Vec<String> = undone.iter().map(|s| (*s).to_owned()).collect();
    let mut go = 0i64;
    egui::ScrollArea::vertical().show(ui, |ui| {
        if ui.selectable_label(count == 0, "Opened").clicked() {
            go = -(count as i64);
        }
        for (i, label) in done.iter().enumerate() {
            let last = i + 1 == count;
            if ui.push_id(i, |ui| ui.selectable_label(last, label)).inner.clicked() {
                go = (i + 1) as i64 - count as i64;
            }
        }
        for (i, label) in undone.iter().enumerate() {
            let text = egui::RichText::new(label).weak();
            if ui.push_id(count + i, |ui| ui.selectable_label(false, text)).inner.clicked() {
                go = (i + 1) as i64;
            }
        }
    });
    for _ in 0..go.abs() {
        let action = if go < 0 { Action::Undo } else { Action::Redo };
        action.run(studio);
    }
}
