//! The window: menus, panels, messages, dialogs.

mod dialogs;
mod palette;

use egui::{Button, Color32, Panel as Edge, Popup, RichText, Role, Ui};
use egui_tiles::Tree;

use crate::actions::{Action, MENUS};
use crate::layout::{self, Panel};
use crate::settings::Theme;
use crate::studio::{After, Studio};
use crate::widgets::name;

/// The program in its window.
pub struct App {
    /// What the parts of the window share.
    pub studio: Studio,
    tree: Tree<Panel>,
    /// Theme, size and title that the window has.
    shown: (Option<(Theme, f32)>, String),
}

impl App {
    /// A window's contents with an empty scene.
    pub fn new(ctx: &egui::Context, home: std::path::PathBuf) -> App {
        App { studio: Studio::new(ctx, home), tree: layout::initial(), shown: Default::default() }
    }

    /// One frame.
    pub fn show(&mut self, ui: &mut Ui) {
        self.studio.poll();
        self.appearance(ui.ctx());
        self.dropped(ui.ctx());
        shortcuts(ui.ctx(), &mut self.studio);
        Edge::top("menus").show(ui, |ui| self.menus(ui));
        Edge::bottom("status").show(ui, |ui| self.status(ui));
        if let Some(panel) = self.studio.reveal.take() {
            layout::reveal(&mut self.tree, panel);
        }
        egui::CentralPanel::default().frame(egui::Frame::new()).show(ui, |ui| {
            layout::show(ui, &mut self.tree, &mut self.studio);
        });
        palette::show(ui.ctx(), &mut self.studio);
        dialogs::show(ui.ctx(), &mut self.studio);
        for action in std::mem::take(&mut self.studio.queue) {
            action.run(&mut self.studio);
        }
        // A drag or an entry has ended: the next change is a step of its own.
        let ended = |i: &egui::InputState| {
            i.pointer.any_released()
                || [egui::Key::Enter, egui::Key::Tab].into_iter().any(|key| i.key_pressed(key))
        };
        if ui.ctx().input(ended) {
            self.studio.document.end_gesture();
        }
        self.studio.second.end_frame();
        self.studio.order();
        self.close(ui.ctx());
    }

    fn appearance(&mut self, ctx: &egui::Context) {
        let wanted = (self.studio.settings.theme, self.studio.settings.zoom);
        // Setting them again would ask for another frame.
        if self.shown.0.replace(wanted) == Some(wanted) {
            return;
        }
        let theme = match self.studio.settings.theme {
            Theme::Dark => egui::ThemePreference::Dark,
            Theme::Light => egui::ThemePreference::Light,
            Theme::System => egui::ThemePreference::System,
        };
        ctx.set_theme(theme);
        // Text is readable on panels, fields and buttons: a contrast of 4.5 at least.
        ctx.style_mut_of(egui::Theme::Dark, |style| {
            style.visuals.weak_text_color = Some(Color32::from_gray(0x94));
            style.visuals.error_fg_color = Color32::from_rgb(255, 110, 100);
        });
        ctx.style_mut_of(egui::Theme::Light, |style| {
            style.visuals.weak_text_color = Some(Color32::from_gray(0x60));
            style.visuals.error_fg_color = Color32::from_rgb(190, 0, 0);
            style.visuals.warn_fg_color = Color32::from_rgb(140, 70, 0);
        });
        ctx.set_zoom_factor(self.studio.settings.zoom);
    }

