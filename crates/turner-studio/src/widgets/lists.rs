//! Keys with values of several parts: fixed numbers of numbers, lists, values of several kinds, transforms.

use egui::{ComboBox, DragValue, PopupCloseBehavior, Role, Ui};
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::value::{Data, Span, Table, Value};
use turner::schema::{Field, Range};

use super::field::{Around, Change, limits, number, numbers, source};
use super::kind::numbers as array;
use super::{color, entry, name, name_number, transform};

/// The number of parts of `[x, y, z]` and the like, and whether they are whole numbers. `None` for other types.
pub(crate) fn parts(kind: &str) -> Option<(usize, bool)> {
    let inner = kind.strip_prefix('[')?.strip_suffix(']')?;
    let is_plain = !inner.contains(['[', '|', '…']);
    is_plain.then(|| (inner.split(',').count(), inner.contains("integer")))
}

/// Numbers of a fixed count.
pub(crate) fn vector(ui: &mut Ui, field: &Field, mut values: Vec<f64>, whole: bool) -> Option<Change> {
    let mut changed = false;
    let Range { min, max, .. } = limits(field);
    let min = if whole { min.max(0.0) } else { min };
    for (i, value) in values.iter_mut().enumerate() {
        let speed = if whole { 1.0 } else { (value.abs() * 0.01).max(0.005) };
        let decimals = if whole { 0 } else { 4 };
        let drag = DragValue::new(&mut *value).speed(speed).range(min..=max).max_decimals(decimals);
        let response = ui.add(drag);
        let axis = ["x", "y", "z", "w"].get(i).map_or_else(|| (i + 1).to_string(), |axis| (*axis).to_owned());
        name_number(&response, &format!("{}, {axis}", field.name), *value);
        changed |= response.changed();
    }
    changed.then(|| Change::Set(if whole { integers(&values) } else { array(values) }))
}

fn integers(values: &[f64]) -> Data {
    Data::Array(values.iter().map(|v| Value::new(Data::Integer(v.round() as i64))).collect())
}

/// What a value that a key does not have starts with.
pub(crate) fn start(field: &Field, count: usize, whole: bool, around: &Around<'_>) -> Data {
    match (field.name, count) {
        ("crop", 4) => {
            let [w, h] = around.film.map(f64::from);
            integers(&[0.0, 0.0, w, h])
        }
        ("max", _) => array(vec![1.0; count]),
        ("min", _) => array(vec![-1.0; count]),
        // The transform that changes nothing.
        (_, 6) => array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        _ if whole => integers(&vec![limits(field).min.max(0.0); count]),
        // Sizes must not be 0, nor must directions. A light shines down.
        _ if field.range.is_some_and(|range| range.min >= 0.0) => array(vec![2.0; count]),
        ("center", 3) => array([0.0; 3]),
        ("direction", 3) if around.is_directional => array([-1.0, -3.0, -2.0]),
        (_, 3) => array([1.0, 3.0, 2.0]),
        _ => array(vec![1.0; count]),
    }
}

/// A height, or width and height.
pub(crate) fn viewport(ui: &mut Ui, field: &Field, shown: Option<&Data>) -> Option<Change> {
    match shown {
        Some(Data::Array(_)) => vector(ui, field, shown.and_then(numbers)?, false),
        Some(data) => {
            let mut height = number(data)?;
            let speed = (height * 0.01).max(1e-3);
            let drag = DragValue::new(&mut height).range(1e-6..=f64::INFINITY).speed(speed).max_decimals(4);
            let response = ui.add(drag);
            name_number(&response, field.name, height);
            response.changed().then_some(Change::Set(Data::Number(height)))
        }
        None => {
            let button = ui.button("automatic").on_hover_text("Choose a value");
            name(&button, Role::Button, field.name);
            button.clicked().then(|| Change::Set(array([6.0, 6.0])))
        }
    }
}

/// The words of an attenuation, and its coefficients.
pub(crate) fn attenuation(ui: &mut Ui, field: &Field, shown: Option<&Data>) -> Option<Change> {
    let coefficients = shown.and_then(numbers);
    let now = match shown {
        Some(Data::String(word)) => word.as_str(),
        _ => "coefficients",
    };
    let mut change = None;
    let combo = ComboBox::from_id_salt(field.name).selected_text(now).show_ui(ui, |ui| {
        for word in ["none", "inverse-square", "coefficients"] {
            if entry(ui, now == word, word).clicked() && now != word {
                let data = match word {
                    "coefficients" => array([1.0, 0.0, 0.1]),
                    _ => Data::String(word.to_owned()),
                };
                change = Some(Change::Set(data));
            }
        }
    });
    name(&combo.response, Role::ComboBox, field.name);
    match coefficients {
        Some(values) => change.or(vector(ui, field, values, false)),
        None => change,
    }
}

