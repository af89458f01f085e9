//! Everything by keyboard alone: the palette, dialogs, shortcuts, the way through all widgets.

use std::collections::BTreeSet;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::NodeT;
use turner_studio::actions::Action;
use turner_studio::node::Node;
use turner_studio::studio::{Dialog, Purpose};
use turner_studio::viewport::Tool;

use super::common::*;

#[test]
fn the_palette_adds_a_light_by_keyboard() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let lights = seen(&window).document.desc().lights.len();
    press(&mut window, Modifiers::COMMAND, Key::K);
    write(&mut window, "add point light");
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(seen(&window).document.desc().lights.len(), lights + 1);
    assert_eq!(seen(&window).selection, Some(Node::Light(lights)));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(seen(&window).document.desc().lights.len(), lights);
}

/// Arrows choose another entry, Escape closes without doing anything, an unknown name does nothing.
#[test]
fn the_palette_by_arrows_and_escape() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let first = seen(&window).document.desc().clone();
    press(&mut window, Modifiers::COMMAND, Key::K);
    write(&mut window, "dark or light");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(seen(&window).viewport.palette.is_none());
    let theme = seen(&window).settings.theme;
    press(&mut window, Modifiers::COMMAND, Key::K);
    assert_eq!(seen(&window).viewport.palette.as_deref(), Some(""), "it opens empty");
    write(&mut window, "no command has this name");
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(std::sync::Arc::ptr_eq(seen(&window).document.desc(), &first));
    press(&mut window, Modifiers::NONE, Key::Escape);
    // "Show depth" and the next one.
    press(&mut window, Modifiers::COMMAND, Key::K);
    write(&mut window, "show");
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    press(&mut window, Modifiers::NONE, Key::Enter);
    let mut shown = Action::all();
    shown.retain(|a| a.is_possible(seen(&window)) && a.label().to_lowercase().contains("show"));
    let Action::Show(expected) = shown[1] else { panic!("{:?}", shown[1]) };
    let integrator = seen(&window).look.integrator.as_ref().map(|integrator| integrator.type_name());
    assert_eq!(integrator, expected);
    assert_eq!(seen(&window).settings.theme, theme);
}

/// What an action can change.
fn state(window: &Window) -> String {
    let studio = seen(window);
    let (view, settings) = (&studio.viewport, &studio.settings);
    let camera = studio.document.desc().camera.as_ref().map(|camera| &camera.value);
    format!(
        "{:?} {:?} {:?} {camera:?} {:?} {:?} {:?} {:?} {:?} {:?} {} {} {}",
        studio.document.steps(),
        studio.selection,
        studio.dialog,
        view.tool,
        view.palette,
        view.explained,
        studio.message,
        settings.theme,
        studio.look,
        settings.zoom,
        studio.paused,
        studio.quit,
    )
}

/// Each shortcut of the table does its action and no other, as the menu would.
#[test]
fn every_shortcut_does_its_action() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let with_shortcut: Vec<Action> = Action::all().into_iter().filter(|a| a.shortcut().is_some()).collect();
    for action in with_shortcut {
        let start = |window: &mut Window| {
            show(window, scene(SAMPLE));
            has_picture(window);
            let studio = app(window);
            (studio.paused, studio.quit, studio.dialog) = (true, false, None);
            (studio.settings.zoom, studio.settings.theme) = (1.0, turner_studio::settings::Theme::Dark);
            // Steps to undo and to redo.
            for samples in [2, 3] {
                let data = turner::schema::value::Data::Integer(samples);
                studio.document.set("Samples", None, &[("film.samples".into(), data)]).unwrap();
            }
            studio.document.undo();
            studio.selection = Some(Node::Object(1));
            frames(window, 3);
            has_picture(window);
        };
        start(&mut window);
        let before = state(&window);
        app(&mut window).queue.push(action);
        frames(&mut window, 3);
        let wanted = state(&window);
        start(&mut window);
        assert_eq!(state(&window), before, "{action:?}: the start is another one");
        let shortcut = action.shortcut().unwrap();
        press(&mut window, shortcut.modifiers, shortcut.logical_key);
        frames(&mut window, 1);
        assert_eq!(state(&window), wanted, "{action:?}");
        let quiet = [Action::Reload, Action::GoToProperties, Action::Ungroup, Action::ToolSelect];
        assert!(wanted != before || quiet.contains(&action), "{action:?} changes nothing");
    }
}

#[test]
fn tools_have_keys() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let tools = [
        (Key::G, Tool::Move),
        (Key::R, Tool::Rotate),
        (Key::T, Tool::Scale),
        (Key::C, Tool::Focus),
        (Key::X, Tool::Explain),
        (Key::Q, Tool::Select),
    ];
    for (key, tool) in tools {
        press(&mut window, Modifiers::NONE, key);
        assert_eq!(seen(&window).viewport.tool, tool);
    }
}

