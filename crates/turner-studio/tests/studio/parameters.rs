//! Every key of every type of every family, edited through its widget, undone and redone. The lists come from the schema.

use std::path::Path;
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
use turner::schema::MeasuredFile;
use turner::schema::value::Data;
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_live::document::Document;
use turner_studio::node::Node;
use turner_studio::studio::{Dialog, Purpose};

use super::common::*;
use super::forms::*;

#[test]
fn shapes() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    for entry in ShapeDesc::DOC.entries {
        let Some(text) = shape_keys(entry.name) else { continue };
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

/// The sample scene with more lines, read from a folder that has a file called `name`.
fn opened(name: &str, bytes: &[u8], text: &str) -> (tempfile::TempDir, SceneDesc) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), bytes).unwrap();
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, format!("{SAMPLE}\n{text}")).unwrap();
    let document = Document::open(&file).unwrap_or_else(|e| panic!("{}", e.message));
    (folder, SceneDesc::clone(document.desc()))
}

#[test]
fn materials() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    let mut faults = Vec::new();
    // A measured BRDF is read from a file.
    for entry in MaterialDesc::DOC.entries.iter().filter(|entry| entry.name != "measured") {
        let text = match entry.name {
            "mix" => "materials = [\"gold\", \"chalk\", \"unused\"]\nweights = [1, 2, 1]\n",
            _ => "",
        };
        let desc = with(&format!("[material.own]\ntype = \"{}\"\n{text}", entry.name));
        let last = desc.materials.iter().position(|m| m.name.as_deref() == Some("own")).unwrap();
        all_keys(&mut window, desc, Node::Material(last), entry, &mut faults);
    }
    let mut bytes = Vec::new();
    turner_io::measured::write(&MeasuredFile::default().data, &mut bytes).unwrap();
    let (folder, desc) =
        opened("paint.bsdf", &bytes, "[material.own]\ntype = \"measured\"\nfile = \"paint.bsdf\"\n");
    let own = desc.materials.iter().position(|m| m.name.as_deref() == Some("own")).unwrap();
    let entry = MaterialDesc::DOC.entries.iter().find(|entry| entry.name == "measured").unwrap();
    all_keys_in(&mut window, desc, folder.path(), Node::Material(own), entry, &mut faults);
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
    for entry in MediumDesc::DOC.entries.iter().filter(|entry| entry.name != "grid") {
        let mut desc = with("");
        desc.media[0].value = MediumDesc::of_type(entry.name).unwrap();
        all_keys(&mut window, desc, Node::Medium(0), entry, &mut faults);
    }
    // A grid is read from a file.
    let mut bytes = b"turner-grid 1\nsize 2 1 1\nchannels density\ndata\n".to_vec();
    bytes.extend([1.0f32, 0.5].into_iter().flat_map(f32::to_le_bytes));
    let (folder, desc) =
        opened("smoke.grid", &bytes, "[medium.smoke]\ntype = \"grid\"\nfile = \"smoke.grid\"\n");
    let smoke = desc.media.iter().position(|medium| medium.name.as_deref() == Some("smoke")).unwrap();
    let entry = MediumDesc::DOC.entries.iter().find(|entry| entry.name == "grid").unwrap();
    all_keys_in(&mut window, desc, folder.path(), Node::Medium(smoke), entry, &mut faults);
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
    for key in ["hidden", "hidden_from_camera", "shadow_catcher"] {
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
            let problem = std::cell::Cell::new(None);
            let is_it = |form: &Form<'_>| {
                problem.set(form.desc().prepare(&Default::default()).err());
                form.value("type").is_none_or(|v| v == Data::String(entry.name.to_owned()))
            };
            let done = form.choose("Type", entry.name, is_it);
            if let Some(problem) = problem.take() {
                faults.push(format!("{path}: {} cannot be rendered: {}", entry.name, problem.message));
            }
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
    let choose = |window: &mut Window, file: &Path| {
        assert!(matches!(seen(window).dialog, Some(Dialog::File { purpose: Purpose::Key(..), .. })));
        press(window, Modifiers::COMMAND, Key::A);
        write(window, &file.to_string_lossy());
        press(window, Modifiers::NONE, Key::Enter);
    };
    app(&mut window).selection = Some(Node::Material(1));
    frames(&mut window, 2);
    click(&mut window, Role::ComboBox, "color texture");
    click(&mut window, Role::Button, "image file…");
    choose(&mut window, &textures().join("textures/wood.png"));
    let desc = seen(&window).document.desc().clone();
    assert_eq!(desc.images.len(), 1, "{:?}", seen(&window).message);
    assert_eq!(desc.images[0].uri, "textures/wood.png");
    // A lamp takes no picture: the scene stays, and the window says why.
    app(&mut window).selection = Some(Node::Light(0));
    frames(&mut window, 2);
    click(&mut window, Role::Button, "ies");
    choose(&mut window, &textures().join("textures/wood.png"));
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &desc));
    assert!(seen(&window).message.as_ref().is_some_and(|message| message.is_error));
    // The file of a mesh is another model.
    let folder = tempfile::tempdir().unwrap();
    let model = |name: &str, z: f64| {
        let file = folder.path().join(name);
        std::fs::write(&file, format!("v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf 1 2 3\n")).unwrap();
        file
    };
    let (_, other) = (model("a.obj", 0.0), model("b.obj", 1.0));
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, "[[object]]\ntype = \"mesh\"\nfile = \"a.obj\"\n").unwrap();
    app(&mut window).show(Document::open(&file).unwrap_or_else(|e| panic!("{}", e.message)));
    app(&mut window).selection = Some(Node::Object(0));
    frames(&mut window, 2);
    click(&mut window, Role::Button, "file");
    one_step(&mut window, "the file of a mesh", |window| {
        choose(window, &other);
        let desc = seen(window).document.desc();
        let file = desc.value_at("object.0.file").unwrap().map(|value| value.data);
        assert_eq!(file, Some(Data::String("b.obj".into())), "{:?}", seen(window).message);
    });
}

