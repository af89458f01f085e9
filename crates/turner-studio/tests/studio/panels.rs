//! What each panel can do.

use std::sync::Arc;

use egui::accesskit::Role;
use turner::SceneDesc;
use turner::film::Antialias;
use turner::integrator::IntegratorDesc;
use turner::schema::value::Data;
use turner_live::engine::{Display, Layers, Stage};
use turner_studio::insight::Comparison;
use turner_studio::layout::Panel;
use turner_studio::node::Node;
use turner_studio::viewport::Tool;

use super::common::*;

/// The sample scene with an integrator, and a panel in front.
fn with(integrator: &str, panel: Panel) -> (Window, tempfile::TempDir) {
    let (mut window, home) = sample([1400.0, 1400.0]);
    let mut desc = scene(SAMPLE);
    desc.integrator = IntegratorDesc::of_type(integrator).unwrap();
    show(&mut window, desc);
    has_picture(&mut window);
    app(&mut window).reveal = Some(panel);
    frames(&mut window, 3);
    (window, home)
}

fn value(window: &Window, path: &str) -> Option<Data> {
    seen(window).document.desc().value_at(path).unwrap().map(|value| value.data)
}

fn is_on(window: &Window, name: &str) -> bool {
    let node = node(window, Role::CheckBox, name).unwrap_or_else(|| panic!("no switch {name}"));
    egui_kittest::kittest::NodeT::accesskit_node(&node).toggled() == Some(egui::accesskit::Toggled::True)
}

/// The switches of the classic integrator, each on its own, and the depth.
#[test]
fn the_classic_effects() {
    let (mut window, _home) = with("classic", Panel::Effects);
    for name in ["Ambient", "Diffuse", "Highlights", "Shadows", "Reflection", "Refraction"] {
        let before = is_on(&window, name);
        let key = format!("integrator.{}", name.to_lowercase());
        one_step(&mut window, name, |window| {
            click(window, Role::CheckBox, name);
            assert_eq!(is_on(window, name), !before, "{name}");
            // A default is not in the scene.
            assert!(value(window, &key).is_none_or(|now| now == Data::Bool(!before)), "{name}");
        });
        assert_eq!(is_on(&window, name), before, "{name} after undo");
    }
    one_step(&mut window, "depth", |window| {
        set(window, "Depth of recursion", 3.0);
        assert_eq!(value(window, "integrator.max_depth"), Some(Data::Integer(3)));
    });
}

#[test]
fn integrators_anti_aliasing_and_exposure() {
    let (mut window, _home) = with("path", Panel::Effects);
    for name in ["classic", "direct"] {
        one_step(&mut window, name, |window| {
            click(window, Role::RadioButton, name);
            assert_eq!(seen(window).document.desc().integrator.type_name(), name);
        });
    }
    let kinds = [
        ("None", Antialias::None),
        ("Quick", Antialias::Mean),
        ("Grid", Antialias::Grid),
        ("Adaptive", Antialias::Adaptive),
        ("Monte Carlo", Antialias::MonteCarlo),
    ];
    for (first, _) in kinds {
        click(&mut window, Role::RadioButton, first);
        for (name, kind) in kinds {
            if name == first {
                continue;
            }
            one_step(&mut window, name, |window| {
                click(window, Role::RadioButton, name);
                assert_eq!(seen(window).document.desc().film.antialias, kind);
            });
        }
    }
    // "Monte Carlo" is chosen: it has a number of samples, which "None" lacks.
    one_step(&mut window, "samples", |window| {
        set(window, "Samples per pixel", 37.0);
        assert_eq!(seen(window).document.desc().film.samples, 37);
    });
    click(&mut window, Role::RadioButton, "None");
    assert!(node(&window, Role::SpinButton, "Samples per pixel").is_none());
    one_step(&mut window, "exposure", |window| {
        set(window, "Exposure", 1.5);
        assert_eq!(seen(window).document.desc().film.exposure, 1.5);
    });
}

