//! Mouse and tools in the picture. Each gesture is one step of the history.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Event, Modifiers, PointerButton, Pos2, Rect, Shape, Vec2};
use turner::light::LightDesc;
use turner_live::pick;
use turner_studio::node::Node;
use turner_studio::studio::Studio;
use turner_studio::viewport::Tool;

use super::common::*;

fn picture(window: &Window) -> Rect {
    node(window, Role::Image, "Picture of Sample").unwrap().rect()
}

fn press_at(window: &mut Window, pos: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) {
    window.event(Event::PointerButton { pos, button, pressed, modifiers });
    frames(window, 1);
}

fn drag(window: &mut Window, from: Pos2, by: Vec2, button: PointerButton, modifiers: Modifiers) {
    window.event(Event::ModifiersChanged(modifiers));
    window.event(Event::PointerMoved(from));
    frames(window, 1);
    press_at(window, from, button, true, modifiers);
    for part in 1..=4 {
        window.event(Event::PointerMoved(from + by * (part as f32 / 4.0)));
        frames(window, 1);
    }
    press_at(window, from + by, button, false, modifiers);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    frames(window, 2);
}

fn click_at(window: &mut Window, at: Pos2) {
    window.event(Event::PointerMoved(at));
    frames(window, 1);
    press_at(window, at, PointerButton::Primary, true, Modifiers::NONE);
    press_at(window, at, PointerButton::Primary, false, Modifiers::NONE);
    frames(window, 2);
}

fn last_step(studio: &Studio) -> String {
    studio.document.steps().0.last().copied().unwrap_or_default().to_owned()
}

#[test]
fn the_mouse_moves_the_camera() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let middle = picture(&window).center();
    let by = Vec2::new(60.0, 25.0);
    let ways = [
        ("Orbit", PointerButton::Primary, Modifiers::NONE),
        ("Pan", PointerButton::Primary, Modifiers::SHIFT),
        ("Pan", PointerButton::Middle, Modifiers::NONE),
        ("Look around", PointerButton::Secondary, Modifiers::NONE),
    ];
    for (label, button, modifiers) in ways {
        one_step(&mut window, label, |window| {
            drag(window, middle, by, button, modifiers);
            assert_eq!(last_step(seen(window)), label);
        });
    }
    one_step(&mut window, "wheel", |window| {
        window.event(Event::PointerMoved(middle));
        window.event(Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: Vec2::new(0.0, 60.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        // The wheel turns smoothly, over some frames.
        frames(window, 60);
        assert_eq!(last_step(seen(window)), "Dolly");
    });
    // With the right button held, keys fly.
    one_step(&mut window, "fly", |window| {
        press_at(window, middle, PointerButton::Secondary, true, Modifiers::NONE);
        window.key_down(egui::Key::W);
        frames(window, 5);
        window.key_up(egui::Key::W);
        press_at(window, middle, PointerButton::Secondary, false, Modifiers::NONE);
        assert_eq!(last_step(seen(window)), "Fly");
        assert_eq!(seen(window).viewport.tool, Tool::Select);
    });
}

#[test]
fn a_click_selects_what_is_seen() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let area = picture(&window);
    let mut found = Vec::new();
    for x in 1..8 {
        for y in 1..8 {
            let at = area.min + area.size() * Vec2::new(x as f32 / 8.0, y as f32 / 8.0);
            window.event(Event::PointerMoved(at));
            frames(&mut window, 1);
            let frame = seen(&window).frame.clone().unwrap();
            let under = seen(&window).viewport.under_pointer.unwrap();
            let wanted = pick::pick(&frame.stand, under).and_then(|picked| picked.object).map(Node::Object);
            click_at(&mut window, at);
            assert_eq!(seen(&window).selection, wanted, "{at:?}");
            found.extend(wanted);
        }
    }
    assert!(found.contains(&Node::Object(0)) && found.contains(&Node::Object(1)), "{found:?}");
    assert!(!seen(&window).document.is_changed());
}

/// The end of the handle of the x axis, by its colour.
fn handle(window: &Window) -> Pos2 {
    let red = egui::Color32::from_rgb(240, 90, 90);
    let is_end = |shape: &Shape| match shape {
        Shape::Circle(circle) if circle.fill == red || circle.stroke.color == red => Some(circle.center),
        Shape::Rect(rect) if rect.fill == red => Some(rect.rect.center()),
        _ => None,
    };
    let ends: Vec<Pos2> = window.output().shapes.iter().filter_map(|shape| is_end(&shape.shape)).collect();
    *ends.first().expect("the x axis has a handle")
}