/// Several words of a choice.
pub(crate) fn words(ui: &mut Ui, field: &Field, shown: Option<&Data>) -> Option<Change> {
    let mut on: Vec<String> = match shown {
        Some(Data::Array(items)) => items.iter().filter_map(|item| word(&item.data)).collect(),
        _ => Vec::new(),
    };
    let text = if on.is_empty() { "none".to_owned() } else { on.join(", ") };
    let mut changed = false;
    // Several are chosen one after another.
    let combo = ComboBox::from_id_salt(field.name)
        .selected_text(text)
        .truncate()
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let combo = combo.show_ui(ui, |ui| {
        for (word, meaning) in (field.words)() {
            let mut has = on.iter().any(|own| own == word);
            if ui.checkbox(&mut has, *word).on_hover_text(*meaning).changed() {
                on.retain(|own| own != word);
                on.extend(has.then(|| (*word).to_owned()));
                changed = true;
            }
        }
    });
    name(&combo.response, Role::ComboBox, field.name);
    let items = on.into_iter().map(|word| Value::new(Data::String(word))).collect();
    changed.then_some(Change::Set(Data::Array(items)))
}

fn word(data: &Data) -> Option<String> {
    if let Data::String(word) = data { Some(word.clone()) } else { None }
}

/// A list whose items are edited, removed and added.
fn list(
    ui: &mut Ui,
    field: &Field,
    shown: Option<&Data>,
    fresh: impl FnOnce(&[Value]) -> Option<Data>,
    mut row: impl FnMut(&mut Ui, &str, &Data) -> Option<Data>,
) -> Option<Change> {
    let mut items = if let Some(Data::Array(items)) = shown { items.clone() } else { Vec::new() };
    let title = field.name.replace('_', " ");
    let mut changed = false;
    ui.vertical(|ui| {
        let mut removed = None;
        for (i, item) in items.iter_mut().enumerate() {
            let label = format!("{title} {}", i + 1);
            ui.push_id(i, |ui| {
                ui.horizontal(|ui| {
                    if let Some(data) = row(ui, &label, &item.data) {
                        item.data = data;
                        changed = true;
                    }
                    let button = ui.small_button("×").on_hover_text("Remove it from the list");
                    name(&button, Role::Button, &format!("Remove {label}"));
                    if button.clicked() {
                        removed = Some(i);
                    }
                });
            });
        }
        if let Some(i) = removed {
            items.remove(i);
            changed = true;
        }
        if let Some(data) = fresh(&items) {
            let button = ui.small_button("Add");
            name(&button, Role::Button, &format!("Add to {title}"));
            if button.clicked() {
                items.push(Value::new(data));
                changed = true;
            }
        }
    });
    changed.then_some(Change::Set(Data::Array(items)))
}

/// Colours at positions.
pub(crate) fn stops(ui: &mut Ui, field: &Field, shown: Option<&Data>, around: &Around<'_>) -> Option<Change> {
    let fresh = |items: &[Value]| {
        // Positions are in order.
        let last = items.last().and_then(|item| pair(&item.data)).map_or(0.5, |(at, _)| at);
        Some(stop(last, array([0.5; 3])))
    };
    list(ui, field, shown, fresh, |ui, label, data| {
        let (mut at, color) = pair(data)?;
        let response = ui.add(DragValue::new(&mut at).range(0.0..=1.0).speed(0.005).max_decimals(4));
        name_number(&response, &format!("{label}, position"), at);
        let moved = response.changed().then(|| color.clone());
        let new = paint(ui, label, &color, None, around).or(moved)?;
        Some(stop(at, new))
    })
}

fn stop(at: f64, color: Data) -> Data {
    Data::Array(vec![Value::new(Data::Number(at)), Value::new(color)])
}

fn pair(data: &Data) -> Option<(f64, Data)> {
    let Data::Array(items) = data else { return None };
    let [at, color] = items.as_slice() else { return None };
    Some((number(&at.data)?, color.data.clone()))
}

/// A colour or a texture of a list.
fn paint(ui: &mut Ui, label: &str, shown: &Data, range: Option<Range>, around: &Around<'_>) -> Option<Data> {
    match source(ui, label, range, Some(shown), false, around)? {
        Change::Set(data) => Some(data),
        _ => None,
    }
}

