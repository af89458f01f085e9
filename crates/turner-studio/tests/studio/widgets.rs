//! Every key of every type has a widget, and compound values are edited by theirs.

use egui::accesskit::Role;
use turner::SceneDesc;
use turner::camera::CameraDesc;
use turner::description::{ModelDesc, StudioDesc};
use turner::film::FilmDesc;
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::EntryDoc;
use turner::schema::value::{Data, Value};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_studio::node::Node;

use super::common::*;

/// Roles of what changes a value.
const WIDGETS: &[Role] = &[
    Role::CheckBox,
    Role::SpinButton,
    Role::ComboBox,
    Role::TextInput,
    Role::Button,
    Role::ColorWell,
    Role::Slider,
];

/// Whether a key has a widget: one whose name is the key, or begins with it.
fn has_widget(window: &Window, key: &str) -> bool {
    use egui_kittest::kittest::NodeT;
    let label = key.replace('_', " ");
    window.root().children_recursive().any(|node| {
        let node = node.accesskit_node();
        let is_own = |name: &str| {
            name == label
                || name.strip_prefix(&label).is_some_and(|rest| rest.starts_with([',', ' ']))
                || name == format!("Add to {label}")
        };
        WIDGETS.contains(&node.role()) && node.label().is_some_and(|name| is_own(&name))
    })
}

fn assert_all(window: &mut Window, desc: SceneDesc, part: Node, entry: &EntryDoc, missing: &mut Vec<String>) {
    show(window, desc);
    app(window).selection = Some(part);
    frames(window, 3);
    for field in entry.fields {
        if !has_widget(window, field.name) {
            missing.push(format!("{}.{} ({})", entry.name, field.name, (field.kind)()));
        }
    }
}

#[test]
fn every_key_of_every_type_has_a_widget() {
    let (mut window, _home) = window([1800.0, 3000.0], 1.0);
    let window = &mut window;
    let mut missing = Vec::new();
    for entry in ShapeDesc::DOC.entries {
        let Some(data) = shape_keys(entry.name) else { continue };
        let desc = scene(&format!("{SAMPLE}\n[[object]]\ntype = \"{}\"\n{data}", entry.name));
        assert_all(window, desc, Node::Object(3), entry, &mut missing);
    }
    for entry in LightDesc::DOC.entries {
        let mut desc = scene(SAMPLE);
        desc.lights[0].value = LightDesc::of_type(entry.name).unwrap();
        assert_all(window, desc, Node::Light(0), entry, &mut missing);
    }
    for entry in MaterialDesc::DOC.entries {
        let data = if entry.name == "mix" { "materials = [\"gold\", \"chalk\"]" } else { "" };
        // "measured" is not read without a file.
        let read = if entry.name == "measured" { "matte" } else { entry.name };
        let mut desc = scene(&format!("{SAMPLE}\n[material.own]\ntype = \"{read}\"\n{data}"));
        if read != entry.name {
            desc.materials[3].value = MaterialDesc::of_type(entry.name).unwrap();
        }
        assert_all(window, desc, Node::Material(3), entry, &mut missing);
    }
    // A texture "image" needs a file, which the tests of the form of textures read.
    for entry in TextureDesc::DOC.entries.iter().filter(|entry| entry.name != "image") {
        let mut desc = scene(SAMPLE);
        desc.textures[0].value = TextureDesc::of_type(entry.name).unwrap();
        assert_all(window, desc, Node::Texture(0), entry, &mut missing);
    }
    for entry in MediumDesc::DOC.entries.iter().filter(|entry| entry.name != "grid") {
        let mut desc = scene(SAMPLE);
        desc.media[0].value = MediumDesc::of_type(entry.name).unwrap();
        assert_all(window, desc, Node::Medium(0), entry, &mut missing);
    }
    for entry in CameraDesc::DOC.entries {
        let mut desc = scene(SAMPLE);
        desc.camera = Some(CameraDesc::of_type(entry.name).unwrap().into());
        assert_all(window, desc, Node::Camera, entry, &mut missing);
    }
    for entry in IntegratorDesc::DOC.entries {
        let mut desc = scene(SAMPLE);
        desc.integrator = IntegratorDesc::of_type(entry.name).unwrap();
        assert_all(window, desc, Node::Integrator, entry, &mut missing);
    }
    assert_all(window, scene(SAMPLE), Node::Film, &FilmDesc::DOC, &mut missing);
    assert_all(window, scene(SAMPLE), Node::Background, &BackgroundDesc::DOC, &mut missing);
    assert_all(window, scene(&format!("{SAMPLE}\n[studio]\n")), Node::Studio, &StudioDesc::DOC, &mut missing);
    assert!(missing.is_empty(), "{} keys without a widget:\n{}", missing.len(), missing.join("\n"));
}