#[test]
fn handles_move_rotate_and_scale() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    for (tool, label, part) in [
        (Tool::Move, "Move", Node::Object(1)),
        (Tool::Rotate, "Rotate", Node::Object(1)),
        (Tool::Scale, "Scale", Node::Object(1)),
        (Tool::Move, "Move", Node::Light(0)),
    ] {
        for modifiers in [Modifiers::NONE, Modifiers::SHIFT] {
            // Another scene, so that its picture is not mistaken for that of the last one.
            show(&mut window, scene(SAMPLE));
            app(&mut window).viewport.tool = tool;
            app(&mut window).selection = Some(part);
            has_picture(&mut window);
            if part == Node::Light(0) {
                app(&mut window).queue.push(turner_studio::actions::Action::Frame);
                frames(&mut window, 2);
                has_picture(&mut window);
            }
            frames(&mut window, 2);
            let from = handle(&window);
            one_step(&mut window, label, |window| {
                drag(window, from, Vec2::new(30.0, 12.0), PointerButton::Primary, modifiers);
                assert_eq!(last_step(seen(window)), label);
                assert_eq!(seen(window).selection, Some(part));
            });
        }
    }
}

#[test]
fn tools_focus_aim_and_explain() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    let middle = picture(&window).center();
    app(&mut window).viewport.tool = Tool::Explain;
    click_at(&mut window, middle);
    assert!(seen(&window).viewport.explained.is_some() && !seen(&window).document.is_changed());
    // A lens has a distance to focus at.
    let mut desc = scene(SAMPLE);
    let lens = turner::camera::CameraDesc::of_type("thin-lens").unwrap();
    let mut lens = lens;
    let own = desc.camera.clone().unwrap();
    for (to, from) in lens.placement_mut().into_iter().zip(own.value.clone().placement_mut()) {
        *to = *from;
    }
    desc.camera = Some(lens.into());
    desc.lights[0].value = LightDesc::of_type("spot").unwrap();
    show(&mut window, desc);
    has_picture(&mut window);
    frames(&mut window, 2);
    app(&mut window).viewport.tool = Tool::Focus;
    one_step(&mut window, "focus", |window| {
        click_at(window, middle);
        assert_eq!(last_step(seen(window)), "Focus");
    });
    has_picture(&mut window);
    frames(&mut window, 2);
    app(&mut window).viewport.tool = Tool::Aim;
    app(&mut window).selection = None;
    let before = seen(&window).document.desc().clone();
    click_at(&mut window, middle);
    assert!(Arc::ptr_eq(&before, seen(&window).document.desc()), "nothing is aimed without a light");
    assert!(says(&window, "Select a spot light"));
    app(&mut window).selection = Some(Node::Light(0));
    one_step(&mut window, "aim", |window| {
        click_at(window, middle);
        let frame = seen(window).frame.clone().unwrap();
        let film = &seen(window).document.desc().film;
        let at = [f64::from(film.width) / 2.0, f64::from(film.height) / 2.0];
        let point = pick::pick(&frame.stand, at).unwrap().point;
        let LightDesc::Spot(spot) = &seen(window).document.desc().lights[0].value else { panic!("no spot") };
        assert!((spot.look_at - point).length() < 0.2, "{} {point}", spot.look_at);
    });
}

/// The context menu of a part does what the menus do, to that part.
#[test]
fn the_list_has_a_context_menu() {
    let (mut window, _home) = sample([1400.0, 1400.0]);
    for entry in ["Duplicate", "Hide or show", "Group", "Delete"] {
        one_step(&mut window, entry, |window| {
            node(window, Role::Button, "ball").unwrap().click_secondary();
            frames(window, 3);
            assert_eq!(seen(window).selection, Some(Node::Object(1)), "{entry}");
            click(window, Role::Button, entry);
        });
    }
    one_step(&mut window, "look through", |window| {
        node(window, Role::Button, "from above").unwrap().click_secondary();
        frames(window, 3);
        click(window, Role::Button, "Look through it");
        let desc = seen(window).document.desc();
        assert_eq!(desc.camera.as_ref().map(|camera| &camera.value), Some(&desc.cameras[0].value));
    });
}
