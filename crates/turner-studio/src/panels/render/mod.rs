//! Renders to files: a form, and the jobs with their progress.

mod form;

use std::path::Path;

use egui::{ColorImage, Id, ProgressBar, TextureHandle, TextureOptions, Ui, WidgetInfo};

use crate::jobs::{Job, State};
use crate::studio::Studio;
use crate::widgets::{name, name_switch};

/// What a click in the list asks for.
enum Wish {
    Stop,
    Resume,
    Remove,
    Shift(isize),
    Peek,
    Folder,
}

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        form::show(ui, studio);
        ui.separator();
        let mut both = studio.jobs.with_view;
        let response = ui.checkbox(&mut both, "Render the view meanwhile, with half of the threads");
        name_switch(&response, "Render the view meanwhile", both);
        studio.jobs.with_view = both;
        if studio.jobs.held && studio.jobs.jobs().iter().any(|job| job.report().state == State::Waiting) {
            ui.label("The queue waits.");
            if ui.button("Continue the queue").clicked() {
                studio.jobs.held = false;
            }
        }
        let mut wishes = Vec::new();
        for job in studio.jobs.jobs() {
            ui.push_id(job.id, |ui| entry(ui, job, &mut wishes));
        }
        if studio.jobs.is_running() {
            // Time passes between events.
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(500));
        }
        for (id, wish) in wishes {
            grant(studio, id, wish);
        }
    });
}

fn grant(studio: &mut Studio, id: u64, wish: Wish) {
    match wish {
        Wish::Stop => studio.jobs.stop(id),
        Wish::Resume => studio.jobs.resume(id),
        Wish::Remove => studio.jobs.remove(id),
        Wish::Shift(by) => studio.jobs.shift(id, by),
        Wish::Peek => studio.jobs.peek(id),
        Wish::Folder => {
            let job = studio.jobs.jobs().iter().find(|job| job.id == id);
            let folder = job.and_then(|job| job.spec.output.parent()).map(Path::to_owned);
            if let Some(folder) = folder
                && let Err(error) = open_folder(&folder)
            {
                studio.say(format!("{} cannot be opened: {error}", folder.display()));
            }
        }
    }
}

/// Shows a folder in the system's file manager.
fn open_folder(folder: &Path) -> std::io::Result<()> {
    let program = match () {
        () if cfg!(windows) => "explorer",
        () if cfg!(target_os = "macos") => "open",
        () => "xdg-open",
    };
    let mut child = std::process::Command::new(program).arg(folder).spawn()?;
    // It is waited for, so that the system forgets it.
    std::thread::Builder::new().name("folder".into()).spawn(move || child.wait())?;
    Ok(())
}

fn entry(ui: &mut Ui, job: &Job, wishes: &mut Vec<(u64, Wish)>) {
    let report = job.report();
    let file = job.spec.output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| {
        ui.strong(&file).on_hover_text(job.spec.output.display().to_string());
        ui.weak(format!("{}, {}", job.title, report.state.word()));
    });
    let pictures = job.spec.pictures();
    if report.state.is_running() || report.state == State::Stopped {
        let fraction = report.fraction(pictures);
        // Rounded down: 100 % means complete.
        let percent = format!("{} %", (100.0 * fraction).floor());
        let bar = ui.add(ProgressBar::new(fraction as f32).text(percent.clone()));
        bar.widget_info(|| {
            WidgetInfo::labeled(egui::Role::ProgressIndicator, true, format!("{file}: {percent}"))
        });
        let mut words = Vec::new();
        if pictures > 1 {
            words.push(format!("picture {} of {pictures}", (report.picture + 1).min(pictures)));
        }
        if report.samples > 0.0 {
            words.push(format!("{:.0} samples", report.samples));
        }
        words.extend(report.noise.map(|noise| format!("noise {:.1} %", 100.0 * noise)));
        if report.state == State::Rendering {
            let left = report.seconds_left(pictures);
            words.push(left.map_or("time left unknown".to_owned(), |s| format!("{} left", duration(s))));
        }
        ui.label(words.join(", "));
    }
    if let Some(error) = &report.error {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
    for warning in report.warnings.iter().take(3) {
        ui.weak(warning);
    }
    ui.horizontal_wrapped(|ui| {
        let mut button = |ui: &mut Ui, text: &str, wish: Wish| {
            let response = ui.small_button(text);
            name(&response, egui::Role::Button, &format!("{text} {file}"));
            if response.clicked() {
                wishes.push((job.id, wish));
            }
        };
        match report.state {
            State::Preparing | State::Rendering => button(ui, "Stop", Wish::Stop),
            State::Stopping => {}
            State::Waiting => {
                button(ui, "Earlier", Wish::Shift(-1));
                button(ui, "Later", Wish::Shift(1));
                button(ui, "Remove", Wish::Remove);
            }
            State::Stopped | State::Failed => {
                let text = if job.spec.checkpoint { "Resume" } else { "Again" };
                button(ui, text, Wish::Resume);
                button(ui, "Remove", Wish::Remove);
            }
            State::Done => button(ui, "Remove", Wish::Remove),
        }
        if job.checkpoint().is_some() && report.state != State::Done {
            button(ui, "Show the picture so far", Wish::Peek);
        }
        if report.written.is_some() {
            button(ui, "Open the folder", Wish::Folder);
        }
    });
    peek(ui, job, &file);
}

/// The picture of a checkpoint.
fn peek(ui: &mut Ui, job: &Job, file: &str) {
    let Some(peek) = job.peek() else { return };
    if let Some(error) = &peek.error {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
    let Some((picture, samples)) = &peek.picture else { return };
    ui.weak(format!("{samples:.1} samples per pixel; noise is not removed"));
    let key = Id::unique(("checkpoint", job.id));
    let known = std::sync::Arc::as_ptr(picture) as usize;
    let kept: Option<(TextureHandle, usize)> = ui.data(|data| data.get_temp(key));
    let texture = match kept {
        Some((texture, of)) if of == known => texture,
        _ => {
            let size = [picture.width as usize, picture.height as usize];
            let image = ColorImage::from_rgba_unmultiplied(size, picture.display.as_flattened());
            let texture = ui.ctx().load_texture("checkpoint", image, TextureOptions::LINEAR);
            ui.data_mut(|data| data.insert_temp(key, (texture.clone(), known)));
            texture
        }
    };
    let response = ui.add(egui::Image::new(&texture).max_width(ui.available_width()));
    name(&response, egui::Role::Image, &format!("Picture so far of {file}"));
}

/// `40 s`, `3 min`, `2 h 10 min`.
fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        _ if minutes < 90 => format!("{minutes} min"),
        _ => format!("{} h {} min", minutes / 60, minutes % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_rounded() {
        assert_eq!([12.4, 100.0, 7800.0].map(duration), ["12 s", "2 min", "2 h 10 min"]);
    }
}