/// What is shown of the picture is no change of the scene.
#[test]
fn false_colours_noise_and_the_light_mixer() {
    let (mut window, _home) = with("path", Panel::Effects);
    let first = seen(&window).document.desc().clone();
    for (name, display) in
        [("False colour", Display::FalseColor), ("Noise", Display::Noise), ("Picture", Display::Picture)]
    {
        click(&mut window, Role::RadioButton, name);
        assert_eq!(seen(&window).look.display, display);
    }
    app(&mut window).paused = false;
    for (name, layers) in [("Light groups", Layers::Groups), ("Direct and indirect", Layers::Parts)] {
        click(&mut window, Role::RadioButton, name);
        assert_eq!(seen(&window).look.layers, layers);
        until(&mut window, "the layers", |studio| {
            !studio.status.layers.is_empty()
                && studio.frame.as_ref().is_some_and(|frame| frame.stage != Stage::Preview)
                && studio.status.settled
        });
        frames(&mut window, 2);
        for layer in seen(&window).status.layers.clone() {
            let shown = seen(&window).frame.as_ref().unwrap().picture.display.clone();
            click(&mut window, Role::CheckBox, &layer);
            assert!(seen(&window).look.mix.contains(&(layer.clone(), 0.0)), "{layer}");
            click(&mut window, Role::CheckBox, &layer);
            assert!(seen(&window).look.mix.contains(&(layer.clone(), 1.0)), "{layer}");
            set(&mut window, &format!("{layer} factor"), 2.0);
            assert!(seen(&window).look.mix.contains(&(layer.clone(), 2.0)), "{layer}");
            if layer.contains("direct") && !layer.contains("indirect") {
                until(&mut window, "the mixed picture", |studio| {
                    studio.frame.as_ref().is_some_and(|frame| frame.picture.display != shown)
                });
            }
        }
    }
    click(&mut window, Role::RadioButton, "Off");
    assert!(seen(&window).look.layers == Layers::None && seen(&window).look.mix.is_empty());
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &first));
}

/// A click on a step goes there, in both directions.
#[test]
fn the_history_goes_to_each_step() {
    let (mut window, _home) = with("path", Panel::History);
    let mut stands: Vec<Arc<SceneDesc>> = vec![seen(&window).document.desc().clone()];
    for (label, samples) in [("Two", 2), ("Three", 3), ("Four", 4)] {
        let edit = [("film.samples".to_owned(), Data::Integer(samples))];
        app(&mut window).document.set(label, None, &edit).unwrap();
        stands.push(seen(&window).document.desc().clone());
    }
    frames(&mut window, 2);
    for (label, stand) in [("Two", 1), ("Four", 3), ("Opened", 0), ("Three", 2), ("Four", 3), ("Opened", 0)] {
        click(&mut window, Role::Button, label);
        assert!(Arc::ptr_eq(seen(&window).document.desc(), &stands[stand]), "{label}");
    }
    click(&mut window, Role::Button, "Redo");
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &stands[1]));
    click(&mut window, Role::Button, "Undo");
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &stands[0]));
}

/// Every integrator and every bookmark beside the first view. The scene stays.
#[test]
fn the_second_view() {
    let (mut window, _home) = with("classic", Panel::Second);
    assert!(seen(&window).second.is_open());
    let first = seen(&window).document.desc().clone();
    for kind in IntegratorDesc::DOC.entries {
        choose(&mut window, "Integrator of the second view", kind.name);
        assert!(says(&window, kind.name));
    }
    choose(&mut window, "Integrator of the second view", "the scene's integrator");
    choose(&mut window, "Camera of the second view", "from above");
    choose(&mut window, "Camera of the second view", "the scene's camera");
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &first));
    // Another panel in front: the second view renders no longer.
    app(&mut window).reveal = Some(Panel::Properties);
    frames(&mut window, 3);
    assert!(!seen(&window).second.is_open());
}

#[test]
fn pictures_are_kept_and_compared() {
    let (mut window, _home) = with("classic", Panel::Compare);
    click(&mut window, Role::Button, "Keep the picture");
    assert!(seen(&window).insight.snapshot.is_some());
    assert_eq!(seen(&window).insight.comparison, Comparison::Wipe(0.5));
    set(&mut window, "Edge of the wipe", 0.25);
    assert_eq!(seen(&window).insight.comparison, Comparison::Wipe(0.25));
    // Another picture to compare with.
    let edit = [("film.exposure".to_owned(), Data::Number(1.0))];
    app(&mut window).document.set("Exposure", None, &edit).unwrap();
    has_picture(&mut window);
    for (name, comparison) in
        [("Difference", Comparison::Difference), ("FLIP", Comparison::Flip), ("Off", Comparison::Off)]
    {
        click(&mut window, Role::RadioButton, name);
        assert_eq!(seen(&window).insight.comparison, comparison);
        frames(&mut window, 2);
    }
    click(&mut window, Role::Button, "Forget it");
    assert!(seen(&window).insight.snapshot.is_none());
}

