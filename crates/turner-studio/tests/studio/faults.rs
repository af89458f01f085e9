//! What goes wrong costs no work: faults of the renderer, windows of no size, files that change while they are read.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use egui::Vec2;
use turner::schema::value::Data;
use turner_live::document::Document;
use turner_live::engine::Engine;
use turner_studio::layout::Panel;
use turner_studio::node::Node;

use super::common::*;

/// A fault in the renderer's thread: the picture stays, the window says so, the work is kept on disk, and the next change
/// renders again.
#[test]
fn a_fault_of_the_renderer_keeps_picture_and_work() {
    let (mut window, home) = sample([1400.0, 900.0]);
    let armed = Arc::new(AtomicBool::new(false));
    let of_engine = Arc::clone(&armed);
    // The function that the engine calls is one of the window's: a fault in it is one in the engine's thread.
    app(&mut window).engine = Engine::new(move || {
        if of_engine.swap(false, Ordering::SeqCst) {
            panic!("a fault for the test");
        }
    });
    let radius = |window: &mut Window, radius: f64| {
        let edit = [("object.1.radius".to_owned(), Data::Number(radius))];
        app(window).document.set("Radius", None, &edit).unwrap();
    };
    radius(&mut window, 1.5);
    has_picture(&mut window);
    // The engine's last call of the function is over.
    until(&mut window, "a waiting engine", |studio| studio.status.doing.is_empty());
    std::thread::sleep(std::time::Duration::from_millis(20));
    let last = seen(&window).frame.clone().unwrap();
    armed.store(true, Ordering::SeqCst);
    radius(&mut window, 2.0);
    until(&mut window, "the fault", |studio| studio.status.error.is_some());
    frames(&mut window, 2);
    assert!(seen(&window).status.error.as_ref().unwrap().is_fault);
    assert!(says(&window, "a fault for the test") && says(&window, "Not rendered:"));
    let shown = seen(&window).frame.clone().unwrap();
    assert_eq!((shown.picture.width, shown.picture.height), (last.picture.width, last.picture.height));
    let kept = home.path().join(format!("recovery/session-{}/scene.toml", std::process::id()));
    until(&mut window, "the kept work", |_| kept.is_file());
    app(&mut window).close();
    let desc = Document::open(&kept).unwrap_or_else(|e| panic!("{}", e.message)).desc().clone();
    let value = desc.value_at("object.1.radius").unwrap().map(|value| value.data);
    assert!(matches!(value, Some(Data::Number(2.0) | Data::Integer(2))), "{value:?}");
    // The next change renders again.
    radius(&mut window, 0.5);
    has_picture(&mut window);
    assert!(seen(&window).status.error.is_none());
}

/// A scene that cannot be rendered is explained; undo brings the picture back.
#[test]
fn a_scene_without_a_picture_is_explained() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let edit = [
        ("camera.position".to_owned(), numbers([0.0, 0.0, 0.0])),
        ("camera.look_at".to_owned(), numbers([0.0, 0.0, 0.0])),
    ];
    app(&mut window).document.set("Camera", None, &edit).unwrap();
    until(&mut window, "the error", |studio| studio.status.error.is_some());
    frames(&mut window, 2);
    assert!(says(&window, "Not rendered:") && seen(&window).frame.is_some());
    assert!(!seen(&window).status.error.as_ref().unwrap().is_fault);
    press(&mut window, egui::Modifiers::COMMAND, egui::Key::Z);
    until(&mut window, "the end of the error", |studio| studio.status.error.is_none());
    has_picture(&mut window);
    frames(&mut window, 2);
    assert!(!says(&window, "Not rendered:"));
}

fn numbers(values: [f64; 3]) -> Data {
    Data::Array(values.map(|v| turner::schema::value::Value::new(Data::Number(v))).to_vec())
}

/// A window that shrinks to nothing and grows again, with every panel in front.
#[test]
fn a_window_shrinks_to_nothing_and_grows_again() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    app(&mut window).selection = Some(Node::Object(1));
    for panel in Panel::ALL {
        app(&mut window).reveal = Some(*panel);
        for size in [[1400.0, 900.0], [200.0, 3.0], [1.0, 1.0], [0.0, 0.0], [3.0, 500.0], [1400.0, 900.0]] {
            window.set_size(Vec2::from(size));
            frames(&mut window, 2);
        }
        assert!(says(&window, panel.title()));
    }
    assert!(!seen(&window).document.is_changed());
    // It renders at its new size.
    let edit = [("object.1.radius".to_owned(), Data::Number(1.5))];
    app(&mut window).document.set("Radius", None, &edit).unwrap();
    has_picture(&mut window);
    assert!(seen(&window).status.error.is_none());
}

/// Replaces a file as editors do: another program sees the old one or the new one, nothing in between.
fn replace(file: &Path, text: &str) {
    let new = file.with_extension("new");
    std::fs::write(&new, text).unwrap();
    std::fs::rename(new, file).unwrap();
}

/// However a change of the file and reading it meet, the window ends with the newest text.
#[test]
fn a_file_that_changes_while_it_is_read() {
    let (mut window, home) = sample([1400.0, 900.0]);
    let file = home.path().join("scene.toml");
    for millis in [0, 0, 1, 2, 20] {
        // Other lengths: the clock of a file may stand still between two changes.
        let text = |extra: usize| {
            format!("#{}\n[[object]]\ntype = \"sphere\"\nradius = {extra}.5\n", "-".repeat(extra))
        };
        replace(&file, &text(1));
        app(&mut window).open(&file);
        std::thread::sleep(std::time::Duration::from_millis(millis));
        replace(&file, &text(2));
        frames(&mut window, 1);
        until(&mut window, "the newest text", |studio| {
            let value = studio.document.desc().value_at("object.0.radius").unwrap();
            value.map(|value| value.data) == Some(Data::Number(2.5))
        });
        assert!(seen(&window).problem.is_none() && !seen(&window).document.is_changed());
    }
}
