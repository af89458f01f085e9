//! Edits a key of a part through its widget in the form, takes it back and does it again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use turner::SceneDesc;
use turner::schema::value::{Data, Value};
use turner::schema::{EntryDoc, Field, Range};
use turner_io::assets::FolderAssets;
use turner_live::document::Document;
use turner_studio::node::Node;
use turner_studio::studio::{Dialog, Purpose};

use super::common::*;

/// What meshes and points do not go without.
const REQUIRED: &[&str] = &["positions", "triangles", "points"];

pub(crate) fn textures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/classic")
}

/// The sample scene and text that follows, with pictures to read.
pub(crate) fn with(text: &str) -> SceneDesc {
    let assets = FolderAssets::new(textures()).unwrap();
    let loaded =
        turner_io::scene::load_text(format!("{SAMPLE}\n{text}"), "test.toml", &assets, &Default::default());
    loaded.unwrap_or_else(|e| panic!("{}\n{text}", e.error.message)).desc
}

fn number(data: &Data) -> Option<f64> {
    match data {
        Data::Integer(i) => Some(*i as f64),
        Data::Number(v) => Some(*v),
        _ => None,
    }
}

/// Values within a range, spread out.
fn candidates(range: Option<Range>, whole: bool) -> Vec<f64> {
    let Range { min, max, .. } = range.unwrap_or(Range::FINITE);
    let (low, high) = (min.max(-100.0), max.min(100.0));
    let spread = [0.25, 0.5, 0.75, 0.1, 0.9].map(|t| low + (high - low) * t);
    let mut list: Vec<f64> = spread.into_iter().chain([1.0, 2.0, 3.0, 0.5, 4.0, high, low]).collect();
    list.iter_mut().for_each(|v| *v = if whole { v.round() } else { (*v * 100.0).round() / 100.0 });
    list.retain(|v| (min..=max).contains(v) && (*v > min || !range.is_some_and(|r| r.open_min)));
    list
}

/// A test of one part of a scene.
pub(crate) struct Form<'a> {
    pub(crate) window: &'a mut Window,
    pub(crate) part: Node,
    pub(crate) path: String,
    pub(crate) faults: &'a mut Vec<String>,
}

