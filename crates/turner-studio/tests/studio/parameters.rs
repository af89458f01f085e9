//! Every key of every type of every family, edited through its widget, undone and redone. The lists come from the schema.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use turner::SceneDesc;
use turner::camera::CameraDesc;
use turner::description::{ObjectContent, StudioDesc};
use turner::film::FilmDesc;
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::value::{Data, Value};
use turner::schema::{EntryDoc, Field, Range};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_io::assets::FolderAssets;
use turner_live::document::Document;
use turner_studio::node::Node;
use turner_studio::studio::{Dialog, Purpose};

use super::common::*;

/// The data of meshes and points: lists as long as a model. They are shown, and edited in the file.
const IN_THE_FILE: &[&str] = &[
    "mesh.positions",
    "mesh.triangles",
    "mesh.normals",
    "mesh.uvs",
    "mesh.uvs_1",
    "mesh.tangents",
    "mesh.colors",
    "mesh.face_materials",
    "mesh.materials",
    "points.positions",
    "points.colors",
    "points.radii",
];

fn textures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/classic")
}

/// The sample scene and text that follows, with pictures to read.
fn with(text: &str) -> SceneDesc {
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
struct Form<'a> {
    window: &'a mut Window,
    part: Node,
    path: String,
    faults: &'a mut Vec<String>,
}

