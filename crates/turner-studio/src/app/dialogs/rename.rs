//! The new name of a part.

use egui::text::{CCursor, CCursorRange};
use egui::{Key, TextEdit, Ui};

use crate::changes::rename;
use crate::node::Node;
use crate::studio::{Dialog, Studio};
use crate::widgets::name_text;

pub(super) fn show(
    ui: &mut Ui,
    studio: &mut Studio,
    node: Node,
    mut name: String,
    mut fault: Option<String>,
) -> Option<Dialog> {
    ui.heading(format!("Rename {}", node.label(studio.document.desc())));
    let response = ui.add(TextEdit::singleline(&mut name).desired_width(f32::INFINITY));
    name_text(&response, "New name", &name);
    let enter = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    // The keyboard writes the name at once.
    if !enter && ui.memory(|memory| memory.focused().is_none()) {
        response.request_focus();
        // Writing replaces the old name.
        let mut state = egui::text_edit::TextEditState::load(ui.ctx(), response.id).unwrap_or_default();
        let all = CCursorRange::two(CCursor::new(0), CCursor::new(name.chars().count()));
        state.cursor.set_char_range(Some(all));
        state.store(ui.ctx(), response.id);
    }
    if response.changed() {
        fault = None;
    }
    match &fault {
        Some(fault) => ui.colored_label(ui.visuals().error_fg_color, fault),
        None => ui.weak("What refers to it follows."),
    };
    let mut done = false;
    ui.horizontal(|ui| {
        if ui.button("Rename").clicked() || enter {
            fault = rename(studio, node, &name).err().map(|error| error.message);
            done = fault.is_none();
        }
        done |= ui.button("Cancel").clicked();
    });
    (!done).then_some(Dialog::Rename { node, name, fault })
}
