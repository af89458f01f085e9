//! Values that consist of others: lists, tuples, tables by name, transforms, and values of one of several kinds.

use egui::{ComboBox, DragValue, TextEdit, Ui};
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::value::{Data, Table, Value};
use turner::schema::{Field, Range};

use super::field::Around;
use super::kind::{Kind, numbers};
use super::{color, name, name_number, name_switch, name_text, transform};

/// Items of a list that are shown at once.
const PAGE: usize = 12;

/// What all parts of a value have in common.
pub(crate) struct Form<'a> {
    pub(crate) around: &'a Around<'a>,
    pub(crate) range: Option<Range>,
}

impl Form<'_> {
    /// Shows a value and returns the new one, if it changes. `label` names its widgets.
    pub(crate) fn edit(&self, ui: &mut Ui, kind: &Kind, label: &str, data: &Data) -> Option<Data> {
        match kind {
            Kind::Switch => self.switch(ui, label, data),
            Kind::Number { whole } => self.number(ui, label, data, *whole),
            Kind::Text | Kind::File => self.text(ui, label, data),
            Kind::Color => self.color(ui, label, data),
            Kind::Source => self.source(ui, label, data),
            Kind::Part(part) => self.choice(ui, label, data, &self.around.names(part)),
            Kind::Word(words) => {
                let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
                self.choice(ui, label, data, &words)
            }
            Kind::Tuple(parts) => self.tuple(ui, parts, label, data),
            Kind::List(item) => match &**item {
                Kind::Word(words) => self.words(ui, words, label, data),
                item => self.list(ui, item, label, data),
            },
            Kind::ByName(item) => self.by_name(ui, item, label, data),
            Kind::Transform => edit_transform(ui, label, data),
            Kind::Literal(_) | Kind::False => None,
            Kind::OneOf(kinds) => self.one_of(ui, kinds, label, data),
        }
    }

    fn start(&self, kind: &Kind) -> Option<Data> {
        kind.start(&|part| self.around.names(part))
    }

    fn switch(&self, ui: &mut Ui, label: &str, data: &Data) -> Option<Data> {
        let mut on = matches!(data, Data::Bool(true));
        let response = ui.checkbox(&mut on, "");
        name_switch(&response, label, on);
        response.changed().then_some(Data::Bool(on))
    }

    fn number(&self, ui: &mut Ui, label: &str, data: &Data, whole: bool) -> Option<Data> {
        let mut v = as_number(data)?;
        let Range { min, max, .. } = self.range.unwrap_or(Range::FINITE);
        let speed = if whole { 0.2 } else { (v.abs() * 0.01).max(0.005) };
        let drag =
            DragValue::new(&mut v).range(min..=max).speed(speed).max_decimals(if whole { 0 } else { 4 });
        let response = ui.add(drag);
        name_number(&response, label, v);
        let data = if whole { Data::Integer(v.round() as i64) } else { Data::Number(v) };
        response.changed().then_some(data)
    }

    fn text(&self, ui: &mut Ui, label: &str, data: &Data) -> Option<Data> {
        let mut now = as_text(data).to_owned();
        let response = ui.add(TextEdit::singleline(&mut now).desired_width(120.0));
        name_text(&response, label, &now);
        (response.changed() && !now.is_empty()).then_some(Data::String(now))
    }

    fn color(&self, ui: &mut Ui, label: &str, data: &Data) -> Option<Data> {
        let mut rgb = as_color(data)?;
        color::edit(ui, &mut rgb, self.around.encoded, None, label).then(|| numbers(rgb))
    }

    /// A colour, or a texture by its name.
    fn source(&self, ui: &mut Ui, label: &str, data: &Data) -> Option<Data> {
        let mut change = if let Data::String(_) = data { None } else { self.color(ui, label, data) };
        let texture = as_text(data);
        let shown = if texture.is_empty() { "colour" } else { texture };
        let combo =
            ComboBox::from_id_salt((label, "source")).selected_text(shown).width(60.0).show_ui(ui, |ui| {
                if ui.selectable_label(texture.is_empty(), "colour").clicked() && !texture.is_empty() {
                    change = Some(numbers([0.5; 3]));
                }
                for name in self.around.textures {
                    if ui.selectable_label(texture == name, name).clicked() {
                        change = Some(Data::String(name.clone()));
                    }
                }
            });
        name(&combo.response, egui::Role::ComboBox, &format!("{label} texture"));
        change
    }

    fn choice(&self, ui: &mut Ui, label: &str, data: &Data, words: &[String]) -> Option<Data> {
        let now = as_text(data);
        let mut chosen = None;
        let shown = if now.is_empty() { "none" } else { now };
        let combo = ComboBox::from_id_salt(label).selected_text(shown).show_ui(ui, |ui| {
            for word in words {
                if ui.selectable_label(now == word, word).clicked() && now != word {
                    chosen = Some(Data::String(word.clone()));
                }
            }
        });
        name(&combo.response, egui::Role::ComboBox, label);
        chosen
    }

    fn tuple(&self, ui: &mut Ui, parts: &[(String, Kind)], label: &str, data: &Data) -> Option<Data> {
        let Data::Array(items) = data else { return None };
        let mut items = items.clone();
        let mut changed = false;
        ui.horizontal(|ui| {
            for (i, ((name, kind), item)) in parts.iter().zip(&mut items).enumerate() {
                let axis = ["x", "y", "z", "w"].get(i).copied();
                let name = match name.as_str() {
                    "" if *kind == Kind::Source => "color".to_owned(),
                    // Coordinates have the names of axes, whatever the space.
                    name if name.len() < 2 => axis.map_or_else(|| (i + 1).to_string(), str::to_owned),
                    name => name.to_owned(),
                };
                if let Some(new) = self.edit(ui, kind, &format!("{label}, {name}"), &item.data) {
                    item.data = new;
                    changed = true;
                }
            }
        });
        changed.then_some(Data::Array(items))
    }

    /// Some of a few words, in a menu of switches.
    fn words(&self, ui: &mut Ui, words: &[&str], label: &str, data: &Data) -> Option<Data> {
        let Data::Array(items) = data else { return None };
        let mut change = None;
        let text = match items.len() {
            0 => "none".to_owned(),
            1 => as_text(&items[0].data).to_owned(),
            n => format!("{n} of {}", words.len()),
        };
        let menu = ui.menu_button(text, |ui| {
            egui::ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
                for word in words {
                    let has = items.iter().any(|item| as_text(&item.data) == *word);
                    let mut on = has;
                    if ui.checkbox(&mut on, *word).changed() {
                        let others = items.iter().filter(|item| as_text(&item.data) != *word).cloned();
                        let added = on.then(|| Value::new(Data::String((*word).to_owned())));
                        change = Some(Data::Array(others.chain(added).collect()));
                    }
                }
            });
        });
        name(&menu.response, egui::Role::Button, label);
        change
    }

    fn list(&self, ui: &mut Ui, kind: &Kind, label: &str, data: &Data) -> Option<Data> {
        let Data::Array(items) = data else { return None };
        let mut change = None;
        ui.vertical(|ui| {
            let id = ui.scope_id().with((label, "first"));
            let mut first: usize =
                ui.data(|d| d.get_temp(id)).unwrap_or(0).min(items.len().saturating_sub(1));
            if items.len() > PAGE {
                let last = items.len() - 1;
                let drag = DragValue::new(&mut first)
                    .range(0..=last)
                    .prefix("from ")
                    .suffix(format!(" of {}", items.len()));
                let response = ui.add(drag);
                name_number(&response, &format!("{label}, first shown"), first as f64);
                ui.data_mut(|d| d.insert_temp(id, first));
            }
            for (i, item) in
                items.iter().enumerate().skip(if items.len() > PAGE { first } else { 0 }).take(PAGE)
            {
                let own = format!("{label} {}", i + 1);
                ui.push_id(i, |ui| {
                    ui.horizontal_top(|ui| {
                        if let Some(new) = self.edit(ui, kind, &own, &item.data) {
                            let mut items = items.clone();
                            items[i].data = new;
                            change = Some(Data::Array(items));
                        }
                        let button = ui.small_button("×").on_hover_text("Remove it");
                        name(&button, egui::Role::Button, &format!("Remove {own}"));
                        if button.clicked() {
                            let mut items = items.clone();
                            items.remove(i);
                            change = Some(Data::Array(items));
                        }
                    });
                });
            }
            let button = ui.small_button("Add").on_hover_text("Add one at the end, like the last one");
            name(&button, egui::Role::Button, &format!("Add to {label}"));
            if button.clicked() {
                let new = items.last().map(|item| item.data.clone()).or_else(|| self.start(kind));
                change = new.map(|new| {
                    let new = Value::new(new);
                    Data::Array(items.iter().cloned().chain([new]).collect())
                });
            }
        });
        change
    }

    /// A table whose names the user chooses: material slots.
    fn by_name(&self, ui: &mut Ui, kind: &Kind, label: &str, data: &Data) -> Option<Data> {
        let Data::Table(table) = data else { return None };
        let mut change = None;
        let with = |key: &str, value: Option<Data>| {
            let mut table = table.clone();
            match value {
                Some(value) => table.set(key, turner::schema::value::Span::NONE, Value::new(value)),
                None => table.entries.retain(|entry| entry.key != key),
            }
            Data::Table(table)
        };
        ui.vertical(|ui| {
            for entry in &table.entries {
                let own = format!("{label}, {}", entry.key);
                ui.push_id(&entry.key, |ui| {
                    ui.horizontal(|ui| {
                        ui.label(&entry.key);
                        if let Some(new) = self.edit(ui, kind, &own, &entry.value.data) {
                            change = Some(with(&entry.key, Some(new)));
                        }
                        let button = ui.small_button("×").on_hover_text("Remove it");
                        name(&button, egui::Role::Button, &format!("Remove {own}"));
                        if button.clicked() {
                            change = Some(with(&entry.key, None));
                        }
                    });
                });
            }
            // The name of a further entry is written first.
            let id = ui.scope_id().with((label, "new name"));
            let mut new: String = ui.data(|d| d.get_temp(id)).unwrap_or_default();
            ui.horizontal(|ui| {
                let field = TextEdit::singleline(&mut new).hint_text("name").desired_width(80.0);
                let response = ui.add(field);
                name_text(&response, &format!("{label}, new name"), &new);
                let possible = !new.is_empty() && table.get(&new).is_none();
                let button = ui.add_enabled(possible, egui::Button::new("Add").small());
                name(&button, egui::Role::Button, &format!("Add to {label}"));
                if button.clicked() {
                    change = self.start(kind).map(|value| with(&new, Some(value)));
                    new.clear();
                }
            });
            ui.data_mut(|d| d.insert_temp(id, new));
        });
        change
    }

    /// A value of one of several kinds: which, and the value.
    fn one_of(&self, ui: &mut Ui, kinds: &[Kind], label: &str, data: &Data) -> Option<Data> {
        let now = kinds.iter().position(|kind| kind.takes(data));
        let mut change = None;
        ui.vertical(|ui| {
            let shown = now.map_or_else(|| "none".to_owned(), |i| kinds[i].label());
            let combo = ComboBox::from_id_salt((label, "kind")).selected_text(shown).show_ui(ui, |ui| {
                for (i, kind) in kinds.iter().enumerate() {
                    if ui.selectable_label(now == Some(i), kind.label()).clicked() && now != Some(i) {
                        change = self.start(kind);
                    }
                }
            });
            name(&combo.response, egui::Role::ComboBox, label);
            if let Some(kind) = now.map(|i| &kinds[i])
                && let Some(new) = self.edit(ui, kind, label, data)
            {
                change = Some(new);
            }
        });
        change
    }
}