impl Form<'_> {
    pub(crate) fn desc(&self) -> Arc<SceneDesc> {
        Arc::clone(seen(self.window).document.desc())
    }

    pub(crate) fn value(&self, key: &str) -> Option<Data> {
        let value =
            self.desc().value_at(&format!("{}.{key}", self.path)).unwrap_or_else(|e| panic!("{}", e.message));
        value.map(|value| value.data)
    }

    fn select(&mut self) {
        app(self.window).selection = Some(self.part);
        app(self.window).message = None;
        frames(self.window, 2);
    }

    fn has(&self, role: Role, label: &str) -> bool {
        node(self.window, role, label).is_some()
    }

    /// Does `act` and expects a step of the history, which undo and redo take back and forth. Returns whether the scene
    /// took the value.
    pub(crate) fn step(
        &mut self,
        what: &str,
        act: impl FnOnce(&mut Window),
        is_right: impl Fn(&Self) -> bool,
    ) -> bool {
        self.select();
        app(self.window).document.end_gesture();
        let (before, count) = (self.desc(), seen(self.window).document.steps().0.len());
        act(self.window);
        frames(self.window, 2);
        let after = self.desc();
        if Arc::ptr_eq(&before, &after) {
            // A list that is still open closes.
            press(self.window, Modifiers::NONE, Key::Escape);
            return false;
        }
        let name = format!("{} {what}", self.path);
        if seen(self.window).document.steps().0.len() != count + 1 {
            self.faults.push(format!("{name}: not one step, {:?}", seen(self.window).document.steps().0));
        }
        if !is_right(self) {
            self.faults.push(format!("{name}: another value than was chosen"));
        }
        press(self.window, Modifiers::COMMAND, Key::Z);
        if !Arc::ptr_eq(&self.desc(), &before) {
            self.faults.push(format!("{name}: undo gives another scene"));
        }
        press(self.window, Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
        if !Arc::ptr_eq(&self.desc(), &after) {
            self.faults.push(format!("{name}: redo gives another scene"));
        }
        // The button for the default.
        let label = what.split(", ").next().unwrap_or(what).replace('_', " ");
        let reset = format!("Default of {label}");
        if self.has(Role::Button, &reset) {
            click(self.window, Role::Button, &reset);
            let key = label.replace(' ', "_");
            let refused = REQUIRED.contains(&key.as_str())
                && seen(self.window).message.as_ref().is_some_and(|message| message.is_error);
            if self.value(&key).is_some() && !refused {
                self.faults.push(format!("{name}: the button for the default leaves {:?}", self.value(&key)));
            }
        }
        while app(self.window).document.undo().is_some() {}
        if !Arc::ptr_eq(&self.desc(), &before) {
            self.faults.push(format!("{name}: undo of all steps gives another scene"));
        }
        self.select();
        true
    }

    pub(crate) fn set_number(
        &mut self,
        label: &str,
        values: &[f64],
        is_right: impl Fn(&Self, f64) -> bool,
    ) -> bool {
        let own = label.to_owned();
        values.iter().any(|&v| {
            let label = own.clone();
            let act = move |window: &mut Window| {
                if let Some(node) = node(window, Role::SpinButton, &label) {
                    node.set_value_accesskit(v);
                }
            };
            self.step(&own, act, |form| is_right(form, v))
        })
    }

    /// Chooses an entry of a list.
    pub(crate) fn choose(&mut self, label: &str, entry: &str, is_right: impl Fn(&Self) -> bool) -> bool {
        let (own, entry) = (label.to_owned(), entry.to_owned());
        let act = move |window: &mut Window| {
            if let Some(combo) = node(window, Role::ComboBox, &own) {
                combo.click_accesskit();
            }
            frames(window, 2);
            if let Some(entry) = node(window, Role::Button, &entry) {
                entry.click_accesskit();
            }
        };
        self.step(label, act, is_right)
    }

    /// Edits a key. `None`: it has no widget.
    fn key(&mut self, field: &Field) -> Option<bool> {
        self.select();
        let (key, label) = (field.name, field.name.replace('_', " "));
        let kind = (field.kind)();
        let words = (field.words)();
        let near = |data: Option<Data>, v: f64| {
            data.as_ref().and_then(number).is_none_or(|own| (own - v).abs() < 1e-9)
        };
        if let Some(done) = self.list(field, &kind, &label) {
            return Some(done);
        }
        if self.has(Role::ComboBox, &label) && !words.is_empty() {
            let mut done = 0;
            let mut silent = Vec::new();
            for (word, _) in words {
                let chosen =
                    |form: &Self| form.value(key).is_none_or(|v| v == Data::String((*word).to_owned()));
                if self.choose(&label, word, chosen) {
                    done += 1;
                } else if seen(self.window).message.is_none() {
                    silent.push(*word);
                }
            }
            // The present word stays without a message.
            if silent.len() > 1 {
                self.faults.push(format!("{} {key}: neither chosen nor refused: {silent:?}", self.path));
            }
            return Some(done > 0);
        }
        if self.has(Role::CheckBox, &label) {
            let before = self.value(key);
            let act = |window: &mut Window| click(window, Role::CheckBox, &label);
            return Some(self.step(key, act, |form| form.value(key) != before));
        }
        if kind == "material" || kind == "medium" {
            let names = if kind == "material" { vec!["gold", "chalk"] } else { vec!["haze"] };
            let is = |name: &str| Some(Data::String(name.to_owned()));
            let done = names.iter().any(|name| self.choose(&label, name, |form| form.value(key) == is(name)));
            return self.has(Role::ComboBox, &label).then_some(done);
        }
        if self.has(Role::TextInput, &label) {
            let act = |window: &mut Window| {
                node(window, Role::TextInput, &label).unwrap().focus();
                frames(window, 2);
                write(window, "q");
            };
            let typed = |data: Option<Data>| matches!(data, Some(Data::String(text)) if text.contains('q'));
            return Some(self.step(key, act, |form| typed(form.value(key))));
        }
        if self.has(Role::SpinButton, &label) {
            let range = if kind == "[width, height] | height" { Some(Range::POSITIVE) } else { field.range };
            let values = candidates(range, kind == "integer");
            return Some(self.set_number(&label, &values, |form, v| near(form.value(key), v)));
        }
        let parts = ["x", "width"].map(|part| format!("{label}, {part}"));
        if self.has(Role::Button, &label) && !kind.contains("file") && field.name != "file" {
            // "automatic": a click gives it a value that can be rendered, and fields to change it.
            let could_render = self.desc().prepare(&Default::default()).is_ok();
            let act = |window: &mut Window| click(window, Role::Button, &label);
            let right = |form: &Self| {
                let has = parts.iter().chain([&label]).any(|name| form.has(Role::SpinButton, name));
                let problem = form.desc().prepare(&Default::default()).err();
                form.value(key).is_some() && has && !(could_render && problem.is_some())
            };
            return Some(self.step(key, act, right));
        }
        for (part, index) in [("red", 0), ("y", 1), ("x", 0), ("width", 0)] {
            let first = format!("{label}, {part}");
            if !self.has(Role::SpinButton, &first) {
                continue;
            }
            let item = move |data: Option<Data>| match data {
                Some(Data::Array(items)) => items.get(index).map(|item| item.data.clone()),
                other => other,
            };
            let values = candidates(field.range, kind.contains("integer"));
            let mut done = self.set_number(&first, &values, |form, v| near(item(form.value(key)), v));
            if kind == "color | texture" {
                let is = |form: &Self| form.value(key) == Some(Data::String("squares".into()));
                done &= self.choose(&format!("{label} texture"), "squares", is);
            }
            return Some(done);
        }
        // A file: a button that asks for its name.
        self.has(Role::Button, &label).then(|| {
            click(self.window, Role::Button, &label);
            let asks =
                matches!(seen(self.window).dialog, Some(Dialog::File { purpose: Purpose::Key(..), .. }));
            press(self.window, Modifiers::NONE, Key::Escape);
            asks && seen(self.window).dialog.is_none()
        })
    }

    /// Edits a key whose value has several parts. `None`: it is no such key.
    fn list(&mut self, field: &Field, kind: &str, label: &str) -> Option<bool> {
        let key = field.name;
        let text = |word: &str| Data::String(word.to_owned());
        let length = |form: &Self| match form.value(key) {
            Some(Data::Array(items)) => items.len(),
            _ => 0,
        };
        if kind == "transform" {
            let axes = ["Position, x", "Rotation (degrees), y", "Scale, z"];
            let set = |form: &mut Self, axis: &str| {
                let name = format!("{label}, {axis}");
                form.set_number(&name, &[0.5, 2.0], |form, _| form.value(key).is_some())
            };
            return Some(axes.iter().all(|axis| set(self, axis)));
        }
        if kind == "\"none\" | \"inverse-square\" | [constant, linear, quadratic]" {
            let done = ["inverse-square", "constant, linear, quadratic", "none"].iter().filter(|word| {
                let is = |form: &Self| match (form.value(key), **word) {
                    (Some(Data::Array(items)), "constant, linear, quadratic") => items.len() == 3,
                    (own, word) => own.is_none_or(|own| own == text(word)),
                };
                self.choose(label, word, is)
            });
            // One of them is the present value.
            return Some(done.count() == 2);
        }
        if kind.starts_with("[\"") {
            let word = (field.words)()[0].0;
            let act = |window: &mut Window| {
                click(window, Role::ComboBox, label);
                click(window, Role::CheckBox, word);
                press(window, Modifiers::NONE, Key::Escape);
            };
            let right = |form: &Self| form.value(key) == Some(Data::Array(vec![Value::new(text(word))]));
            return Some(self.step(key, act, right));
        }
        if kind == "{ NAME = material, … } | [material | false, …]" {
            // A mesh without a file: a list of one, which is another then.
            let act = |window: &mut Window| click(window, Role::Button, label);
            let is_right = |form: &Self| length(form) == 1 && form.has(Role::ComboBox, &format!("{label} 1"));
            return Some(self.step(key, act, is_right));
        }
        let of_shapes = kind.starts_with("[{ type = shape");
        let of_numbers = kind.ends_with(", …]") && !kind.contains('|') && !kind.contains("material");
        if of_numbers {
            return Some(self.numbers(key, label));
        }
        let of_values =
            matches!(kind, "[material, …]" | "[color | texture, …]" | "[[position, color | texture], …]");
        if !of_values && !of_shapes {
            return None;
        }
        let count = length(self);
        let add = |window: &mut Window| click(window, Role::Button, &format!("Add to {label}"));
        let mut done = self.step(key, add, |form| length(form) == count + 1);
        if count > 0 {
            let remove = |window: &mut Window| click(window, Role::Button, &format!("Remove {label} 1"));
            done &= self.step(key, remove, |form| length(form) == count - 1);
            let item = format!("{label} 1");
            done &= match kind {
                // The keys of a part are edited in the file.
                _ if of_shapes => shows(self.window, "sphere"),
                "[material, …]" => self.choose(&item, "chalk", |form| length(form) == count),
                "[color | texture, …]" => {
                    self.set_number(&item, &[0.25, 3.0], |form, _| length(form) == count)
                        && self.choose(&format!("{item} texture"), "squares", |form| length(form) == count)
                }
                _ => {
                    self.set_number(&format!("{item}, position"), &[0.125], |form, _| length(form) == count)
                        && self.set_number(&format!("{item}, color, red"), &[0.75], |form, _| {
                            length(form) == count
                        })
                        && self.choose(&format!("{item}, color texture"), "squares", |form| {
                            length(form) == count
                        })
                }
            };
        }
        Some(done)
    }

    /// Edits a list of numbers, or of groups of them: the data of a mesh.
    fn numbers(&mut self, key: &str, label: &str) -> bool {
        let items = |form: &Self| match form.value(key) {
            Some(Data::Array(items)) => items,
            _ => Vec::new(),
        };
        let count = items(self).len();
        let add = |window: &mut Window| click(window, Role::Button, &format!("Add to {label}"));
        // One for each vertex or triangle if there was none.
        let grown = |form: &Self| match count {
            0 => !items(form).is_empty(),
            count => items(form).len() == count + 1,
        };
        let done = self.step(key, add, grown);
        let first = format!("{label} 1, x");
        if count == 0 || !done {
            return done;
        }
        self.set_number(&first, &[0.5, 2.0], |form, v| match &items(form)[0].data {
            Data::Array(parts) => number(&parts[0].data).is_some_and(|own| own == v.round() || own == v),
            _ => false,
        })
    }
}

