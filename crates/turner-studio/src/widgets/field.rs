//! A key of the scene format as a row of a form, made from the schema: its type chooses the widget, its range limits it,
//! its documentation is the tooltip.

use egui::{ComboBox, DragValue, TextEdit, Ui};
use turner::color::Transfer;
use turner::schema::value::{Data, Table, Value};
use turner::schema::{Field, Range};

use super::kind::{Kind, numbers as array};
use super::{color, compound, entry, name_number, name_switch, name_text, start};

/// What a row asks for.
pub(crate) enum Change {
    /// A new value.
    Set(Data),
    /// Remove the key, so that it has its default.
    Unset,
    /// Choose a file for the key; with `true`, a picture that becomes a texture.
    File(bool),
    /// Select the part of this name: a texture, material or medium.
    Follow(&'static str, String),
}

/// What rows know of the scene.
pub(crate) struct Around<'a> {
    /// Names of textures.
    pub(crate) textures: &'a [String],
    /// Names of materials.
    pub(crate) materials: &'a [String],
    /// Names of media.
    pub(crate) media: &'a [String],
    /// Names of groups.
    pub(crate) groups: &'a [String],
    /// Whether colours are display values.
    pub(crate) encoded: bool,
    /// Columns and rows of the film.
    pub(crate) film: [u32; 2],
    /// Whether the part is a directional light.
    pub(crate) is_directional: bool,
    /// The keys of the part.
    pub(crate) part: &'a Table,
    /// Defaults that depend on other parts of the scene.
    pub(crate) defaults: &'a [(&'static str, Data)],
}

impl Around<'_> {
    /// The names of all parts of a kind.
    pub(crate) fn names(&self, part: &str) -> Vec<String> {
        match part {
            "material" => self.materials,
            "medium" => self.media,
            "group" => self.groups,
            _ => self.textures,
        }
        .to_vec()
    }
}

/// Shows name and value of a key in a grid of two columns.
pub(crate) fn row(ui: &mut Ui, field: &Field, value: Option<&Data>, around: &Around<'_>) -> Option<Change> {
    let doc = field.doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
    let own = around.defaults.iter().find(|(name, _)| *name == field.name).map(|(_, data)| data);
    let default = own.map(shown_default).or_else(|| field.default.map(|default| default()));
    let hover = match &default {
        Some(default) => format!("{doc}\n\nDefault: {default}"),
        None => doc,
    };
    let label = ui.label(field.name.replace('_', " ")).on_hover_text(&hover);
    let standard = own.cloned().or_else(|| default.as_deref().and_then(parse));
    let mut change = None;
    let show = |ui: &mut Ui| {
        change = widget(ui, field, value, standard.as_ref(), around);
        if value.is_some() && field.default.is_some() {
            let reset =
                ui.small_button("Reset").on_hover_text(format!("Back to the default of {}", field.name));
            super::name(&reset, egui::Role::Button, &format!("Default of {}", field.name));
            if reset.clicked() {
                change = Some(Change::Unset);
            }
        }
    };
    // Values of several lines begin at the upper edge of their row.
    match Kind::of(field).has_lines() {
        true => ui.horizontal_top(show),
        false => ui.horizontal(show),
    };
    let _ = label;
    ui.end_row();
    change
}

/// A default as a scene has it.
fn shown_default(data: &Data) -> String {
    match data {
        Data::String(word) => format!("\"{word}\""),
        Data::Integer(i) => i.to_string(),
        _ => "a value".to_owned(),
    }
}

/// A default as the documentation shows it.
fn parse(text: &str) -> Option<Data> {
    match text {
        "none" => None,
        "true" => Some(Data::Bool(true)),
        "false" => Some(Data::Bool(false)),
        _ => {
            if let Some(inner) = text.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
                let items = inner.split(',').map(|item| parse(item.trim()).map(Value::new));
                return items.collect::<Option<Vec<Value>>>().map(Data::Array);
            }
            if let Some(word) = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')) {
                return Some(Data::String(word.to_owned()));
            }
            text.parse::<i64>().map(Data::Integer).or(text.parse().map(Data::Number)).ok()
        }
    }
}

pub(crate) fn number(data: &Data) -> Option<f64> {
    match data {
        Data::Integer(i) => Some(*i as f64),
        Data::Number(v) => Some(*v),
        _ => None,
    }
}

pub(crate) fn numbers(data: &Data) -> Option<Vec<f64>> {
    let Data::Array(items) = data else { return None };
    items.iter().map(|item| number(&item.data)).collect()
}

