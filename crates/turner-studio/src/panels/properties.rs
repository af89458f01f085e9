//! The keys of the selected part, as a form made from the schema.

use egui::{ComboBox, Grid, Ui};
use turner::SceneDesc;
use turner::color::Transfer;
use turner::description::{ObjectContent, ObjectDesc, SceneLight};
use turner::film::FilmDesc;
use turner::light::LightDesc;
use turner::schema::EntryDoc;
use turner::schema::value::{Data, Span, Table, Value};

use crate::actions::Action;
use crate::changes::DIRECTION;
use crate::node::{GROUP, MOTION, Node, OBJECT_KEYS};
use crate::panels::{alternatives, model, swatch};
use crate::studio::{Dialog, Purpose, Studio};
use crate::widgets::compound;
use crate::widgets::field::{self, Around, Change};
use crate::widgets::light::{hour, temperature};
use crate::widgets::{entry, name, name_text, transform};

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    let desc = studio.document.desc().clone();
    let Some(node) = studio.selection.filter(|node| node.exists(&desc)) else {
        ui.weak("Click an object in the picture, or a part of the scene in the list.");
        return;
    };
    let names = desc.names();
    let Some(path) = node.path(&names) else { return };
    // The keyboard goes through the form from here.
    let title = egui::Label::new(egui::RichText::new(node.label(&desc)).strong());
    let title = ui
        .horizontal(|ui| {
            let title = ui.add(title.sense(egui::Sense::focusable_noninteractive()));
            if crate::changes::name_of(studio, node).is_some()
                && ui
                    .small_button("Rename…")
                    .on_hover_text("Another name, wherever it is used (F2)")
                    .clicked()
            {
                studio.queue.push(Action::Rename);
            }
            title
        })
        .inner;
    if std::mem::take(&mut studio.focus_properties) {
        title.request_focus();
    }
    let value = match desc.value_at(&path) {
        Ok(value) => value,
        Err(error) => {
            ui.label(error.message);
            return;
        }
    };
    let table = match value {
        Some(Value { data: Data::Table(table), .. }) => table,
        _ => Table::default(),
    };
    let around = Around {
        textures: &names.textures,
        materials: &names.materials,
        media: &names.media,
        groups: &names.groups,
        encoded: desc.film.transfer == Transfer::None,
        film: [desc.film.width, desc.film.height],
        is_directional: matches!(node, Node::Light(i) if is_directional(&desc, i)),
        part: &table,
        defaults: &defaults(node, &desc),
    };
    let mut changes: Vec<(&'static str, Change)> = Vec::new();
    egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        if let Node::Object(i) = node {
            object(ui, studio, i, &table, &around, &mut changes);
        }
        swatch::show(ui, studio, node);
        let kind = types(ui, node, &table, &desc, &mut changes);
        if let Node::Light(i) = node {
            light(ui, studio, i, &path, &kind, &mut changes);
        }
        let entry = match node.family() {
            Some(family) => family.entries.iter().find(|entry| entry.name == kind).copied(),
            None => node.entry(),
        };
        if let Node::Object(i) = node
            && desc.model_of(i).is_some()
        {
            model::show(ui, studio, i, &around);
        } else if let Some(entry) = entry {
            keys(ui, entry, &table, &around, &mut changes);
        }
    });
    for (key, change) in changes {
        apply(studio, node, &path, &table, key, change);
    }
}

fn is_directional(desc: &SceneDesc, light: usize) -> bool {
    matches!(desc.lights.get(light).map(|light| &light.value), Some(LightDesc::Directional(_)))
}

/// The defaults of the film depend on the integrator.
fn defaults(node: Node, desc: &SceneDesc) -> Vec<(&'static str, Data)> {
    if node != Node::Film {
        return Vec::new();
    }
    let film = FilmDesc::default_for(desc.integrator.type_name());
    let word = |word: &str| Data::String(word.to_owned());
    vec![
        ("antialias", word(film.antialias.word())),
        ("samples", Data::Integer(i64::from(film.samples))),
        ("transfer", word(film.transfer.word())),
    ]
}

