//! Values that consist of others: lists, tuples, tables by name, transforms, and values of one of several kinds.

use std::cell::Cell;

use egui::{ComboBox, DragValue, PopupCloseBehavior, TextEdit, Ui};
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::value::{Data, Table, Value};
use turner::schema::{Field, Range};

use super::field::{self, Around, Change, number, numbers as as_numbers};
use super::kind::{Kind, numbers};
use super::{entry, name, name_number, name_text, start, transform};

/// Items of a list that are shown at once.
const PAGE: usize = 12;

/// What all parts of a value have in common.
struct Form<'a> {
    around: &'a Around<'a>,
    field: &'a Field,
    range: Option<Range>,
    /// What a part asks for besides a new value: to show a texture.
    aside: Cell<Option<Change>>,
}

impl Form<'_> {
    /// Shows a value and returns the new one, if it changes. `label` names its widgets.
    fn edit(&self, ui: &mut Ui, kind: &Kind, label: &str, data: &Data) -> Option<Data> {
        match kind {
            Kind::Switch => field::switch(ui, label, Some(data)),
            Kind::Number { whole } => {
                // Whole numbers within others count something.
                let counts = Range { min: 0.0, ..Range::FINITE };
                let range = self.range.or(whole.then_some(counts));
                field::number_box(ui, label, range, number(data)?, *whole)
            }
            Kind::Text | Kind::File => {
                field::text(ui, label, Some(data)).filter(|now| !now.is_empty()).map(Data::String)
            }
            Kind::Color => field::colour(ui, label, None, Some(data), self.around),
            Kind::Source => self.source(ui, label, None, data),
            Kind::Part(part) => self.part(ui, label, data, part, false),
            Kind::Word(words) => choice(ui, label, data, words.iter().copied()),
            Kind::Tuple(parts) => self.tuple(ui, parts, label, data),
            Kind::List(item) => match &**item {
                Kind::Word(words) => some_of(ui, words, label, data),
                item => self.list(ui, item, label, data),
            },
            Kind::ByName(item) => self.by_name(ui, item, label, data),
            Kind::Transform => edit_transform(ui, label, data),
            Kind::Shape => {
                let Data::Table(table) = data else { return None };
                let of_type = table.get("type").map_or("shape", |value| as_text(&value.data));
                ui.label(of_type).on_hover_text("Edit it in the file");
                None
            }
            Kind::Literal(_) | Kind::False => None,
            Kind::OneOf(kinds) => match kinds.as_slice() {
                [Kind::Part(part), Kind::False] => self.part(ui, label, data, part, true),
                kinds => self.one_of(ui, kinds, label, data),
            },
        }
    }

    fn start(&self, kind: &Kind) -> Option<Data> {
        kind.start(&|part| self.around.names(part))
    }

    /// A colour, or a texture by its name.
    fn source(&self, ui: &mut Ui, label: &str, range: Option<Range>, data: &Data) -> Option<Data> {
        self.keep(field::source(ui, label, range, Some(data), false, self.around))
    }

    /// A weight: a number, a colour or a texture.
    fn weight(&self, ui: &mut Ui, label: &str, data: &Data) -> Option<Data> {
        let Some(weight) = number(data) else { return self.source(ui, label, self.range, data) };
        let new = field::number_box(ui, label, self.range, weight, false);
        // A grey would be a number again.
        let other = field::instead(ui, label, None, false, false, [0.9, 0.6, 0.3], self.around);
        new.or(self.keep(other))
    }

    fn keep(&self, change: Option<Change>) -> Option<Data> {
        match change? {
            Change::Set(data) => Some(data),
            other => {
                self.aside.set(Some(other));
                None
            }
        }
    }

    /// A part of the scene by its name; with `optional`, also none.
    fn part(&self, ui: &mut Ui, label: &str, data: &Data, part: &str, optional: bool) -> Option<Data> {
        let names = self.around.names(part);
        let none = optional.then_some(("none", ""));
        let chosen = choice(ui, label, data, none.into_iter().chain(names.iter().map(|n| (n.as_str(), ""))))?;
        let is_none = optional && as_text(&chosen) == "none";
        Some(if is_none { Data::Bool(false) } else { chosen })
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
                let own = format!("{label}, {name}");
                if let Some(new) = self.edit(ui, kind, &own, &item.data) {
                    item.data = new;
                    changed = true;
                }
            }
        });
        changed.then_some(Data::Array(items))
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
                        let new = match kind {
                            Kind::Source => self.weight(ui, &own, &item.data),
                            kind => self.edit(ui, kind, &own, &item.data),
                        };
                        if let Some(new) = new {
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
                let new = match items.last() {
                    Some(last) => vec![last.clone()],
                    None => start::items(self.field, kind, self.around),
                };
                let all = items.iter().cloned().chain(new).collect();
                change = Some(Data::Array(all));
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
                    if entry(ui, now == Some(i), kind.label()).clicked() && now != Some(i) {
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

/// The value of a key. Without one, a button gives it one.
pub(crate) fn show(ui: &mut Ui, field: &Field, shown: Option<&Data>, around: &Around<'_>) -> Option<Change> {
    let kind = Kind::of(field);
    // The format has no range for a viewport, but no picture without a size.
    let is_size = field.name == "viewport";
    let range = field.range.or_else(|| is_size.then_some(Range::POSITIVE));
    let form = Form { around, field, range, aside: Cell::default() };
    let label = field.name.replace('_', " ");
    let set = |data: Option<Data>| data.map(Change::Set).or_else(|| form.aside.take());
    if let Some(data) = shown.filter(|data| kind.takes(data)) {
        return set(form.edit(ui, &kind, &label, data));
    }
    // A list may be empty, a table of names, too.
    let empty = match &kind {
        Kind::List(_) => Some((&kind, Data::Array(Vec::new()))),
        Kind::ByName(_) | Kind::Transform => Some((&kind, Data::Table(Table::default()))),
        // The materials of a file have names.
        Kind::OneOf(kinds) if has_file(around.part) => kinds
            .iter()
            .find(|kind| matches!(kind, Kind::ByName(_)))
            .map(|kind| (kind, Data::Table(Table::default()))),
        _ => None,
    };
    match empty {
        Some((kind, empty)) => set(form.edit(ui, kind, &label, &empty)),
        None => field::automatic(ui, field, || start::value(field, &kind, around)),
    }
}

/// Whether a part is read from a file. The data of large meshes without one have a name that begins with `'`.
fn has_file(part: &Table) -> bool {
    part.get("file").is_some_and(|file| !as_text(&file.data).starts_with('\''))
}

/// One of some words. The texts beside them are their meanings.
fn choice<'w>(
    ui: &mut Ui,
    label: &str,
    data: &Data,
    words: impl Iterator<Item = (&'w str, &'w str)>,
) -> Option<Data> {
    let now = if as_text(data).is_empty() { "none" } else { as_text(data) };
    let mut chosen = None;
    let combo = ComboBox::from_id_salt(label).selected_text(now).show_ui(ui, |ui| {
        for (word, meaning) in words {
            let mut response = entry(ui, now == word, word);
            if !meaning.is_empty() {
                response = response.on_hover_text(meaning);
            }
            if response.clicked() && now != word {
                chosen = Some(Data::String(word.to_owned()));
            }
        }
    });
    name(&combo.response, egui::Role::ComboBox, label);
    chosen
}

/// Some of a few words, as switches in a list that stays open: several are chosen one after another.
fn some_of(ui: &mut Ui, words: &[(&str, &str)], label: &str, data: &Data) -> Option<Data> {
    let Data::Array(items) = data else { return None };
    let mut change = None;
    let on: Vec<&str> = items.iter().map(|item| as_text(&item.data)).collect();
    let text = if on.is_empty() { "none".to_owned() } else { on.join(", ") };
    let combo = ComboBox::from_id_salt(label)
        .selected_text(text)
        .truncate()
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let combo = combo.show_ui(ui, |ui| {
        for (word, meaning) in words {
            let mut has = on.contains(word);
            if ui.checkbox(&mut has, *word).on_hover_text(*meaning).changed() {
                let others = items.iter().filter(|item| as_text(&item.data) != *word).cloned();
                let added = has.then(|| Value::new(Data::String((*word).to_owned())));
                change = Some(Data::Array(others.chain(added).collect()));
            }
        }
    });
    name(&combo.response, egui::Role::ComboBox, label);
    change
}

fn as_text(data: &Data) -> &str {
    if let Data::String(text) = data { text } else { "" }
}

fn as_array<const N: usize>(data: &Data) -> Option<[f64; N]> {
    as_numbers(data)?.try_into().ok()
}

/// A transform as the scene format writes those of a description: scale and translation, or a matrix.
fn as_transform(table: &Table) -> Option<DAffine3> {
    let get = |key: &str| table.get(key).map(|value| &value.data);
    if let Some(Data::Array(rows)) = get("matrix") {
        let rows: Option<Vec<[f64; 4]>> = rows.iter().map(|row| as_array(&row.data)).collect();
        let [x, y, z] = <[[f64; 4]; 3]>::try_from(rows?).ok()?;
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        return Some(DAffine3 { matrix3, translation: column(3) });
    }
    let scale = match get("scale") {
        Some(data) => number(data).map(|v| [v; 3]).or_else(|| as_array(data))?,
        None => [1.0; 3],
    };
    let translation = get("translate").map_or(Some([0.0; 3]), as_array)?;
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
    let Some(own) = as_transform(table) else {
        ui.weak("a transform in steps").on_hover_text("Edit it in the file");
        return None;
    };
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
        table.push("translate", numbers([1.0, 0.0, 0.0]));
        let moved = as_transform(&table).unwrap();
        assert_eq!(moved.transform_point3(DVec3::ONE), DVec3::new(3.0, 2.0, 2.0));
    }
}