/// Edits all keys of a type of a part.
pub(crate) fn all_keys(
    window: &mut Window,
    desc: SceneDesc,
    part: Node,
    entry: &EntryDoc,
    faults: &mut Vec<String>,
) {
    all_keys_in(window, desc, &textures(), part, entry, faults);
}

pub(crate) fn all_keys_in(
    window: &mut Window,
    desc: SceneDesc,
    folder: &Path,
    part: Node,
    entry: &EntryDoc,
    faults: &mut Vec<String>,
) {
    let path = part.path(&desc.names()).unwrap();
    app(window).show(Document::of(desc, "Sample".into(), folder.to_owned()));
    frames(window, 2);
    // Keys that a mesh takes only together with others, or instead of others.
    let depends = |key: &str| {
        let keys = [
            "polygons",
            "subdivision",
            "levels",
            "creases",
            "crease_angle",
            "keep_corners",
            "displacement_scale",
            "displacement_midlevel",
        ];
        entry.name == "mesh" && keys.contains(&key)
    };
    for field in entry.fields.iter().filter(|field| !depends(field.name)) {
        let mut form = Form { window, part, path: path.clone(), faults };
        let name = format!("{} {}.{}", path, entry.name, field.name);
        match form.key(field) {
            Some(true) => {}
            Some(false) => {
                let said = seen(form.window).message.as_ref().map(|m| m.text.clone());
                faults.push(format!("{name}: takes no value; {said:?}"));
            }
            None => faults.push(format!("{name}: has no widget ({})", (field.kind)())),
        }
    }
}

pub(crate) fn check(faults: &[String]) {
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