fn widget(
    ui: &mut Ui,
    field: &Field,
    value: Option<&Data>,
    standard: Option<&Data>,
    around: &Around<'_>,
) -> Option<Change> {
    let kind = (field.kind)();
    let shown = value.or(standard);
    let words = (field.words)();
    if !words.is_empty() && !kind.contains('[') {
        return word(ui, field, shown, words);
    }
    match kind.as_str() {
        "true | false" => switch(ui, field.name, shown).map(Change::Set),
        "number" | "integer" => scalar(ui, field, shown, kind == "integer"),
        "color" => colour(ui, field.name, field.range, shown, around).map(Change::Set),
        "color | texture" => source(ui, field.name, field.range, shown, true, around),
        "material" => reference(ui, field, shown, "material", around.materials),
        "medium" => reference(ui, field, shown, "medium", around.media),
        // The name of a file is no file until its last letter.
        "\"text\"" if field.name != "file" => text(ui, field.name, shown).map(|now| match now.is_empty() {
            true => Change::Unset,
            false => Change::Set(Data::String(now)),
        }),
        "\"text\"" | "\"image file\"" | "\"IES file\"" | "\"BSDF file\"" | "\"grid file\""
        | "\"font file\"" => {
            let name = if let Some(Data::String(name)) = shown { name.clone() } else { "none".into() };
            let button = ui.button(name).on_hover_text("Choose a file");
            super::name(&button, egui::Role::Button, field.name);
            button.clicked().then_some(Change::File(false))
        }
        "group" => reference(ui, field, shown, "group", around.groups),
        _ => compound::show(ui, field, shown, around),
    }
}

/// A row for a text that has its effect once it is written: with Enter, or when the keyboard leaves it.
pub(crate) fn written(ui: &mut Ui, field: &Field, value: Option<&Data>) -> Option<Change> {
    let doc = field.doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
    ui.label(field.name.replace('_', " ")).on_hover_text(doc);
    let own = if let Some(Data::String(text)) = value { text.as_str() } else { "" };
    let id = ui.scope_id().with((field.name, "written"));
    let mut now: String = ui.data(|d| d.get_temp(id)).unwrap_or_else(|| own.to_owned());
    let response = ui.add(TextEdit::singleline(&mut now).desired_width(140.0));
    name_text(&response, field.name, &now);
    ui.end_row();
    if response.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, now));
        return None;
    }
    ui.data_mut(|d| d.remove::<String>(id));
    let is_new = response.lost_focus() && now != own;
    is_new.then_some(if now.is_empty() { Change::Unset } else { Change::Set(Data::String(now)) })
}

/// A key without a value. A click gives it one.
pub(crate) fn automatic(ui: &mut Ui, field: &Field, start: impl FnOnce() -> Option<Data>) -> Option<Change> {
    let button = ui.button("automatic").on_hover_text("Choose a value");
    super::name(&button, egui::Role::Button, field.name);
    button.clicked().then(start).flatten().map(Change::Set)
}

fn scalar(ui: &mut Ui, field: &Field, shown: Option<&Data>, whole: bool) -> Option<Change> {
    match shown.and_then(number) {
        Some(v) => number_box(ui, field.name, field.range, v, whole).map(Change::Set),
        None => automatic(ui, field, || Some(start::scalar(field, whole))),
    }
}

/// A number within a range.
pub(crate) fn number_box(
    ui: &mut Ui,
    name: &str,
    range: Option<Range>,
    mut v: f64,
    whole: bool,
) -> Option<Data> {
    let Range { min, open_min, max, .. } = range.unwrap_or(Range::FINITE);
    // An excluded end is approached, not reached.
    let low = if open_min { min + 1e-6 } else { min };
    let narrow = max - min <= 1000.0;
    let speed = if whole {
        0.2
    } else if narrow {
        ((max - min) * 0.002).max(1e-4)
    } else {
        (v.abs() * 0.01).max(0.005)
    };
    let drag = DragValue::new(&mut v).range(low..=max).speed(speed).max_decimals(if whole { 0 } else { 5 });
    let response = ui.add(drag);
    name_number(&response, name, v);
    let data = if whole { Data::Integer(v.round() as i64) } else { Data::Number(v) };
    response.changed().then_some(data)
}

/// true or false.
pub(crate) fn switch(ui: &mut Ui, name: &str, shown: Option<&Data>) -> Option<Data> {
    let mut on = matches!(shown, Some(Data::Bool(true)));
    let response = ui.checkbox(&mut on, "");
    name_switch(&response, name, on);
    response.changed().then_some(Data::Bool(on))
}

fn word(
    ui: &mut Ui,
    field: &Field,
    shown: Option<&Data>,
    words: &[(&'static str, &'static str)],
) -> Option<Change> {
    let now = if let Some(Data::String(word)) = shown { word.as_str() } else { "automatic" };
    let mut chosen = None;
    let combo = ComboBox::from_id_salt(field.name).selected_text(now).show_ui(ui, |ui| {
        for (word, meaning) in words {
            let response = entry(ui, now == *word, *word).on_hover_text(*meaning);
            if response.clicked() && now != *word {
                chosen = Some(Change::Set(Data::String((*word).to_owned())));
            }
        }
    });
    super::name(&combo.response, egui::Role::ComboBox, field.name);
    chosen
}

