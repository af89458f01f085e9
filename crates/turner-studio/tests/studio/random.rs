//! A thousand random actions: clicks, keys, drags and values, wherever the window has something to act on.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Vec2};
use egui_kittest::Node as Widget;
use egui_kittest::kittest::NodeT;
use turner::SceneDesc;
use turner_live::document::Document;
use turner_studio::studio::{Dialog, Purpose};

use super::common::*;

/// What would leave the scene, or the folder of the test.
fn is_left_out(label: &str) -> bool {
    let starts = turner_live::document::STARTS.iter().any(|start| start.name == label);
    let named = [
        "Quit",
        "New",
        "Open",
        "Open…",
        "Empty stage",
        "..",
        "Don't save",
        "System dialog…",
        "Add to the queue",
        "Open the folder",
        "Resume",
    ];
    starts
        || label.ends_with('/')
        || named.iter().any(|name| label == *name || label.starts_with(&format!("{name} Ctrl")))
}

fn widgets(window: &Window) -> Vec<Widget<'_>> {
    let roles = [
        Role::Button,
        Role::CheckBox,
        Role::ComboBox,
        Role::SpinButton,
        Role::TextInput,
        Role::ColorWell,
        Role::Image,
    ];
    let all = window.root().children_recursive();
    let usable = all.filter(|n| {
        let n = n.accesskit_node();
        roles.contains(&n.role()) && !n.is_disabled() && !n.label().is_some_and(|label| is_left_out(&label))
    });
    usable.collect()
}

const PLAIN: &[Key] = &[
    Key::Delete,
    Key::Escape,
    Key::Enter,
    Key::Tab,
    Key::ArrowUp,
    Key::ArrowDown,
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::F,
    Key::Home,
    Key::Q,
    Key::G,
    Key::R,
    Key::T,
    Key::C,
    Key::X,
    Key::Space,
    Key::Backspace,
];
const WITH_COMMAND: &[Key] = &[Key::Z, Key::D, Key::K, Key::B, Key::Plus, Key::Minus, Key::A];
const TEXTS: &[&str] = &["1", "0.5", "-3", "frame", "add", "show", "e", "12", "", "ball", "…", "\u{1F600}"];

fn drag(window: &mut Window, rect: Rect, random: &mut Random) {
    let place = |random: &mut Random| {
        let at = Vec2::new(random.below(1000) as f32, random.below(1000) as f32) / 1000.0;
        Pos2::new(rect.left() + rect.width() * at.x, rect.top() + rect.height() * at.y)
    };
    let button = random.of(&[
        PointerButton::Primary,
        PointerButton::Primary,
        PointerButton::Middle,
        PointerButton::Secondary,
    ]);
    let modifiers = if random.below(4) == 0 { Modifiers::SHIFT } else { Modifiers::NONE };
    let press = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers };
    let mut at = place(random);
    window.event(Event::PointerMoved(at));
    window.event(press(at, true));
    for _ in 0..random.below(4) {
        at = place(random);
        window.event(Event::PointerMoved(at));
    }
    window.event(press(at, false));
    frames(window, 1);
}

