//! What the window tells of a pixel and of its light: AOVs, debug views, legends, layers, colour vision.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use turner::color::Vision;
use turner::film::Aov;
use turner::integrator::IntegratorDesc;
use turner_live::engine::{Layers, Stage};
use turner_studio::actions::Action;
use turner_studio::layout::Panel;

use super::common::*;

/// The sample scene with its film finished.
fn finished() -> (Window, tempfile::TempDir) {
    let (mut window, home) = window([1600.0, 1200.0], 1.0);
    app(&mut window).paused = false;
    // One lamp; a directional light needs a direction to be rendered.
    let mut desc = scene(SAMPLE);
    desc.lights.truncate(1);
    show(&mut window, desc);
    settle(&mut window);
    (window, home)
}

fn settle(window: &mut Window) {
    until(window, "a finished picture", |studio| {
        let is_now = |studio: &turner_studio::studio::Studio| {
            studio.frame.as_ref().is_some_and(|frame| {
                Arc::ptr_eq(&frame.stand.desc, studio.document.desc()) && frame.stage == Stage::Settled
            })
        };
        assert!(studio.status.error.is_none(), "{:?}", studio.status.error);
        studio.status.settled && is_now(studio)
    });
}

/// Clicks a choice and waits for the finished picture that it asks for.
fn choose(window: &mut Window, label: &str) {
    let before = seen(window).frame.clone().unwrap();
    click(window, Role::RadioButton, label);
    until(window, label, |studio| {
        let is_new = studio.frame.as_ref().is_some_and(|frame| frame.order != before.order);
        is_new && studio.frame.as_ref().is_some_and(|frame| frame.stage == Stage::Settled)
    });
    settle(window);
    frames(window, 2);
}

/// Runs an action, as its menu does.
fn run(window: &mut Window, action: Action) {
    app(window).queue.push(action);
    frames(window, 3);
}

#[test]
fn the_pixel_panel_has_all_aovs_and_debug_views() {
    let (mut window, _home) = finished();
    app(&mut window).viewport.last_pixel = Some([16, 14]);
    app(&mut window).reveal = Some(Panel::Inspector);
    frames(&mut window, 2);
    let begun = std::time::Instant::now();
    while !says(&window, "Sample count") {
        assert!(begun.elapsed().as_secs() < 60, "{:?}", names(&window));
        std::thread::sleep(std::time::Duration::from_millis(5));
        frames(&mut window, 1);
    }
    // Wherever the panel is scrolled to, its first sections are laid out.
    for aov in
        [Aov::Emission, Aov::Direct, Aov::DirectSpecular, Aov::Transmission, Aov::Albedo, Aov::Uv, Aov::Depth]
    {
        let word = aov.word().replace('_', " ");
        let label = format!("{}{}", word[..1].to_uppercase(), &word[1..]);
        assert!(says(&window, &label), "{label}: {:?}", names(&window));
    }
    for text in ["ball", "gold", "Bounces", "Ambient occlusion", "Wireframe"] {
        assert!(says(&window, text), "{text}");
    }
}

#[test]
fn heat_maps_have_a_legend_with_numbers() {
    let (mut window, _home) = finished();
    let legend = |window: &Window| {
        let all = names(window);
        all.into_iter().find(|name| name.contains("pale yellow is"))
    };
    assert_eq!(legend(&window), None);
    app(&mut window).reveal = Some(Panel::Effects);
    frames(&mut window, 2);
    for (label, unit) in [("Bounces", "bounces"), ("Cost", "boxes and tests")] {
        choose(&mut window, label);
        let found = legend(&window).unwrap_or_else(|| panic!("{label} has no legend"));
        assert!(found.contains(unit) && found.contains("Black is 0"), "{found}");
        assert_eq!(
            seen(&window).look.integrator.as_ref().map(IntegratorDesc::type_name),
            Some(label.to_lowercase().as_str())
        );
    }
    // One choice of all: false colours show the picture again.
    choose(&mut window, "False colour");
    assert_eq!(seen(&window).look.integrator, None);
    assert!(legend(&window).unwrap().contains("stops"));
}