/// The value at a key path of the scene.
fn value(window: &Window, path: &str) -> Option<Data> {
    seen(window).document.desc().value_at(path).unwrap().map(|value| value.data)
}

fn numbers(values: &[f64]) -> Data {
    Data::Array(values.iter().map(|v| Value::new(Data::Number(*v))).collect())
}

#[test]
fn attenuation_is_chosen_and_its_coefficients_are_numbers() {
    let (mut window, _home) = window([1400.0, 1400.0], 1.0);
    show(&mut window, scene(SAMPLE));
    app(&mut window).selection = Some(Node::Light(0));
    frames(&mut window, 2);
    let choose = |window: &mut Window, entry: &str| {
        click(window, Role::ComboBox, "attenuation");
        click(window, Role::Button, entry);
        // A list that is still open closes.
        press(window, egui::Modifiers::NONE, egui::Key::Escape);
        app(window).selection = Some(Node::Light(0));
        frames(window, 2);
    };
    choose(&mut window, "inverse-square");
    assert_eq!(value(&window, "light.0.attenuation"), Some(Data::String("inverse-square".into())));
    choose(&mut window, "constant, linear, quadratic");
    node(&window, Role::SpinButton, "attenuation, linear").unwrap().set_value_accesskit(0.25);
    frames(&mut window, 2);
    assert_eq!(value(&window, "light.0.attenuation"), Some(numbers(&[1.0, 0.25, 1.0])));
    app(&mut window).document.undo();
    frames(&mut window, 2);
    assert_ne!(value(&window, "light.0.attenuation"), Some(numbers(&[1.0, 0.25, 1.0])));
}

#[test]
fn lists_grow_and_shrink() {
    let (mut window, _home) = window([1400.0, 1400.0], 1.0);
    let text = "[material.own]\ntype = \"mix\"\nmaterials = [\"gold\", \"chalk\"]\n[texture.own]\ntype = \"gradient\"\n";
    show(&mut window, scene(&format!("{SAMPLE}\n{text}")));
    let count = |window: &Window, path: &str| match value(window, path) {
        Some(Data::Array(items)) => items.len(),
        _ => 0,
    };
    app(&mut window).selection = Some(Node::Material(3));
    frames(&mut window, 2);
    click(&mut window, Role::ComboBox, "materials 1");
    click(&mut window, Role::Button, "unused");
    let Some(Data::Array(items)) = value(&window, "material.own.materials") else { panic!() };
    assert_eq!(items[0].data, Data::String("unused".into()));
    app(&mut window).selection = Some(Node::Texture(2));
    frames(&mut window, 2);
    click(&mut window, Role::Button, "Add to stops");
    click(&mut window, Role::Button, "Add to stops");
    assert_eq!(count(&window, "texture.own.stops"), 2);
    node(&window, Role::SpinButton, "stops 1, position").unwrap().set_value_accesskit(0.25);
    frames(&mut window, 2);
    click(&mut window, Role::Button, "Remove stops 2");
    assert_eq!(count(&window, "texture.own.stops"), 1);
    // A film's AOVs are switches in a list.
    app(&mut window).selection = Some(Node::Film);
    frames(&mut window, 2);
    click(&mut window, Role::ComboBox, "aovs");
    click(&mut window, Role::CheckBox, "normal");
    assert_eq!(
        value(&window, "film.aovs"),
        Some(Data::Array(vec![Value::new(Data::String("normal".into()))]))
    );
}

#[test]
fn motion_is_given_and_taken() {
    let (mut window, _home) = window([1400.0, 1400.0], 1.0);
    show(&mut window, scene(SAMPLE));
    app(&mut window).selection = Some(Node::Object(1));
    frames(&mut window, 2);
    click(&mut window, Role::Button, "motion");
    let motion = |window: &Window| seen(window).document.desc().objects[1].motion;
    assert!(motion(&window).is_some());
    node(&window, Role::SpinButton, "motion, Position, x").unwrap().set_value_accesskit(2.0);
    frames(&mut window, 2);
    assert_eq!(motion(&window).map(|motion| motion.0.translation.x), Some(2.0));
    click(&mut window, Role::Button, "Default of motion");
    assert!(motion(&window).is_none());
}