/// Buttons beside references lead to the parts that they name; a colour takes the place of a texture again.
#[test]
fn references_lead_to_their_parts() {
    let (mut window, _home) = window([1800.0, 2400.0], 1.0);
    app(&mut window).show(Document::of(with(""), "Sample".into(), textures()));
    let desc = seen(&window).document.desc().clone();
    let material = |name: &str| {
        let found = desc.materials.iter().position(|material| material.name.as_deref() == Some(name));
        Node::Material(found.unwrap())
    };
    app(&mut window).selection = Some(Node::Object(1));
    frames(&mut window, 2);
    click(&mut window, Role::Button, "Show");
    assert_eq!(seen(&window).selection, Some(material("gold")));
    app(&mut window).selection = Some(material("chalk"));
    frames(&mut window, 2);
    choose(&mut window, "color texture", "squares");
    let color = |window: &Window| {
        seen(window).document.desc().value_at("material.chalk.color").unwrap().unwrap().data
    };
    assert_eq!(color(&window), Data::String("squares".into()));
    one_step(&mut window, "another texture", |window| choose(window, "color texture", "dots"));
    one_step(&mut window, "a colour again", |window| {
        choose(window, "color texture", "colour");
        // A grey is one number.
        assert!(matches!(color(window), Data::Array(_) | Data::Number(_)), "{:?}", color(window));
    });
    click(&mut window, Role::Button, "color");
    let Some(Node::Texture(shown)) = seen(&window).selection else { panic!("{:?}", seen(&window).selection) };
    assert_eq!(desc.textures[shown].name.as_deref(), Some("squares"));
    // An object without its material.
    app(&mut window).selection = Some(Node::Object(1));
    frames(&mut window, 2);
    one_step(&mut window, "no material", |window| {
        choose(window, "material", "none");
        assert!(seen(window).document.desc().objects[1].material.is_none());
    });
}