#[test]
fn the_mixer_weights_diffuse_and_specular_light_without_rendering() {
    let (mut window, _home) = finished();
    let plain = seen(&window).frame.clone().unwrap();
    app(&mut window).reveal = Some(Panel::Effects);
    frames(&mut window, 2);
    choose(&mut window, "Diffuse and specular");
    assert_eq!(seen(&window).look.layers, Layers::Lobes);
    let layers = seen(&window).status.layers.clone();
    for aov in Aov::LOBES {
        assert!(layers.iter().any(|layer| layer == aov.word()), "{layers:?}");
    }
    // With all factors at 1 it is the picture.
    let whole = seen(&window).frame.clone().unwrap();
    assert_eq!(whole.picture.display, plain.picture.display);
    let samples = seen(&window).status.seconds;
    let mut sums = vec![[0.0f32; 3]; whole.picture.linear.len()];
    for layer in &layers {
        let only = |name: &String| (name.clone(), if name == layer { 1.0 } else { 0.0 });
        app(&mut window).look.mix = layers.iter().map(only).collect();
        let order = seen(&window).frame.as_ref().unwrap().clone();
        until(&mut window, "the mixed picture", |studio| {
            studio.frame.as_ref().is_some_and(|frame| !Arc::ptr_eq(frame, &order))
        });
        let picture = seen(&window).frame.clone().unwrap().picture.clone();
        for (sum, value) in sums.iter_mut().zip(&picture.linear) {
            (0..3).for_each(|c| sum[c] += value[c]);
        }
    }
    for (sum, value) in sums.iter().zip(&whole.picture.linear) {
        for c in 0..3 {
            assert!((sum[c] - value[c]).abs() <= 1e-4 * value[c].max(0.01), "{sum:?} {value:?}");
        }
    }
    assert_eq!(seen(&window).status.seconds, samples, "nothing is rendered again");
    click(&mut window, Role::Button, "Only direct diffuse");
    let factor = |studio: &turner_studio::studio::Studio, name: &str| {
        studio.look.mix.iter().find(|(layer, _)| layer == name).map(|(_, factor)| *factor)
    };
    assert_eq!(factor(seen(&window), "direct_diffuse"), Some(1.0));
    assert_eq!(factor(seen(&window), "emission"), Some(0.0));
}

#[test]
fn colours_are_shown_as_others_see_them_and_saved_as_they_are() {
    let (mut window, _home) = finished();
    let before = seen(&window).frame.clone().unwrap();
    for vision in Vision::ALL {
        run(&mut window, Action::See(vision));
        assert_eq!(seen(&window).viewport.vision, vision);
        assert!(Arc::ptr_eq(&seen(&window).frame.clone().unwrap().picture, &before.picture));
    }
}

#[test]
fn parts_are_renamed_by_keyboard_and_what_refers_to_them_follows() {
    let (mut window, _home) = window([1600.0, 1000.0], 1.0);
    show(&mut window, scene(SAMPLE));
    let chalk = |studio: &turner_studio::studio::Studio| {
        let desc = studio.document.desc();
        desc.value_at("object.0.material").unwrap().map(|value| value.data)
    };
    let text = |text: &str| Some(turner::schema::value::Data::String(text.to_owned()));
    app(&mut window).selection = Some(turner_studio::node::Node::Material(1));
    frames(&mut window, 2);
    press(&mut window, Modifiers::NONE, Key::F2);
    assert!(node(&window, Role::TextInput, "New name").is_some(), "{:?}", names(&window));
    // A name that is taken is refused, and the dialog stays.
    press(&mut window, Modifiers::COMMAND, Key::A);
    write(&mut window, "gold");
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(says(&window, "another material") && chalk(seen(&window)) == text("chalk"));
    frames(&mut window, 2);
    press(&mut window, Modifiers::COMMAND, Key::A);
    write(&mut window, "lime stone");
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(seen(&window).dialog.is_none());
    assert_eq!(chalk(seen(&window)), text("lime stone"));
    assert_eq!(seen(&window).selection, Some(turner_studio::node::Node::Material(1)));
    run(&mut window, Action::Undo);
    assert_eq!(chalk(seen(&window)), text("chalk"));
    // Parts of all kinds with names, from the table of actions.
    use turner_studio::node::Node;
    for node in [Node::Object(2), Node::Light(1), Node::View(0), Node::Texture(0), Node::Medium(0)] {
        app(&mut window).selection = Some(node);
        run(&mut window, Action::Rename);
        press(&mut window, Modifiers::COMMAND, Key::A);
        write(&mut window, "fresh");
        click(&mut window, Role::Button, "Rename");
        assert_eq!(node.label(seen(&window).document.desc()), "fresh", "{node:?}");
    }
    app(&mut window).selection = Some(Node::Film);
    assert!(!Action::Rename.is_possible(seen(&window)));
}