    /// Files that are dropped on the window.
    fn dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        if let Some(path) = files.into_iter().next().map(|file| file.path().to_owned()) {
            self.studio.leave(After::Open(path));
        }
    }

    fn menus(&mut self, ui: &mut Ui) {
        egui::MenuBar::new().ui(ui, |ui| {
            for menu in MENUS {
                ui.menu_button(*menu, |ui| {
                    egui::ScrollArea::vertical().max_height(600.0).show(ui, |ui| {
                        for action in Action::all().into_iter().filter(|action| action.menu() == *menu) {
                            item(ui, action, &mut self.studio);
                        }
                    });
                });
            }
            ui.separator();
            let changed = if self.studio.document.is_changed() { " (changed)" } else { "" };
            ui.label(RichText::new(format!("{}{changed}", self.studio.document.name())).strong());
        });
    }

    fn status(&mut self, ui: &mut Ui) {
        let studio = &mut self.studio;
        if let Some(problem) = studio.problem.clone() {
            ui.horizontal_wrapped(|ui| {
                ui.colored_label(ui.visuals().error_fg_color, "Not shown:");
                ui.label(&problem.message);
                if let Some(help) = &problem.help {
                    ui.weak(help);
                }
                let close = ui.small_button("Close");
                name(&close, Role::Button, "Close the problem");
                if close.clicked() {
                    studio.problem = None;
                }
            });
            if let Some((line, text)) = &problem.line {
                ui.monospace(format!("{line} | {text}"));
            }
        }
        ui.horizontal(|ui| {
            if let Some(path) = studio.opening() {
                ui.spinner();
                ui.label(format!("Reading {}", path.file_name().unwrap_or_default().to_string_lossy()));
            } else if let Some(error) = studio.status.error.clone() {
                ui.colored_label(ui.visuals().error_fg_color, "Not rendered:");
                ui.label(error.message);
                if let Some(help) = error.help {
                    ui.weak(help);
                }
            } else if let Some(message) = studio.message.clone() {
                // A word says it, not only the colour.
                if message.is_error {
                    ui.colored_label(ui.visuals().error_fg_color, "Error:");
                }
                ui.label(&message.text);
                if let Some(help) = &message.help {
                    ui.weak(help);
                }
                let close = ui.small_button("×").on_hover_text("Close the message");
                name(&close, Role::Button, "Close the message");
                if close.clicked() {
                    studio.message = None;
                }
            } else {
                ui.weak(
                    "Drag to look around, wheel to move nearer, click to select. Ctrl K finds every command.",
                );
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.weak(studio.status.doing);
            });
        });
    }

    /// Asks about unsaved changes before the window closes.
    fn close(&mut self, ctx: &egui::Context) {
        if self.studio.quit {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        if ctx.input(|i| i.viewport().close_requested()) {
            self.studio.leave(After::Quit);
            if !self.studio.quit {
                ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            }
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.show(ui);
        let title = self.studio.document.name();
        let changed = if self.studio.document.is_changed() { "*" } else { "" };
        let title = format!("{title}{changed} - Turner Studio");
        if self.shown.1 != title {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.shown.1 = title;
        }
    }

    fn on_exit(&mut self, _: Option<&eframe::glow::Context>) {
        self.studio.close();
    }
}

/// An action as an entry of a menu.
fn item(ui: &mut Ui, action: Action, studio: &mut Studio) {
    let mut button = Button::new(action.label());
    if let Some(shortcut) = action.shortcut() {
        button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
    }
    if ui.add_enabled(action.is_possible(studio), button).clicked() {
        studio.queue.push(action);
        ui.close();
    }
}

/// Runs the actions whose shortcuts are pressed. Keys without Ctrl belong to the text field that has the focus, and to a
/// menu or a list that is open: Escape closes it.
fn shortcuts(ctx: &egui::Context, studio: &mut Studio) {
    let writes = ctx.egui_wants_keyboard_input() || Popup::is_any_open(ctx);
    let has_dialog = studio.dialog.is_some() || studio.viewport.palette.is_some();
    let flies = ctx.input(|i| i.pointer.secondary_down());
    if !writes && !has_dialog {
        let events = ctx.input(|i| i.events.clone());
        for event in events {
            match event {
                egui::Event::Copy => studio.queue.push(Action::Copy),
                egui::Event::Paste(text) => studio.paste(&text),
                _ => {}
            }
        }
    }
    let mut all: Vec<(Action, egui::KeyboardShortcut)> =
        Action::all().into_iter().filter_map(|action| Some((action, action.shortcut()?))).collect();
    // A shortcut takes its keys with Shift as well, since some keyboards need Shift for plus: those with Shift come first.
    all.sort_by_key(|(_, shortcut)| !shortcut.modifiers.shift);
    for (action, shortcut) in all {
        let plain = shortcut.modifiers.is_none();
        if plain && (writes || flies) || has_dialog {
            continue;
        }
        if ctx.input_mut(|i| i.consume_shortcut(&shortcut)) {
            studio.queue.push(action);
        }
    }
}