/// The doctor finds what is wrong, and its remedy is one step.
#[test]
fn the_doctor_examines_and_its_remedies_apply() {
    let (mut window, _home) = with("path", Panel::Doctor);
    click(&mut window, Role::Button, "Examine the scene");
    until(&mut window, "the findings", |studio| studio.insight.examination.is_some());
    frames(&mut window, 2);
    let buttons = entries(&window);
    let applied: Vec<&String> = buttons.iter().filter(|name| name.starts_with("Apply ")).collect();
    let (examination, of) = seen(&window).insight.examination.clone().unwrap();
    assert!(Arc::ptr_eq(&of, seen(&window).document.desc()));
    let wanted = examination.findings.iter().flat_map(|finding| &finding.remedies);
    let wanted = wanted.filter(|remedy| matches!(remedy, turner::schema::Remedy::Set(_))).count();
    assert_eq!(applied.len(), wanted, "{buttons:?}");
    assert!(wanted > 0, "one sample per pixel has a remedy: {:?}", examination.findings);
    for remedy in applied {
        one_step(&mut window, remedy, |window| click(window, Role::Button, remedy));
    }
}

/// A pixel is explained: its rays are a tree, drawn bounce by bounce.
#[test]
fn the_rays_of_a_pixel() {
    let (mut window, _home) = with("path", Panel::Rays);
    click(&mut window, Role::Button, "Explain a pixel");
    assert_eq!(seen(&window).viewport.tool, Tool::Explain);
    let picture = node(&window, Role::Image, "Picture of Sample").unwrap();
    picture.click();
    frames(&mut window, 2);
    assert!(seen(&window).viewport.explained.is_some());
    until(&mut window, "the rays", |studio| matches!(studio.insight.explanation, Some(Ok(_))));
    frames(&mut window, 2);
    click(&mut window, Role::CheckBox, "Brightest sample");
    assert!(seen(&window).insight.sample.is_some());
    until(&mut window, "the rays", |studio| matches!(studio.insight.explanation, Some(Ok(_))));
    for name in ["Step", "Step", "Back", "All", "Back"] {
        click(&mut window, Role::Button, name);
    }
    click(&mut window, Role::CheckBox, "BVH boxes");
    assert_eq!(seen(&window).insight.boxes, Some(2));
    set(&mut window, "Depth of BVH boxes", 1.0);
    assert_eq!(seen(&window).insight.boxes, Some(1));
    // The pixel's values are in their panel, and its scopes.
    app(&mut window).reveal = Some(Panel::Inspector);
    frames(&mut window, 3);
    assert!(says(&window, "Scene value") && says(&window, "Display value"), "{:?}", names(&window));
    assert!(says(&window, "Shading normal") || says(&window, "none: the background"), "{:?}", names(&window));
    app(&mut window).reveal = Some(Panel::Scopes);
    frames(&mut window, 3);
    assert!(
        node(&window, Role::Image, "Histogram").is_some() && node(&window, Role::Image, "Waveform").is_some()
    );
}

/// Every scene of the gallery opens by a click, and renders something.
#[test]
fn the_gallery_opens_every_scene() {
    let (mut window, _home) = window([1400.0, 4000.0], 1.0);
    app(&mut window).reveal = Some(Panel::Gallery);
    frames(&mut window, 3);
    for start in turner_live::document::STARTS {
        click(&mut window, Role::Button, start.name);
        assert_eq!(seen(&window).document.name(), start.name);
        has_picture(&mut window);
    }
    click(&mut window, Role::Button, "Empty stage");
    assert_eq!(seen(&window).document.name(), "Untitled");
    has_picture(&mut window);
}