/// Letters that are written into a field are no commands.
#[test]
fn writing_does_not_run_commands() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    app(&mut window).selection = Some(Node::Object(1));
    frames(&mut window, 2);
    node(&window, Role::TextInput, "Search the scene").unwrap().focus();
    frames(&mut window, 2);
    for key in [Key::G, Key::Delete, Key::Space, Key::F] {
        window.key_press(key);
        frames(&mut window, 2);
    }
    let studio = seen(&window);
    assert_eq!(studio.viewport.tool, Tool::Select);
    assert_eq!(studio.document.desc().objects.len(), 3);
    assert!(studio.paused && !studio.document.is_changed());
}

#[test]
fn a_file_is_opened_by_keyboard() {
    let (mut window, home) = sample([1400.0, 900.0]);
    let file = home.path().join("other.toml");
    std::fs::write(&file, "[[object]]\ntype = \"sphere\"\n").unwrap();
    press(&mut window, Modifiers::COMMAND, Key::O);
    assert!(matches!(seen(&window).dialog, Some(Dialog::File { purpose: Purpose::Open, .. })));
    press(&mut window, Modifiers::COMMAND, Key::A);
    write(&mut window, &file.to_string_lossy());
    press(&mut window, Modifiers::NONE, Key::Enter);
    until(&mut window, "the other file", |studio| studio.document.path() == Some(&file));
    assert!(seen(&window).dialog.is_none());
    assert_eq!(seen(&window).document.desc().objects.len(), 1);
    // Escape closes the dialog and opens nothing.
    press(&mut window, Modifiers::COMMAND, Key::O);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(seen(&window).dialog.is_none());
    assert_eq!(seen(&window).document.path(), Some(file.as_path()));
}

/// Delete, duplicate and select nothing, by their keys.
#[test]
fn parts_are_edited_by_keys() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    app(&mut window).selection = Some(Node::Object(1));
    frames(&mut window, 1);
    press(&mut window, Modifiers::COMMAND, Key::D);
    assert_eq!(seen(&window).document.desc().objects.len(), 4);
    assert_eq!(seen(&window).selection, Some(Node::Object(3)));
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(seen(&window).document.desc().objects.len(), 3);
    assert_eq!(seen(&window).selection, None);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!seen(&window).document.is_changed());
}

/// Tab reaches every widget that can be used.
#[test]
fn tab_goes_through_all_widgets() {
    let (mut window, _home) = sample([1400.0, 1400.0]);
    app(&mut window).selection = Some(Node::Object(1));
    frames(&mut window, 3);
    let inputs =
        [Role::Button, Role::CheckBox, Role::ComboBox, Role::SpinButton, Role::TextInput, Role::ColorWell];
    let of_input = |node: &egui_kittest::Node<'_>| {
        let node = node.accesskit_node();
        (inputs.contains(&node.role()) && !node.is_disabled())
            .then(|| format!("{:?} {:?}", node.role(), node.label()))
    };
    let wanted: BTreeSet<String> = window.root().children_recursive().filter_map(|n| of_input(&n)).collect();
    assert!(wanted.len() > 40, "{wanted:?}");
    let mut reached = BTreeSet::new();
    for _ in 0..3 * wanted.len() {
        window.key_press(Key::Tab);
        frames(&mut window, 1);
        reached.extend(
            window.root().children_recursive().filter(|n| n.is_focused()).filter_map(|n| of_input(&n)),
        );
    }
    let missed: Vec<&String> = wanted.difference(&reached).collect();
    assert!(missed.is_empty(), "not reached by Tab: {missed:?}");
    assert!(!seen(&window).document.is_changed(), "{:?}", seen(&window).document.steps().0);
}

/// From an object to its material and to a value of it.
#[test]
fn a_material_is_edited_by_keyboard() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    app(&mut window).selection = Some(Node::Object(1));
    frames(&mut window, 2);
    press(&mut window, Modifiers::NONE, Key::M);
    let desc = seen(&window).document.desc().clone();
    let gold = desc.materials.iter().position(|material| material.name.as_deref() == Some("gold")).unwrap();
    assert_eq!(seen(&window).selection, Some(Node::Material(gold)));
    press(&mut window, Modifiers::NONE, Key::E);
    // The button for another name, the type, the picker of the first colour, its red part.
    for _ in 0..4 {
        press(&mut window, Modifiers::NONE, Key::Tab);
    }
    write(&mut window, "0.5");
    press(&mut window, Modifiers::NONE, Key::Enter);
    let value = seen(&window).document.desc().value_at("material.gold.base_weight").unwrap();
    let Some(turner::schema::value::Data::Array(parts)) = value.map(|value| value.data) else {
        panic!("no colour")
    };
    assert_eq!(parts[0].data, turner::schema::value::Data::Number(0.5));
}