impl Form<'_> {
    fn desc(&self) -> Arc<SceneDesc> {
        Arc::clone(seen(self.window).document.desc())
    }

    fn value(&self, key: &str) -> Option<Data> {
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
    fn step(&mut self, what: &str, act: impl FnOnce(&mut Window), is_right: impl Fn(&Self) -> bool) -> bool {
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
            if self.value(&key).is_some() {
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

    fn set_number(&mut self, label: &str, values: &[f64], is_right: impl Fn(&Self, f64) -> bool) -> bool {
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
    fn choose(&mut self, label: &str, entry: &str, is_right: impl Fn(&Self) -> bool) -> bool {
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
            return Some(words.iter().any(|(word, _)| {
                let chosen =
                    |form: &Self| form.value(key).is_none_or(|v| v == Data::String((*word).to_owned()));
                self.choose(&label, word, chosen)
            }));
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
        let first = format!("{label}, x");
        if self.has(Role::Button, &label) && !kind.contains("file") && field.name != "file" {
            // "automatic": a click gives it a value, and fields to change it.
            let act = |window: &mut Window| click(window, Role::Button, &label);
            let right = |form: &Self| {
                let has = form.has(Role::SpinButton, &label) || form.has(Role::SpinButton, &first);
                form.value(key).is_some() && has
            };
            return Some(self.step(key, act, right));
        }
        for (first, index) in
            [(format!("{label}, red"), 0), (format!("{label}, y"), 1), (format!("{label}, x"), 0)]
        {
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
            let asks = matches!(seen(self.window).dialog, Some(Dialog::File { purpose: Purpose::Key(..), .. }));
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
                form.set_number(axis, &[0.5, 2.0], |form, _| form.value(key).is_some())
            };
            return Some(axes.iter().all(|axis| set(self, axis)));
        }
        if kind == "\"none\" | \"inverse-square\" | [constant, linear, quadratic]" {
            let done = ["inverse-square", "coefficients", "none"].iter().filter(|word| {
                let is = |form: &Self| match (form.value(key), **word) {
                    (Some(Data::Array(items)), "coefficients") => items.len() == 3,
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
        if !matches!(kind, "[material, …]" | "[color | texture, …]" | "[[position, color | texture], …]") {
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
                "[material, …]" => self.choose(&item, "chalk", |form| length(form) == count),
                "[color | texture, …]" => {
                    self.set_number(&item, &[0.25, 3.0], |form, _| length(form) == count)
                        && self.choose(&format!("{item} texture"), "squares", |form| length(form) == count)
                }
                _ => {
                    self.set_number(&format!("{item}, position"), &[0.125], |form, _| length(form) == count)
                        && self.set_number(&format!("{item}, red"), &[0.75], |form, _| length(form) == count)
                        && self.choose(&format!("{item} texture"), "squares", |form| length(form) == count)
                }
            };
        }
        Some(done)
    }
}

/// Edits all keys of a type of a part.
fn all_keys(window: &mut Window, desc: SceneDesc, part: Node, entry: &EntryDoc, faults: &mut Vec<String>) {
    let path = part.path(&desc.names()).unwrap();
    app(window).show(Document::of(desc, "Sample".into(), textures()));
    frames(window, 2);
    for field in entry.fields {
        let mut form = Form { window, part, path: path.clone(), faults };
        let name = format!("{} {}.{}", path, entry.name, field.name);
        match form.key(field) {
            Some(true) => {}
            Some(false) => {
                let said = seen(form.window).message.as_ref().map(|m| m.text.clone());
                faults.push(format!("{name}: takes no value; {said:?}"));
            }
            None if IN_THE_FILE.contains(&format!("{}.{}", entry.name, field.name).as_str()) => {}
            None => faults.push(format!("{name}: has no widget ({})", (field.kind)())),
        }
    }
}

fn check(faults: &[String]) {
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn shapes() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    for entry in ShapeDesc::DOC.entries {
        let text = match entry.name {
            "mesh" => "positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 2]]",
            "points" => "positions = [[0, 0, 0], [1, 0, 0]]\nradius = 0.1",
            _ => "",
        };
        let desc = with(&format!("[[object]]\nname = \"own\"\ntype = \"{}\"\n{text}\n", entry.name));
        let last = desc.objects.len() - 1;
        assert!(matches!(desc.objects[last].content, ObjectContent::Shape(_)));
        all_keys(&mut window, desc, Node::Object(last), entry, &mut faults);
    }
    check(&faults);
}

#[test]
fn lights() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    for entry in LightDesc::DOC.entries {
        let mut desc = with("");
        desc.lights[0].value = LightDesc::of_type(entry.name).unwrap();
        all_keys(&mut window, desc, Node::Light(0), entry, &mut faults);
    }
    check(&faults);
}

#[test]
fn materials() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    for entry in MaterialDesc::DOC.entries {
        let text = match entry.name {
            "mix" => "materials = [\"gold\", \"chalk\", \"unused\"]\nweights = [1, 2, 1]\n",
            _ => "",
        };
        let desc = with(&format!("[material.own]\ntype = \"{}\"\n{text}", entry.name));
        let last = desc.materials.iter().position(|m| m.name.as_deref() == Some("own")).unwrap();
        all_keys(&mut window, desc, Node::Material(last), entry, &mut faults);
    }
    check(&faults);
}

#[test]
fn textures_of_all_types() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    for entry in TextureDesc::DOC.entries {
        let text = match entry.name {
            "image" => "file = \"textures/wood.png\"",
            "mix" | "multiply" => "a = [1, 0, 0]\nb = [0, 0, 1]",
            "gradient" => "stops = [[0.25, [1, 0, 0]], [0.5, [0, 1, 0]]]",
            _ => "",
        };
        let desc = with(&format!("[texture.own]\ntype = \"{}\"\n{text}\n", entry.name));
        let last = desc.textures.iter().position(|m| m.name.as_deref() == Some("own")).unwrap();
        all_keys(&mut window, desc, Node::Texture(last), entry, &mut faults);
    }
    check(&faults);
}

#[test]
fn media() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    // A grid needs a file of its own format; its other keys are those of the other media.
    for entry in MediumDesc::DOC.entries.iter().filter(|entry| entry.name != "grid") {
        let mut desc = with("");
        desc.media[0].value = MediumDesc::of_type(entry.name).unwrap();
        all_keys(&mut window, desc, Node::Medium(0), entry, &mut faults);
    }
    check(&faults);
}

#[test]
fn cameras_and_views() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    for entry in CameraDesc::DOC.entries {
        let mut desc = with("");
        let camera = CameraDesc::of_type(entry.name).unwrap();
        desc.camera = Some(camera.clone().into());
        desc.cameras[0].value = camera;
        all_keys(&mut window, desc.clone(), Node::Camera, entry, &mut faults);
        all_keys(&mut window, desc, Node::View(0), entry, &mut faults);
    }
    check(&faults);
}

#[test]
fn integrators() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    for entry in IntegratorDesc::DOC.entries {
        let mut desc = with("");
        desc.integrator = IntegratorDesc::of_type(entry.name).unwrap();
        all_keys(&mut window, desc, Node::Integrator, entry, &mut faults);
    }
    check(&faults);
}

#[test]
fn film_background_and_studio() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    all_keys(&mut window, with(""), Node::Film, &FilmDesc::DOC, &mut faults);
    all_keys(&mut window, with(""), Node::Background, &BackgroundDesc::DOC, &mut faults);
    all_keys(&mut window, with("[studio]\n"), Node::Studio, &StudioDesc::DOC, &mut faults);
    check(&faults);
}