pub(crate) fn colour(
    ui: &mut Ui,
    name: &str,
    range: Option<Range>,
    shown: Option<&Data>,
    around: &Around<'_>,
) -> Option<Data> {
    let mut rgb = match shown {
        Some(Data::Array(_)) => <[f64; 3]>::try_from(shown.and_then(numbers)?).ok()?,
        Some(data) => [number(data)?; 3],
        None => [0.0; 3],
    };
    let label = name.replace('_', " ");
    color::edit(ui, &mut rgb, around.encoded, range, &label).then(|| array(rgb))
}

/// A colour that is written as `#rrggbb`, as numbers.
fn display_color(data: &Data, encoded: bool) -> Option<Data> {
    let Data::String(text) = data else { return None };
    let rgb = u32::from_str_radix(text.strip_prefix('#').filter(|hex| hex.len() == 6)?, 16).ok()?;
    let [_, r, g, b] = rgb.to_be_bytes().map(|byte| f32::from(byte) / 255.0);
    let transfer = if encoded { Transfer::None } else { Transfer::Srgb };
    Some(array([r, g, b].map(|v| f64::from(transfer.decode(v)))))
}

/// A colour or a texture; with `files`, also a picture that becomes one.
pub(crate) fn source(
    ui: &mut Ui,
    name: &str,
    range: Option<Range>,
    shown: Option<&Data>,
    files: bool,
    around: &Around<'_>,
) -> Option<Change> {
    let mut change = None;
    let hex = shown.and_then(|data| display_color(data, around.encoded));
    let shown = hex.as_ref().or(shown);
    let texture = if let Some(Data::String(name)) = shown { Some(name.as_str()) } else { None };
    match texture {
        Some(texture) => {
            let button = ui.button(texture).on_hover_text("Show the texture");
            super::name(&button, egui::Role::Button, name);
            if button.clicked() {
                change = Some(Change::Follow("texture", texture.to_owned()));
            }
        }
        None => change = colour(ui, name, range, shown, around).map(Change::Set),
    }
    change.or(instead(ui, name, texture, texture.is_none(), files, [0.5; 3], around))
}

/// A list of what a colour or texture may be instead: a colour, which begins as `start`, or a texture.
pub(crate) fn instead(
    ui: &mut Ui,
    name: &str,
    texture: Option<&str>,
    is_color: bool,
    files: bool,
    start: [f64; 3],
    around: &Around<'_>,
) -> Option<Change> {
    let mut change = None;
    let combo = ComboBox::from_id_salt((name, "texture")).selected_text("").width(20.0).show_ui(ui, |ui| {
        if entry(ui, is_color, "colour").clicked() && !is_color {
            change = Some(Change::Set(array(start)));
        }
        for other in around.textures {
            if entry(ui, texture == Some(other), other).clicked() {
                change = Some(Change::Set(Data::String(other.clone())));
            }
        }
        if files && entry(ui, false, "image file…").clicked() {
            change = Some(Change::File(true));
        }
    });
    super::name(&combo.response, egui::Role::ComboBox, &format!("{name} texture"));
    change
}

/// A part of the scene by its name.
pub(crate) fn reference(
    ui: &mut Ui,
    field: &Field,
    shown: Option<&Data>,
    kind: &'static str,
    names: &[String],
) -> Option<Change> {
    let now = if let Some(Data::String(name)) = shown { Some(name.as_str()) } else { None };
    let mut change = None;
    let combo = ComboBox::from_id_salt(field.name).selected_text(now.unwrap_or("none")).show_ui(ui, |ui| {
        if entry(ui, now.is_none(), "none").clicked() && now.is_some() {
            change = Some(Change::Unset);
        }
        for name in names {
            if entry(ui, now == Some(name), name).clicked() && now != Some(name) {
                change = Some(Change::Set(Data::String(name.clone())));
            }
        }
    });
    super::name(&combo.response, egui::Role::ComboBox, field.name);
    if let Some(name) = now
        && kind != "group"
        && ui.small_button("Show").on_hover_text(format!("Show the {kind}")).clicked()
    {
        change = Some(Change::Follow(kind, name.to_owned()));
    }
    change
}

/// A text. Returns the new one.
pub(crate) fn text(ui: &mut Ui, name: &str, shown: Option<&Data>) -> Option<String> {
    let mut now = if let Some(Data::String(text)) = shown { text.clone() } else { String::new() };
    let response = ui.add(TextEdit::singleline(&mut now).desired_width(140.0));
    name_text(&response, name, &now);
    response.changed().then_some(now)
}