/// The type, where there is a choice. Returns its name.
fn types(
    ui: &mut Ui,
    node: Node,
    table: &Table,
    desc: &SceneDesc,
    changes: &mut Vec<(&'static str, Change)>,
) -> String {
    let Some(family) = node.family() else { return String::new() };
    let own = match table.get("type").map(|value| &value.data) {
        Some(Data::String(name)) => name.clone(),
        _ => family.entries.first().map_or_else(String::new, |entry| entry.name.to_owned()),
    };
    if let Node::Object(i) = node
        && !matches!(desc.objects.get(i).map(|o| &o.content), Some(ObjectContent::Shape(_)))
    {
        return own;
    }
    ui.horizontal(|ui| {
        ui.label("Type");
        let combo = ComboBox::from_id_salt("type").selected_text(&own).show_ui(ui, |ui| {
            for kind in family.entries {
                let doc = kind.doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
                let chosen = entry(ui, own == kind.name, kind.name).on_hover_text(doc).clicked();
                if chosen && own != kind.name {
                    changes.push(("type", Change::Set(Data::String(kind.name.to_owned()))));
                }
            }
        });
        name(&combo.response, egui::Role::ComboBox, "Type");
    });
    own
}

fn keys(
    ui: &mut Ui,
    entry: &EntryDoc,
    table: &Table,
    around: &Around<'_>,
    changes: &mut Vec<(&'static str, Change)>,
) {
    Grid::new(("keys", entry.name)).num_columns(2).spacing([10.0, 4.0]).striped(true).show(ui, |ui| {
        for field in entry.fields {
            let value = table.get(field.name).map(|value| &value.data);
            if let Some(change) = field::row(ui, field, value, around) {
                changes.push((field.name, change));
            }
        }
    });
}

fn object(
    ui: &mut Ui,
    studio: &mut Studio,
    index: usize,
    table: &Table,
    around: &Around<'_>,
    changes: &mut Vec<(&'static str, Change)>,
) {
    Grid::new("object").num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
        for field in OBJECT_KEYS {
            let value = table.get(field.name).map(|value| &value.data);
            if let Some(change) = field::row(ui, field, value, around) {
                changes.push((field.name, change));
            }
        }
        let desc = studio.document.desc();
        let Some(object) = desc.objects.get(index) else { return };
        if matches!(object.content, ObjectContent::Instance(_)) && desc.model_of(index).is_none() {
            let value = table.get(GROUP.name).map(|value| &value.data);
            changes.extend(field::row(ui, &GROUP, value, around).map(|change| (GROUP.name, change)));
        }
        motion(ui, object, table, around, changes);
        if let Some(moved) = transform::edit(ui, &object.transform.0) {
            studio.moving();
            let result = studio.document.edit("Transform", Some("transform"), |desc| {
                desc.objects[index].transform.0 = moved;
                Ok(())
            });
            studio.check(result);
        }
    });
    ui.separator();
}

/// The motion of an object: none, or a transform.
fn motion(
    ui: &mut Ui,
    object: &ObjectDesc,
    table: &Table,
    around: &Around<'_>,
    changes: &mut Vec<(&'static str, Change)>,
) {
    if object.motion.is_some() {
        let value = table.get(MOTION.name).map(|value| &value.data);
        changes.extend(field::row(ui, &MOTION, value, around).map(|change| (MOTION.name, change)));
        return;
    }
    ui.label(MOTION.name).on_hover_text(MOTION.doc.join(" "));
    let button = ui.button("none").on_hover_text("Let it move while the shutter is open, from here");
    name(&button, egui::Role::Button, MOTION.name);
    if button.clicked() {
        changes.push((MOTION.name, Change::Set(compound::of_transform(&object.transform.0))));
    }
    ui.end_row();
}

/// Name, group and helpers of a light.
fn light(
    ui: &mut Ui,
    studio: &mut Studio,
    index: usize,
    path: &str,
    kind: &str,
    changes: &mut Vec<(&'static str, Change)>,
) {
    let Some(light) = studio.document.desc().lights.get(index).cloned() else { return };
    let text = |ui: &mut Ui, label: &str, value: &Option<String>| {
        let mut now = value.clone().unwrap_or_default();
        ui.label(label);
        let response = ui.add(egui::TextEdit::singleline(&mut now).desired_width(140.0));
        name_text(&response, label, &now);
        ui.end_row();
        let new = (!now.is_empty()).then_some(now);
        response.changed().then_some(new)
    };
    let mut edited = None;
    Grid::new("light").num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
        if let Some(name) = text(ui, "name", &light.name) {
            edited = Some(SceneLight { name, ..light.clone() });
        }
        if let Some(group) = text(ui, "light group", &light.group) {
            edited = Some(SceneLight { group, ..light.clone() });
        }
    });
    let mut hidden = light.hidden;
    let response = ui.checkbox(&mut hidden, "hidden");
    if response.changed() {
        edited = Some(SceneLight { hidden, ..light.clone() });
    }
    if let Some(light) = edited {
        let result = studio.document.edit("Light", Some("light"), |desc| {
            desc.lights[index] = light;
            Ok(())
        });
        studio.check(result);
    }
    let has_color =
        LightDesc::DOC.entries.iter().any(|e| e.name == kind && e.fields.iter().any(|f| f.name == "color"));
    if has_color && let Some(rgb) = temperature(ui) {
        let items = rgb.map(|v| Value::new(Data::Number(v))).to_vec();
        changes.push(("color", Change::Set(Data::Array(items))));
    }
    if kind == "sky"
        && let Some([elevation, azimuth]) = hour(ui)
    {
        studio.moving();
        let edits = [("elevation", elevation), ("azimuth", azimuth)]
            .map(|(key, v)| (format!("{path}.{key}"), Data::Number(v)));
        let result = studio.document.set("Hour of the sun", Some("hour"), &edits);
        studio.check(result);
    }
    ui.separator();
}

/// Makes a change of the form in the scene.
fn apply(studio: &mut Studio, node: Node, path: &str, table: &Table, key: &'static str, change: Change) {
    let label = format!("{}: {}", node.label(studio.document.desc()), key.replace('_', " "));
    match change {
        Change::Set(data) => {
            studio.moving();
            // The lists of a mesh are read together, and those of curves.
            let is_curves = table.get("type").is_some_and(|kind| kind.data == Data::String("curves".into()));
            let list = if is_curves { "points" } else { "positions" };
            let is_inline = key != "type" && table.get(list).is_some();
            let inline = || {
                let mut table = table.clone();
                table.set(key, Span::NONE, Value::new(data.clone()));
                table
            };
            let whole = alternatives::set(table, key).or_else(|| is_inline.then(inline));
            let mut edits = match whole {
                Some(whole) => vec![(path.to_owned(), Data::Table(whole))],
                None => vec![(format!("{path}.{key}"), data)],
            };
            if key == "type" && edits[0].1 == Data::String("directional".into()) {
                // Without a direction it is no light yet.
                let from = DIRECTION.to_array().map(|v| Value::new(Data::Number(v)));
                edits.push((format!("{path}.from"), Data::Array(from.to_vec())));
            }
            let result = studio.document.set(&label, Some(&label), &edits);
            studio.check(result);
        }
        Change::Unset => {
            let mut rest = table.clone();
            let other = alternatives::other(table, key);
            rest.entries.retain(|entry| entry.key != key && Some(entry.key.as_str()) != other);
            let result = studio.document.set(&label, None, &[(path.to_owned(), Data::Table(rest))]);
            studio.check(result);
        }
        Change::File(is_texture) => {
            let name = format!("{}{}", studio.document.folder().display(), std::path::MAIN_SEPARATOR);
            let purpose = Purpose::Key(format!("{path}.{key}"), is_texture);
            studio.dialog = Some(Dialog::File { purpose, name });
        }
        Change::Follow(kind, name) => {
            let names = studio.document.desc().names();
            let place = |list: &[String]| list.iter().position(|other| *other == name);
            studio.selection = match kind {
                "texture" => place(&names.textures).map(Node::Texture),
                "material" => place(&names.materials).map(Node::Material),
                _ => place(&names.media).map(Node::Medium),
            };
        }
    }
}