/// A key of any kind. Without a value, a button gives it one.
pub(crate) fn row(ui: &mut Ui, field: &Field, shown: Option<&Data>, around: &Around<'_>) -> Option<Data> {
    let kind = Kind::of(field);
    let form = Form { around, range: field.range };
    let label = field.name.replace('_', " ");
    let fits = shown.filter(|data| kind.takes(data));
    if let Some(data) = fits {
        return form.edit(ui, &kind, &label, data);
    }
    // A list may be empty, a table of names, too.
    let empty = match &kind {
        Kind::List(_) => Some(Data::Array(Vec::new())),
        Kind::ByName(_) | Kind::Transform => Some(Data::Table(Table::default())),
        _ => None,
    };
    if let Some(empty) = empty {
        return form.edit(ui, &kind, &label, &empty);
    }
    let button = ui.button("automatic").on_hover_text("Choose a value");
    name(&button, egui::Role::Button, field.name);
    button.clicked().then(|| form.start(&kind)).flatten()
}

fn as_number(data: &Data) -> Option<f64> {
    match data {
        Data::Integer(i) => Some(*i as f64),
        Data::Number(v) => Some(*v),
        _ => None,
    }
}

fn as_text(data: &Data) -> &str {
    if let Data::String(text) = data { text } else { "" }
}