/// The helpers of lights: name, group, hidden, colour by temperature, the sun by place and hour.
#[test]
fn lights_have_names_temperatures_and_hours() {
    let (mut window, _home) = with("path", Panel::Properties);
    app(&mut window).selection = Some(Node::Light(0));
    frames(&mut window, 2);
    for (label, key) in [("name", "name"), ("light group", "light_group")] {
        one_step(&mut window, label, |window| {
            node(window, Role::TextInput, label).unwrap().focus();
            frames(window, 2);
            write(window, "z");
            let now = value(window, &format!("light.0.{key}"));
            assert!(matches!(&now, Some(Data::String(text)) if text.contains("z")), "{label}: {now:?}");
        });
    }
    one_step(&mut window, "hidden", |window| {
        click(window, Role::CheckBox, "hidden");
        assert!(seen(window).document.desc().lights[0].hidden);
    });
    one_step(&mut window, "temperature", |window| {
        set(window, "Temperature", 1900.0);
        let Some(Data::Array(rgb)) = value(window, "light.0.color") else { panic!("no colour") };
        assert!(rgb[0].data == Data::Number(1.0) && rgb[2].data != Data::Number(1.0));
    });
    let mut desc = scene(SAMPLE);
    desc.lights[0].value = turner::light::LightDesc::of_type("sky").unwrap();
    show(&mut window, desc);
    app(&mut window).selection = Some(Node::Light(0));
    frames(&mut window, 2);
    for (label, number) in [("Hour", 9.0), ("Day of the year", 40.0), ("Latitude", 10.0)] {
        one_step(&mut window, label, |window| {
            set(window, label, number);
            assert!(
                value(window, "light.0.elevation").is_some() && value(window, "light.0.azimuth").is_some()
            );
        });
    }
}

/// The swatch of a material has its place before it is drawn: what is written below it stays in its field.
#[test]
fn a_swatch_moves_nothing() {
    let (mut window, _home) = with("path", Panel::Properties);
    let place = |window: &Window| node(window, Role::SpinButton, "base metalness, red").unwrap().rect();
    for _ in 0..5 {
        // Another scene has another swatch.
        show(&mut window, scene(SAMPLE));
        let materials = &seen(&window).document.desc().materials;
        let gold = materials.iter().position(|material| material.name.as_deref() == Some("gold")).unwrap();
        app(&mut window).selection = Some(Node::Material(gold));
        frames(&mut window, 2);
        node(&window, Role::SpinButton, "base metalness, red").unwrap().focus();
        frames(&mut window, 2);
        // While it is written in, a field is a little larger.
        let first = place(&window);
        let begun = std::time::Instant::now();
        while begun.elapsed() < std::time::Duration::from_millis(100) {
            frames(&mut window, 1);
            let number = node(&window, Role::SpinButton, "base metalness, red").unwrap();
            assert_eq!((number.rect(), number.is_focused()), (first, true));
        }
    }
}

/// Each choice of the form for renders to files.
#[test]
fn the_form_of_renders() {
    let (mut window, _home) = with("path", Panel::Render);
    let mut seen_numbers = 0;
    for (list, entries) in [
        ("Render until", &["samples", "time", "noise", "the scene's samples"][..]),
        ("Pictures", &["frames", "turntable", "one picture"]),
        ("Noise removal", turner::film::Denoise::WORDS),
    ] {
        for entry in entries {
            choose(&mut window, list, entry);
            let numbers =
                ["Samples per pixel", "Minutes", "Noise in percent", "First frame", "Number of pictures"];
            for label in numbers {
                if node(&window, Role::SpinButton, label).is_some() {
                    set(&mut window, label, 2.0);
                    seen_numbers += 1;
                }
            }
            assert!(window.unnamed_widgets().is_empty(), "{list} {entry}: {:?}", window.unnamed_widgets());
        }
    }
    assert!(seen_numbers >= 5, "{seen_numbers}");
    for label in ["Another size", "Can be stopped and resumed", "Programs in use come first"] {
        let before = is_on(&window, label);
        click(&mut window, Role::CheckBox, label);
        assert_eq!(is_on(&window, label), !before, "{label}");
    }
    set(&mut window, "Width", 64.0);
    assert!(!seen(&window).document.is_changed());
}