/// Weights: numbers, colours or textures.
pub(crate) fn weights(
    ui: &mut Ui,
    field: &Field,
    shown: Option<&Data>,
    around: &Around<'_>,
) -> Option<Change> {
    list(
        ui,
        field,
        shown,
        |_| Some(Data::Number(1.0)),
        |ui, label, data| {
            let Some(mut weight) = number(data) else { return paint(ui, label, data, field.range, around) };
            let drag = DragValue::new(&mut weight).range(0.0..=f64::INFINITY).speed(0.01).max_decimals(4);
            let response = ui.add(drag);
            name_number(&response, label, weight);
            let texture = color::texture(ui, label, around.textures);
            response.changed().then_some(Data::Number(weight)).or(texture.map(Data::String))
        },
    )
}

/// Materials by their names.
pub(crate) fn materials(
    ui: &mut Ui,
    field: &Field,
    shown: Option<&Data>,
    around: &Around<'_>,
) -> Option<Change> {
    let fresh = |_: &[Value]| around.materials.first().cloned().map(Data::String);
    list(ui, field, shown, fresh, |ui, label, data| {
        let now = word(data).unwrap_or_default();
        let mut chosen = None;
        let combo = ComboBox::from_id_salt(label).selected_text(&now).show_ui(ui, |ui| {
            for material in around.materials {
                if entry(ui, now == *material, material).clicked() && now != *material {
                    chosen = Some(Data::String(material.clone()));
                }
            }
        });
        name(&combo.response, Role::ComboBox, label);
        chosen
    })
}

/// The transform that [`SceneDesc::value_at`](turner::SceneDesc::value_at) gives.
fn matrix(data: Option<&Data>) -> Option<DAffine3> {
    let Some(data) = data else { return Some(DAffine3::IDENTITY) };
    let Data::Table(table) = data else { return None };
    let vector = |key: &str| {
        table.get(key).and_then(|value| match number(&value.data) {
            Some(v) => Some(DVec3::splat(v)),
            None => <[f64; 3]>::try_from(numbers(&value.data)?).ok().map(DVec3::from_array),
        })
    };
    if let Some(rows) = table.get("matrix") {
        let Data::Array(rows) = &rows.data else { return None };
        let rows: Vec<[f64; 4]> =
            rows.iter().filter_map(|row| <[f64; 4]>::try_from(numbers(&row.data)?).ok()).collect();
        let [x, y, z] = <[[f64; 4]; 3]>::try_from(rows).ok()?;
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        return Some(DAffine3 { matrix3, translation: column(3) });
    }
    let scale = vector("scale").unwrap_or(DVec3::ONE);
    let translation = vector("translate").unwrap_or(DVec3::ZERO);
    Some(DAffine3::from_translation(translation) * DAffine3::from_scale(scale))
}

/// Position, rotation and scale.
pub(crate) fn placement(ui: &mut Ui, shown: Option<&Data>) -> Option<Change> {
    let Some(m) = matrix(shown) else {
        ui.weak("a transform in steps").on_hover_text("Edit it in the file");
        return None;
    };
    let moved = egui::Grid::new("transform").num_columns(2).show(ui, |ui| transform::edit(ui, &m)).inner?;
    let row = |i: usize| Value::new(array(moved.to_cols_array().into_iter().skip(i).step_by(3)));
    let mut table = Table::default();
    table.set("matrix", Span::NONE, Value::new(Data::Array([0, 1, 2].map(row).to_vec())));
    Some(Change::Set(Data::Table(table)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_of_a_fixed_number_of_numbers() {
        assert_eq!(parts("[x, y, z]"), Some((3, false)));
        assert_eq!(parts("[integer, integer, integer, integer]"), Some((4, true)));
        for other in ["[integer, …]", "[[x, y, z], …]", "number", "[width, height] | height"] {
            assert_eq!(parts(other), None, "{other}");
        }
    }

    #[test]
    fn transforms_are_read_as_they_are_written() {
        let m =
            transform::compose([DVec3::new(4.0, 5.0, 6.0), DVec3::new(30.0, 0.0, 10.0), DVec3::splat(3.0)]);
        let row = |i: usize| Value::new(array(m.to_cols_array().into_iter().skip(i).step_by(3)));
        let mut table = Table::default();
        table.set("matrix", Span::NONE, Value::new(Data::Array([0, 1, 2].map(row).to_vec())));
        assert_eq!(matrix(Some(&Data::Table(table))), Some(m));
        let mut table = Table::default();
        table.set("scale", Span::NONE, Value::new(Data::Number(2.0)));
        table.set("translate", Span::NONE, Value::new(array([1.0, 0.0, 0.0])));
        let plain = matrix(Some(&Data::Table(table))).unwrap();
        assert_eq!(plain.transform_point3(DVec3::ONE), DVec3::new(3.0, 2.0, 2.0));
        assert_eq!(matrix(None), Some(DAffine3::IDENTITY));
    }
}
