//! What is rendered next.

use std::path::{Path, PathBuf};

use egui::{ComboBox, DragValue, Grid, Id, Role, TextEdit, Ui};
use turner::film::Denoise;

use crate::jobs::{End, Sequence, Spec};
use crate::studio::Studio;
use crate::widgets::{entry, name, name_number, name_switch, name_text};

/// The form between frames. Values of choices that are not chosen stay.
#[derive(Clone)]
struct Form {
    /// `None` for the name that the scene suggests.
    output: Option<String>,
    end: usize,
    samples: u32,
    minutes: f64,
    percent: f64,
    own_size: bool,
    size: [u32; 2],
    denoise: Option<&'static str>,
    checkpoint: bool,
    sequence: usize,
    frames: [u32; 2],
    fps: f64,
    turns: u32,
    nice: bool,
}

impl Default for Form {
    fn default() -> Form {
        Form {
            output: None,
            end: 0,
            samples: 256,
            minutes: 5.0,
            percent: 2.0,
            own_size: false,
            size: [1920, 1080],
            denoise: None,
            checkpoint: true,
            sequence: 0,
            frames: [0, 47],
            fps: 24.0,
            turns: 36,
            nice: true,
        }
    }
}

const ENDS: [&str; 4] = ["the scene's samples", "samples", "time", "noise"];
const SEQUENCES: [&str; 3] = ["one picture", "frames", "turntable"];

impl Form {
    fn spec(&self, suggested: &str, folder: &Path) -> Spec {
        let output = self.output.as_deref().unwrap_or(suggested);
        Spec {
            output: folder.join(output),
            end: match self.end {
                1 => End::Samples(self.samples),
                2 => End::Seconds(60.0 * self.minutes),
                3 => End::Noise(self.percent / 100.0),
                _ => End::Scene,
            },
            size: self.own_size.then_some(self.size),
            denoise: self.denoise,
            checkpoint: self.checkpoint,
            sequence: match self.sequence {
                1 => Sequence::Frames(self.frames[0], self.frames[1], self.fps),
                2 => Sequence::Turntable(self.turns),
                _ => Sequence::Single,
            },
            nice: self.nice,
        }
    }
}

pub(super) fn show(ui: &mut Ui, studio: &mut Studio) {
    let key = Id::unique("render form");
    let mut form: Form = ui.data(|data| data.get_temp(key)).unwrap_or_default();
    let stem = PathBuf::from(studio.document.name());
    let stem = stem.file_stem().unwrap_or_default().to_string_lossy().replace(['/', '\\', ':'], "-");
    let suggested = format!("{stem}.png");
    let folder = std::path::absolute(studio.document.folder()).unwrap_or_default();
    Grid::new("render form").num_columns(2).show(ui, |ui| {
        rows(
            ui,
            &mut form,
            &suggested,
            studio.document.desc().film.width,
            studio.document.desc().film.height,
        );
    });
    let spec = form.spec(&suggested, &folder);
    let problem = spec.problem();
    match problem {
        Some(problem) => drop(ui.colored_label(ui.visuals().warn_fg_color, problem)),
        None if spec.output.exists() => {
            ui.colored_label(ui.visuals().warn_fg_color, "A file of this name exists. It will be replaced.");
        }
        None => {}
    }
    if ui.add_enabled(problem.is_none(), egui::Button::new("Add to the queue")).clicked() {
        let title = studio.document.name();
        let desc = studio.document.desc().clone();
        studio.jobs.add(desc, title, spec);
    }
    ui.data_mut(|data| data.insert_temp(key, form));
}

fn rows(ui: &mut Ui, form: &mut Form, suggested: &str, width: u32, height: u32) {
    ui.label("File").on_hover_text("PNG, EXR, JPEG, WebP, HDR; of sequences also GIF, WebP, MP4, WebM");
    let mut output = form.output.clone().unwrap_or_else(|| suggested.to_owned());
    let response = ui.add(TextEdit::singleline(&mut output).desired_width(180.0));
    name_text(&response, "Render to", &output);
    if response.changed() {
        form.output = Some(output).filter(|output| !output.is_empty());
    }
    ui.end_row();
    ui.label("Until");
    ui.horizontal(|ui| {
        choice(ui, "Render until", &ENDS, &mut form.end);
        match form.end {
            1 => number(ui, "Samples per pixel", &mut form.samples, 1..=1 << 20, ""),
            2 => number(ui, "Minutes", &mut form.minutes, 0.05..=1e4, " min"),
            3 => number(ui, "Noise in percent", &mut form.percent, 0.05..=100.0, " %"),
            _ => {}
        }
    });
    ui.end_row();
    ui.label("Size");
    ui.horizontal(|ui| {
        let text = if form.own_size { String::new() } else { format!("other than {width} × {height}") };
        let response = ui.checkbox(&mut form.own_size, text);
        name_switch(&response, "Another size", form.own_size);
        if form.own_size {
            number(ui, "Width", &mut form.size[0], 1..=65536, "");
            number(ui, "Height", &mut form.size[1], 1..=65536, "");
        }
    });
    ui.end_row();
    ui.label("Noise removal");
    let words = Denoise::WORDS.iter().map(|word| (Some(*word), *word));
    let combo = ComboBox::from_id_salt("denoise").selected_text(form.denoise.unwrap_or("as in the scene"));
    let combo = combo.show_ui(ui, |ui| {
        for (value, text) in std::iter::once((None, "as in the scene")).chain(words) {
            if entry(ui, form.denoise == value, text).clicked() {
                form.denoise = value;
            }
        }
    });
    name(&combo.response, Role::ComboBox, "Noise removal");
    ui.end_row();
    ui.label("Pictures");
    ui.horizontal(|ui| {
        choice(ui, "Pictures", &SEQUENCES, &mut form.sequence);
        match form.sequence {
            1 => {
                number(ui, "First frame", &mut form.frames[0], 0..=99_999, "");
                number(ui, "Last frame", &mut form.frames[1], 0..=99_999, "");
                number(ui, "Frames per second", &mut form.fps, 1.0..=240.0, " fps");
            }
            2 => number(ui, "Number of pictures", &mut form.turns, 1..=10_000, ""),
            _ => {}
        }
    });
    ui.end_row();
    ui.label("");
    let response = ui.checkbox(&mut form.checkpoint, "Can be stopped and resumed");
    name_switch(&response, "Can be stopped and resumed", form.checkpoint);
    ui.end_row();
    ui.label("");
    let response = ui.checkbox(&mut form.nice, "Programs in use come first");
    name_switch(&response, "Programs in use come first", form.nice);
    ui.end_row();
}

fn choice(ui: &mut Ui, label: &str, words: &[&str], chosen: &mut usize) {
    let combo = ComboBox::from_id_salt(label).selected_text(words[*chosen]).show_ui(ui, |ui| {
        for (i, word) in words.iter().enumerate() {
            if entry(ui, *chosen == i, *word).clicked() {
                *chosen = i;
            }
        }
    });
    name(&combo.response, Role::ComboBox, label);
}

fn number<N: egui::emath::Numeric>(
    ui: &mut Ui,
    label: &str,
    value: &mut N,
    range: std::ops::RangeInclusive<N>,
    unit: &str,
) {
    let response = ui.add(DragValue::new(value).range(range).suffix(unit).speed(0.5));
    name_number(&response, label, value.to_f64());
}