fn as_numbers<const N: usize>(data: &Data) -> Option<[f64; N]> {
    let Data::Array(items) = data else { return None };
    let values: Option<Vec<f64>> = items.iter().map(|item| as_number(&item.data)).collect();
    values?.try_into().ok()
}

fn as_color(data: &Data) -> Option<[f64; 3]> {
    as_number(data).map(|v| [v; 3]).or_else(|| as_numbers(data))
}

/// A transform as the scene format writes those of a description: scale and translation, or a matrix.
fn as_transform(table: &Table) -> Option<DAffine3> {
    let get = |key: &str| table.get(key).map(|value| &value.data);
    if let Some(Data::Array(rows)) = get("matrix") {
        let rows: Option<Vec<[f64; 4]>> = rows.iter().map(|row| as_numbers(&row.data)).collect();
        let [x, y, z] = <[[f64; 4]; 3]>::try_from(rows?).ok()?;
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        return Some(DAffine3 { matrix3, translation: column(3) });
    }
    let scale = get("scale").map_or(Some([1.0; 3]), as_color)?;
    let translation = get("translate").map_or(Some([0.0; 3]), as_numbers)?;
    let scale = DMat3::from_diagonal(DVec3::from(scale));
    Some(DAffine3 { matrix3: scale, translation: DVec3::from(translation) })
}

