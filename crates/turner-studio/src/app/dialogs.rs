//! Questions: unsaved changes, names of files, recovered work.

mod rename;

use std::path::{Path, PathBuf};

use egui::{Id, Key, Modal, Ui};
use turner_live::document::{Document, readable};

use crate::studio::{After, Dialog, Purpose, Studio};
use crate::task::Task;
use crate::widgets::name_text;

/// Entries of a folder that are listed.
const MOST: usize = 500;

pub(super) fn show(ctx: &egui::Context, studio: &mut Studio) {
    if let Some(task) = &studio.asking
        && let Some(answer) = task.poll()
    {
        studio.asking = None;
        if let Ok(Some((purpose, path))) = answer {
            studio.dialog = None;
            studio.chosen(purpose, &path);
        }
    }
    let Some(dialog) = studio.dialog.take() else { return };
    let mut next = Some(dialog);
    let closed = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
        ui.set_width(460.0);
        let dialog = next.take();
        next = match dialog {
            Some(Dialog::Unsaved(after)) => unsaved(ui, studio, after),
            Some(Dialog::File { purpose, name }) => file(ui, studio, purpose, name),
            Some(Dialog::Recovered(found)) => recovered(ui, studio, found),
            Some(Dialog::Jobs) => jobs(ui, studio),
            Some(Dialog::Rename { node, name, fault }) => rename::show(ui, studio, node, name, fault),
            None => None,
        };
    });
    // A dialog that an answer opened stays.
    if studio.dialog.is_none() && !closed.should_close() {
        studio.dialog = next;
    }
}

fn unsaved(ui: &mut Ui, studio: &mut Studio, after: After) -> Option<Dialog> {
    ui.heading("Save the changes?");
    ui.label(format!("{} has changes that are not saved.", studio.document.name()));
    ui.add_space(8.0);
    let mut done = false;
    ui.horizontal(|ui| {
        if ui.button("Save").clicked() {
            studio.save(Some(after.clone()));
            done = true;
        }
        if ui.button("Don't save").clicked() {
            studio.proceed(after.clone());
            done = true;
        }
        if ui.button("Cancel").clicked() {
            done = true;
        }
    });
    (!done).then_some(Dialog::Unsaved(after))
}

/// Renders that run end with the window: nothing would show how far they are, and nothing would start those that wait.
fn jobs(ui: &mut Ui, studio: &mut Studio) -> Option<Dialog> {
    ui.heading("Stop the renders?");
    ui.label("A render runs or waits. Closing the window stops it: its file keeps the picture so far.");
    ui.add_space(8.0);
    let mut done = false;
    ui.horizontal(|ui| {
        if ui.button("Stop and close").clicked() {
            studio.jobs.hold();
            studio.leave(After::Quit);
            done = true;
        }
        if ui.button("Keep rendering").clicked() {
            done = true;
        }
    });
    (!done).then_some(Dialog::Jobs)
}

/// The folder and the entries to choose from: folders first, then files that Turner reads.
fn entries(folder: &Path, all: bool) -> Vec<(String, PathBuf, bool)> {
    let mut list: Vec<(String, PathBuf, bool)> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .take(MOST)
        .filter_map(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = entry.path();
            let is_folder = path.is_dir();
            (!name.starts_with('.') && (is_folder || all || readable(&path)))
                .then_some((name, path, is_folder))
        })
        .collect();
    list.sort_by_key(|(name, _, is_folder)| (!is_folder, name.to_lowercase()));
    list
}