/// One random action. Returns its description.
fn act(window: &mut Window, random: &mut Random) -> String {
    let list = widgets(window);
    let chosen = random.below(list.len().max(1));
    let what = list.get(chosen).map(|w| (w.accesskit_node().role(), w.accesskit_node().label(), w.rect()));
    match random.below(12) {
        0..=4 => {
            if let Some(widget) = list.get(chosen) {
                widget.click_accesskit();
            }
        }
        5 => {
            if let Some(widget) = list.get(chosen) {
                if random.below(4) == 0 { widget.click_secondary() } else { widget.click() }
            }
        }
        6 => {
            let numbers: Vec<&Widget<'_>> =
                list.iter().filter(|w| w.accesskit_node().role() == Role::SpinButton).collect();
            if !numbers.is_empty() {
                numbers[random.below(numbers.len())]
                    .set_value_accesskit(random.of(&[-1.0, 0.0, 0.3, 1.0, 2.0, 17.0, 1e9]));
            }
        }
        7 => {
            let key = random.of(PLAIN);
            window.key_press(key);
            drop(list);
            frames(window, 2);
            return format!("{key:?}");
        }
        8 => {
            let key = random.of(WITH_COMMAND);
            window.key_press_modifiers(Modifiers::COMMAND, key);
            drop(list);
            frames(window, 2);
            return format!("Ctrl {key:?}");
        }
        9 => {
            let text = random.of(TEXTS);
            drop(list);
            write(window, text);
            return format!("text {text:?}");
        }
        10 => {
            let wheel = Event::MouseWheel {
                unit: egui::MouseWheelUnit::Point,
                delta: Vec2::new(0.0, random.below(200) as f32 - 100.0),
                phase: egui::TouchPhase::Move,
                source: egui::MouseWheelSource::Wheel,
                modifiers: Modifiers::NONE,
            };
            window.event(wheel);
        }
        _ => {
            let picture = list.iter().find(|w| w.accesskit_node().role() == Role::Image).map(Widget::rect);
            drop(list);
            if let Some(rect) = picture {
                drag(window, rect, random);
            }
            return "a drag in the picture".to_owned();
        }
    }
    drop(list);
    frames(window, 2);
    format!("{what:?}")
}

/// Takes all steps back and compares with the first scene.
fn undo_all(window: &mut Window, first: &SceneDesc, last: &[String]) {
    let studio = app(window);
    assert!(studio.document.steps().0.len() < 500, "the history has forgotten the first steps");
    while studio.document.undo().is_some() {}
    assert!(**studio.document.desc() == *first, "undo gives another scene after {last:?}");
}

fn run(seed: u64, actions: usize) {
    let (mut window, home) = window([1400.0, 900.0], 1.0);
    let first = scene(SAMPLE);
    let document = Document::of(first.clone(), "Sample".into(), home.path().to_owned());
    app(&mut window).show(document);
    let mut random = Random(seed);
    let mut done: Vec<String> = Vec::new();
    let mut steps = 0;
    for i in 0..actions {
        if std::env::var_os("TURNER_TEST_TRACE").is_some() {
            eprintln!("{seed} {i} {:?}", done.last());
        }
        let what = act(&mut window, &mut random);
        done.push(what);
        let studio = app(&mut window);
        studio.quit = false;
        studio.paused = true;
        // By the palette, too, no other file is opened.
        let opens = |purpose: &Purpose| matches!(purpose, Purpose::Open | Purpose::Model | Purpose::Key(..));
        if matches!(&studio.dialog, Some(Dialog::File { purpose, .. }) if opens(purpose)) {
            studio.dialog = None;
        }
        let last = &done[done.len().saturating_sub(5)..];
        if studio.document.name() == "Untitled" {
            // The palette has run "New".
            let document = Document::of(first.clone(), "Sample".into(), home.path().to_owned());
            studio.show(document);
        }
        if i % 100 == 99 {
            assert_saves(studio, home.path());
            steps += studio.document.steps().0.len();
        }
        if studio.document.steps().0.len() > 300 {
            undo_all(&mut window, &first, last);
        }
        assert!(window.unnamed_widgets().is_empty(), "{:?} after {last:?}", window.unnamed_widgets());
    }
    assert!(steps > 0, "no action has changed the scene");
    let end = Arc::clone(seen(&window).document.desc());
    let studio = app(&mut window);
    let count = studio.document.steps().0.len();
    undo_all(&mut window, &first, &done[done.len() - 5..]);
    for _ in 0..count {
        app(&mut window).document.redo();
    }
    assert!(Arc::ptr_eq(&end, seen(&window).document.desc()));
}

#[test]
fn a_thousand_random_actions() {
    run(1, 1000);
}

#[test]
fn other_thousand_random_actions() {
    run(2, 1000);
}