pub(crate) fn of_transform(m: &DAffine3) -> Data {
    let rows = (0..3).map(|row| {
        let columns = m.to_cols_array_2d();
        Value::new(numbers((0..4).map(|column| columns[column][row])))
    });
    let mut table = Table::default();
    table.push("matrix", Data::Array(rows.collect()));
    Data::Table(table)
}

fn edit_transform(ui: &mut Ui, label: &str, data: &Data) -> Option<Data> {
    let Data::Table(table) = data else { return None };
    let own = as_transform(table)?;
    let mut moved = None;
    ui.vertical(|ui| {
        egui::Grid::new((label, "transform")).num_columns(2).spacing([6.0, 2.0]).show(ui, |ui| {
            moved = transform::edit_named(ui, &own, label);
        });
    });
    moved.map(|m| of_transform(&m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_survive_as_matrices() {
        let turned = turner::schema::transform::rotation(DVec3::Y, 40.0);
        let m = DAffine3::from_translation(DVec3::new(4.0, 5.0, 6.0))
            * DAffine3::from_mat3(turned)
            * DAffine3::from_scale(DVec3::new(1.0, 2.0, 3.0));
        let Data::Table(table) = of_transform(&m) else { panic!() };
        assert!(as_transform(&table).unwrap().abs_diff_eq(m, 1e-12));
        let mut table = Table::default();
        assert_eq!(as_transform(&table), Some(DAffine3::IDENTITY));
        table.push("scale", Data::Number(2.0));
        assert_eq!(as_transform(&table), Some(DAffine3::from_scale(DVec3::splat(2.0))));
    }
}
