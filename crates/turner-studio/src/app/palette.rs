//! The command palette: every action by its name.

use egui::{Key, Modifiers};

use crate::actions::Action;
use crate::studio::Studio;
use crate::widgets::name_text;

/// Actions that are listed at once.
const MOST: usize = 12;

/// Whether the letters of `needle` occur in `text` in this order.
fn matches(text: &str, needle: &str) -> bool {
    let mut letters = text.chars().flat_map(char::to_lowercase);
    needle
        .chars()
        .flat_map(char::to_lowercase)
        .filter(|c| !c.is_whitespace())
        .all(|c| letters.any(|l| l == c))
}

/// The possible actions for a text, those that contain it first.
fn found(studio: &Studio, needle: &str) -> Vec<Action> {
    let mut actions: Vec<Action> = Action::all();
    actions.retain(|a| *a != Action::Palette && a.is_possible(studio) && matches(&a.label(), needle));
    actions.sort_by_key(|action| !action.label().to_lowercase().contains(&needle.to_lowercase()));
    actions.truncate(MOST);
    actions
}

pub(super) fn show(ctx: &egui::Context, studio: &mut Studio) {
    let Some(mut text) = studio.viewport.palette.clone() else { return };
    let index = egui::Id::unique("palette index");
    let mut at: usize = ctx.data_mut(|d| d.get_temp(index)).unwrap_or(0);
    let list = found(studio, &text);
    let pressed = |key| ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key));
    let (up, down) = (pressed(Key::ArrowUp), pressed(Key::ArrowDown));
    let (enter, escape) = (pressed(Key::Enter), pressed(Key::Escape));
    at = (at + usize::from(down)).saturating_sub(usize::from(up)).min(list.len().saturating_sub(1));
    let mut chosen = if enter { list.get(at).copied() } else { None };
    let mut open = !escape;
    let modal = egui::Modal::new(egui::Id::unique("palette")).show(ctx, |ui| {
        ui.set_width(420.0);
        let field =
            egui::TextEdit::singleline(&mut text).hint_text("Type a command").desired_width(f32::INFINITY);
        let response = ui.add(field);
        name_text(&response, "Command", &text);
        response.request_focus();
        if response.changed() {
            at = 0;
        }
        let weak = ui.visuals().weak_text_color;
        for (i, action) in list.iter().enumerate() {
            // Weak text is too weak on the colour of the selection.
            let on_selection = Some(ui.visuals().selection.stroke.color);
            ui.visuals_mut().weak_text_color = if i == at { on_selection } else { weak };
            let mut button = egui::Button::selectable(i == at, action.label());
            if let Some(shortcut) = action.shortcut() {
                let text = ui.ctx().format_shortcut(&shortcut);
                button = button.shortcut_text(text);
            }
            if ui.add_sized([ui.available_width(), 22.0], button).clicked() {
                chosen = Some(*action);
            }
        }
        if list.is_empty() {
            ui.weak("No command has this name");
        }
    });
    open &= !modal.should_close();
    ctx.data_mut(|d| d.insert_temp(index, at));
    if let Some(action) = chosen {
        studio.queue.push(action);
        open = false;
    }
    if !open {
        ctx.data_mut(|d| d.insert_temp(index, 0usize));
    }
    studio.viewport.palette = open.then_some(text);
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn letters_in_order_are_enough() {
        assert!(matches("Frame the selection", "frsel"));
        assert!(matches("Add sphere", "ADD sph"));
        assert!(!matches("Add sphere", "spa"));
    }
}