fn file(ui: &mut Ui, studio: &mut Studio, purpose: Purpose, mut name: String) -> Option<Dialog> {
    let (title, verb, save) = match purpose {
        Purpose::Open => ("Open a scene or a model", "Open", false),
        Purpose::Save => ("Save the scene as", "Save", true),
        Purpose::Model => ("Add a model file", "Add", false),
        Purpose::Picture => ("Save the picture as", "Save", true),
        Purpose::Key(..) => ("Choose a file", "Choose", false),
    };
    ui.heading(title);
    let field = egui::TextEdit::singleline(&mut name).desired_width(f32::INFINITY);
    let response = ui.add(field);
    name_text(&response, "File name", &name);
    let enter = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    // The keyboard writes the name at once.
    if !enter && ui.memory(|memory| memory.focused().is_none()) {
        response.request_focus();
    }
    let path = PathBuf::from(&name);
    let folder =
        if path.is_dir() { path.clone() } else { path.parent().map(Path::to_owned).unwrap_or_default() };
    let mut done = false;
    let mut chosen = None;
    egui::ScrollArea::vertical().max_height(260.0).auto_shrink([false, true]).show(ui, |ui| {
        if let Some(parent) = folder.parent()
            && ui.selectable_label(false, "..").clicked()
        {
            chosen = Some((parent.to_owned(), true));
        }
        let all = matches!(purpose, Purpose::Key(..) | Purpose::Picture);
        for (shown, path, is_folder) in entries(&folder, all) {
            let text = if is_folder { format!("{shown}{}", std::path::MAIN_SEPARATOR) } else { shown };
            let response = ui.selectable_label(false, text);
            if response.clicked() {
                chosen = Some((path.clone(), is_folder));
            }
            if response.double_clicked() && !is_folder && !save {
                studio.chosen(purpose.clone(), &path);
                done = true;
            }
        }
    });
    if let Some((path, is_folder)) = chosen {
        let file = if save { Path::new(&name).file_name().map(|f| f.to_owned()) } else { None };
        name = match (is_folder, file) {
            (true, Some(file)) => path.join(file).to_string_lossy().into_owned(),
            (true, None) => format!("{}{}", path.display(), std::path::MAIN_SEPARATOR),
            (false, _) => path.to_string_lossy().into_owned(),
        };
    }
    let path = PathBuf::from(&name);
    let target = if purpose == Purpose::Save { path.with_extension("toml") } else { path.clone() };
    let exists = save && target.is_file() && Some(path.as_path()) != studio.document.path();
    if exists {
        ui.colored_label(ui.visuals().warn_fg_color, "A file of this name exists. It will be replaced.");
    }
    ui.horizontal(|ui| {
        if ui.button("System dialog…").on_hover_text("The file dialog of your desktop").clicked() {
            system(ui.ctx(), studio, &purpose, &folder);
        }
        let possible = !name.is_empty() && !path.is_dir();
        let button = ui.add_enabled(possible, egui::Button::new(verb));
        if (button.clicked() || enter) && possible {
            studio.chosen(purpose.clone(), &path);
            done = true;
        }
        if ui.button("Cancel").clicked() {
            studio.take_after_save();
            done = true;
        }
    });
    (!done).then_some(Dialog::File { purpose, name })
}

/// Asks with the dialog of the desktop, in a thread: the window continues.
fn system(ctx: &egui::Context, studio: &mut Studio, purpose: &Purpose, folder: &Path) {
    let (purpose, folder) = (purpose.clone(), folder.to_owned());
    studio.asking = Some(Task::start(ctx, move |_| {
        let dialog = rfd::FileDialog::new().set_directory(folder);
        let path = match purpose {
            Purpose::Save => dialog.set_file_name("untitled.toml").save_file(),
            Purpose::Picture => dialog.set_file_name("picture.png").save_file(),
            Purpose::Open | Purpose::Model | Purpose::Key(..) => dialog.pick_file(),
        };
        path.map(|path| (purpose, path))
    }));
}

fn recovered(
    ui: &mut Ui,
    studio: &mut Studio,
    found: Vec<turner_live::document::Recovered>,
) -> Option<Dialog> {
    ui.heading("Unsaved work was found");
    ui.label("An earlier session ended without saving. Open what it kept?");
    let mut rest = found.clone();
    for (i, work) in found.iter().enumerate() {
        ui.horizontal(|ui| {
            ui.strong(&work.name);
            if ui.button("Open").clicked() {
                match Document::open(&work.scene) {
                    Ok(document) => studio.show(document.recovered(work)),
                    Err(error) => studio.problem = Some(error),
                }
                rest.clear();
            }
            if ui.button("Discard").clicked() && i < rest.len() {
                work.discard();
                rest.retain(|other| other.scene != work.scene);
            }
        });
    }
    let later = ui.button("Later").clicked();
    (!rest.is_empty() && !later).then_some(Dialog::Recovered(rest))
}
