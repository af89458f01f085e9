//! Scenes to start from.

use egui::Ui;
use turner_live::document::STARTS;

use crate::studio::{After, Studio};

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    let mut chosen = None;
    egui::ScrollArea::vertical().show(ui, |ui| {
        if ui.button("Empty stage").on_hover_text("A new scene with a floor and lights").clicked() {
            chosen = Some(After::New);
        }
        let mut group = "";
        for start in STARTS {
            if start.group != group {
                group = start.group;
                ui.add_space(8.0);
                ui.strong(group);
            }
            if ui
                .selectable_label(studio.document.name() == start.name, start.name)
                .on_hover_text(start.about)
                .clicked()
            {
                chosen = Some(After::Start(start));
            }
        }
        if !studio.settings.recent.is_empty() {
            ui.add_space(8.0);
            ui.strong("Recent files");
            for path in &studio.settings.recent {
                let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
                let label = ui.selectable_label(false, name).on_hover_text(path.display().to_string());
                if label.clicked() {
                    chosen = Some(After::Open(path.clone()));
                }
            }
        }
    });
    if let Some(after) = chosen {
        studio.leave(after);
    }
}