/// A box is given by its corners, or by its centre and size. Each click leaves a scene that can be rendered, and the box
/// where it is.
#[test]
fn the_keys_of_a_box_go_together() {
    let (mut window, _home) = window([1400.0, 1400.0], 1.0);
    show(&mut window, scene(SAMPLE));
    let keys = |window: &Window| {
        let desc = seen(window).document.desc();
        desc.prepare(&Default::default()).unwrap_or_else(|e| panic!("{}", e.message));
        ["min", "max", "center", "size"].map(|key| value(window, &format!("object.2.{key}")))
    };
    app(&mut window).selection = Some(Node::Object(2));
    frames(&mut window, 2);
    for key in ["min", "max"] {
        click(&mut window, Role::Button, key);
        assert_eq!(keys(&window), [Some(numbers(&[-1.0; 3])), Some(numbers(&[1.0; 3])), None, None]);
        app(&mut window).document.undo();
        frames(&mut window, 2);
    }
    click(&mut window, Role::Button, "min");
    set(&mut window, "max, y", 3.0);
    click(&mut window, Role::Button, "size");
    let center = Some(numbers(&[0.0, 1.0, 0.0]));
    assert_eq!(keys(&window), [None, None, center, Some(numbers(&[2.0, 4.0, 2.0]))]);
    click(&mut window, Role::Button, "max");
    click(&mut window, Role::Button, "Default of min");
    assert_eq!(keys(&window), [None, None, None, None]);
}

/// A directional light has a direction or its opposite: each click keeps where its rays go.
#[test]
fn a_direction_takes_the_place_of_its_opposite() {
    let (mut window, _home) = window([1400.0, 1400.0], 1.0);
    show(&mut window, scene(SAMPLE));
    app(&mut window).selection = Some(Node::Light(1));
    frames(&mut window, 2);
    for (key, other, v) in [("direction", "from", [-1.0, -3.0, -2.0]), ("from", "direction", [1.0, 3.0, 2.0])]
    {
        click(&mut window, Role::Button, key);
        assert_eq!(value(&window, &format!("light.1.{key}")), Some(numbers(&v)));
        assert_eq!(value(&window, &format!("light.1.{other}")), None);
        let prepared = seen(&window).document.desc().prepare(&Default::default());
        assert!(prepared.is_ok(), "{key}: {:?}", prepared.err().map(|e| e.message));
    }
}

/// A placed model: its keys have widgets, and a change reads the file again.
#[test]
fn keys_of_models_are_edited() {
    let folder = tempfile::tempdir().unwrap();
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no one\nusemtl paint\nf 1 2 3\no two\nf 1 3 2\n";
    std::fs::write(folder.path().join("m.obj"), obj).unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl paint\nKd 1 0 0\n").unwrap();
    let text = format!("{SAMPLE}\n[[object]]\nname = \"placed\"\ntype = \"model\"\nfile = \"m.obj\"\n");
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let (mut window, _home) = window([1600.0, 1600.0], 1.0);
    let document = turner_live::document::Document::open(&folder.path().join("s.toml")).unwrap();
    app(&mut window).show(document);
    app(&mut window).selection = Some(Node::Object(3));
    frames(&mut window, 3);
    let missing: Vec<&str> = ModelDesc::DOC
        .fields
        .iter()
        .map(|field| field.name)
        .filter(|key| !has_widget(&window, key))
        .collect();
    assert!(missing.is_empty(), "{missing:?} {:?}", names(&window));
    let before = seen(&window).document.desc().clone();
    click(&mut window, Role::ComboBox, "up");
    click(&mut window, Role::Button, "z");
    let desc = seen(&window).document.desc().clone();
    assert_eq!(desc.model_of(3).map(|model| model.up), Some(turner::description::UpAxis::Z));
    assert_eq!(desc.objects[3].name.as_deref(), Some("placed"));
    assert_eq!((desc.objects.len(), desc.groups.len()), (before.objects.len(), before.groups.len()));
    // A slot of the model gets a material of the scene.
    node(&window, Role::TextInput, "materials, new name").unwrap().focus();
    frames(&mut window, 2);
    write(&mut window, "paint");
    click(&mut window, Role::Button, "Add to materials");
    let slots = |desc: &SceneDesc| desc.model_keys(3).unwrap().unwrap().get("materials").cloned();
    assert!(slots(seen(&window).document.desc()).is_some(), "{:?}", seen(&window).message);
    click(&mut window, Role::ComboBox, "materials, paint");
    click(&mut window, Role::Button, "chalk");
    let Some(Value { data: Data::Table(table), .. }) = slots(seen(&window).document.desc()) else { panic!() };
    assert_eq!(table.get("paint").map(|value| &value.data), Some(&Data::String("chalk".into())));
    // What is saved is read as the same scene.
    let file = folder.path().join("saved.toml");
    let saving = seen(&window).document.save(&file, || {});
    let saved = loop {
        match app(&mut window).document.saved(&saving) {
            Some(saved) => break saved.unwrap_or_else(|e| panic!("{}", e.message)),
            None => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    };
    assert!(saved.kept_text, "{:?}", saved.notes);
    let again = turner_live::document::Document::open(&file).unwrap_or_else(|e| panic!("{}", e.message));
    again.desc().same_apart_from_order(seen(&window).document.desc()).unwrap();
}
