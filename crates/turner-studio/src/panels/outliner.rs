//! The parts of the scene as a list. Long lists show what is scrolled to.

use egui::{CollapsingHeader, Ui};

use crate::actions::Action;
use crate::node::Node;
use crate::studio::Studio;
use crate::widgets::name_text;

/// A list of parts: heading, count, and the part of an index.
type List = (&'static str, usize, fn(usize) -> Node);

/// Entries that a list shows without a search.
const MOST: usize = 400;

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    let search = ui.data_mut(|d| d.get_temp::<String>(egui::Id::unique("search"))).unwrap_or_default();
    let mut text = search;
    let hint = egui::TextEdit::singleline(&mut text).hint_text("Search").desired_width(f32::INFINITY);
    let response = ui.add(hint);
    name_text(&response, "Search the scene", &text);
    ui.data_mut(|d| d.insert_temp(egui::Id::unique("search"), text.clone()));
    let desc = studio.document.desc().clone();
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for node in [Node::Camera, Node::Film, Node::Integrator, Node::Background, Node::Studio] {
            if node.exists(&desc) {
                entry(ui, studio, node, &node.label(&desc));
            }
        }
        let lists: [List; 6] = [
            ("Objects", desc.objects.len(), Node::Object),
            ("Lights", desc.lights.len(), Node::Light),
            ("Materials", desc.materials.len(), Node::Material),
            ("Textures", desc.textures.len(), Node::Texture),
            ("Media", desc.media.len(), Node::Medium),
            ("Views", desc.cameras.len(), Node::View),
        ];
        for (title, count, node) in lists {
            if count == 0 {
                continue;
            }
            let header =
                CollapsingHeader::new(format!("{title} ({count})")).id_salt(title).default_open(count < 60);
            header.show(ui, |ui| {
                let needle = text.to_lowercase();
                let mut shown = 0;
                for i in 0..count {
                    let label = node(i).label(&desc);
                    if !needle.is_empty() && !label.to_lowercase().contains(&needle) {
                        continue;
                    }
                    shown += 1;
                    if shown > MOST {
                        ui.weak(format!("{} more: search for a name", count - i));
                        break;
                    }
                    entry(ui, studio, node(i), &label);
                }
            });
        }
    });
}

fn entry(ui: &mut Ui, studio: &mut Studio, node: Node, label: &str) {
    let is_selected = studio.is_selected(node);
    let response = ui.push_id(node, |ui| ui.selectable_label(is_selected, label)).inner;
    if response.clicked() {
        let more = ui.input(|i| i.modifiers.command || i.modifiers.shift);
        studio.select(Some(node), more);
    }
    if response.double_clicked() {
        match node {
            Node::View(i) => go_to(studio, i),
            _ => studio.queue.push(Action::Frame),
        }
    }
    response.context_menu(|ui| {
        if !studio.is_selected(node) {
            studio.select(Some(node), false);
        }
        if let Node::View(i) = node
            && ui.button("Look through it").clicked()
        {
            go_to(studio, i);
            ui.close();
        }
        for action in [
            Action::Frame,
            Action::Rename,
            Action::Duplicate,
            Action::Hide,
            Action::Group,
            Action::Ungroup,
            Action::Copy,
            Action::Delete,
        ] {
            if ui.add_enabled(action.is_possible(studio), egui::Button::new(action.label())).clicked() {
                studio.queue.push(action);
                ui.close();
            }
        }
    });
}

/// Makes a bookmark the camera.
fn go_to(studio: &mut Studio, view: usize) {
    let Some(camera) = studio.document.desc().cameras.get(view).cloned() else { return };
    let result = studio.document.edit("Look through a view", None, |desc| {
        desc.camera = Some(camera);
        Ok(())
    });
    studio.check(result);
}