/// The keys that all objects have, and position, rotation and scale.
#[test]
fn what_all_objects_have() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let desc = with("");
    app(&mut window).show(Document::of(desc, "Sample".into(), textures()));
    let mut faults = Vec::new();
    let mut form =
        Form { window: &mut window, part: Node::Object(1), path: "object.1".into(), faults: &mut faults };
    let mut missing = Vec::new();
    for what in ["Position", "Rotation (degrees)", "Scale"] {
        for axis in ["x", "y", "z"] {
            let label = format!("{what}, {axis}");
            if !form.set_number(&label, &[0.5, 2.0], |form, _| form.value("transform").is_some()) {
                missing.push(label);
            }
        }
    }
    for key in ["hidden", "shadow_catcher"] {
        let label = key.replace('_', " ");
        let act = |window: &mut Window| click(window, Role::CheckBox, &label);
        if !form.step(key, act, |form| form.value(key) == Some(Data::Bool(true))) {
            missing.push(label);
        }
    }
    for key in ["name", "light_group"] {
        let label = key.replace('_', " ");
        let act = |window: &mut Window| {
            node(window, Role::TextInput, &label).unwrap().focus();
            frames(window, 2);
            write(window, "q");
        };
        if !form.step(
            key,
            act,
            |form| matches!(form.value(key), Some(Data::String(text)) if text.contains('q')),
        ) {
            missing.push(label);
        }
    }
    let is_chalk = |form: &Form<'_>| form.value("material") == Some(Data::String("chalk".into()));
    if !form.choose("material", "chalk", is_chalk) {
        missing.push("material".into());
    }
    assert!(missing.is_empty(), "{missing:?}");
    check(&faults);
}

/// Each type of each family in the list of types: the part becomes one, or the window says why it cannot.
#[test]
fn types_change_by_their_list() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    let parts =
        [Node::Object(1), Node::Light(0), Node::Material(0), Node::Texture(0), Node::Medium(0), Node::Camera];
    for part in parts.into_iter().chain([Node::View(0), Node::Integrator]) {
        let desc = with("");
        let path = part.path(&desc.names()).unwrap();
        let first = desc.value_at(&format!("{path}.type")).unwrap().map(|value| value.data);
        app(&mut window).show(Document::of(desc, "Sample".into(), textures()));
        for entry in part.family().unwrap().entries {
            if first == Some(Data::String(entry.name.to_owned())) {
                continue;
            }
            let mut form = Form { window: &mut window, part, path: path.clone(), faults: &mut faults };
            let is_it =
                |form: &Form<'_>| form.value("type").is_none_or(|v| v == Data::String(entry.name.to_owned()));
            let done = form.choose("Type", entry.name, is_it);
            let said = seen(&window).message.as_ref().is_some_and(|message| message.is_error);
            if !done && !said {
                faults.push(format!("{path}: {} neither chosen nor refused", entry.name));
            }
        }
    }
    check(&faults);
}

/// A picture file for a key that takes colours, by the dialog; and a file that its key does not take.
#[test]
fn files_are_chosen() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    app(&mut window).show(Document::of(with(""), "Sample".into(), textures()));
    let choose = |window: &mut Window| {
        assert!(matches!(seen(window).dialog, Some(Dialog::File { purpose: Purpose::Key(..), .. })));
        press(window, Modifiers::COMMAND, Key::A);
        write(window, &textures().join("textures/wood.png").to_string_lossy());
        press(window, Modifiers::NONE, Key::Enter);
    };
    app(&mut window).selection = Some(Node::Material(1));
    frames(&mut window, 2);
    click(&mut window, Role::ComboBox, "color texture");
    click(&mut window, Role::Button, "image file…");
    choose(&mut window);
    let desc = seen(&window).document.desc().clone();
    assert_eq!(desc.images.len(), 1, "{:?}", seen(&window).message);
    assert_eq!(desc.images[0].uri, "textures/wood.png");
    // A lamp takes no picture: the scene stays, and the window says why.
    app(&mut window).selection = Some(Node::Light(0));
    frames(&mut window, 2);
    click(&mut window, Role::Button, "ies");
    choose(&mut window);
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &desc));
    assert!(seen(&window).message.as_ref().is_some_and(|message| message.is_error));
}
