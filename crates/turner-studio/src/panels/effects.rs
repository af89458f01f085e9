//! The switches of the picture: the integrator, each effect singly, anti-aliasing, and what is shown.

use egui::{Grid, Ui};
use turner::film::Antialias;
use turner::integrator::IntegratorDesc;
use turner::schema::value::Data;
use turner_live::engine::{Display, Layers};

use crate::actions::Action;
use crate::studio::Studio;

/// The effects of the classic integrator: key, name.
const EFFECTS: &[(&str, &str)] = &[
    ("ambient", "Ambient"),
    ("diffuse", "Diffuse"),
    ("highlights", "Highlights"),
    ("shadows", "Shadows"),
    ("reflection", "Reflection"),
    ("refraction", "Refraction"),
];

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        integrators(ui, studio);
        if matches!(studio.document.desc().integrator, IntegratorDesc::Classic(_)) {
            effects(ui, studio);
        }
        antialiasing(ui, studio);
        shown(ui, studio);
        layers(ui, studio);
    });
}

fn set(studio: &mut Studio, label: &str, path: &str, data: Data) {
    let result = studio.document.set(label, None, &[(path.to_owned(), data)]);
    studio.check(result);
}

fn integrators(ui: &mut Ui, studio: &mut Studio) {
    ui.strong("Integrator");
    let own = studio.document.desc().integrator.type_name();
    ui.horizontal(|ui| {
        for (name, help) in [
            ("classic", "Recursive ray tracing, Whitted 1980"),
            ("path", "Path tracing: all light there is"),
            ("direct", "Light that is scattered once"),
        ] {
            if ui.radio(own == name, name).on_hover_text(help).clicked() && own != name {
                set(studio, &format!("Integrator {name}"), "integrator.type", Data::String(name.into()));
            }
        }
    });
}

fn effects(ui: &mut Ui, studio: &mut Studio) {
    ui.add_space(8.0);
    ui.strong("Effects");
    let IntegratorDesc::Classic(classic) = &studio.document.desc().integrator else { return };
    let on = [
        classic.ambient,
        classic.diffuse,
        classic.highlights,
        classic.shadows,
        classic.reflection,
        classic.refraction,
    ];
    let mut depth = classic.max_depth;
    for ((key, name), mut on) in EFFECTS.iter().zip(on) {
        if ui.checkbox(&mut on, *name).changed() {
            set(studio, name, &format!("integrator.{key}"), Data::Bool(on));
        }
    }
    ui.horizontal(|ui| {
        ui.label("Depth of recursion");
        let response = ui.add(egui::DragValue::new(&mut depth).range(0..=100).speed(0.1));
        crate::widgets::name_number(&response, "Depth of recursion", f64::from(depth));
        if response.changed() {
            set(studio, "Depth", "integrator.max_depth", Data::Integer(i64::from(depth)));
        }
    });
}

fn antialiasing(ui: &mut Ui, studio: &mut Studio) {
    ui.add_space(8.0);
    ui.strong("Anti-aliasing");
    let film = &studio.document.desc().film;
    let (now, mut samples) = (film.antialias, film.samples);
    for (kind, word, name, help) in [
        (Antialias::None, "none", "None", "One ray through the centre of each pixel"),
        (Antialias::Mean, "mean", "Quick", "The mean of each pixel and its neighbours"),
        (Antialias::Grid, "grid", "Grid", "A regular grid of rays in each pixel"),
        (Antialias::Adaptive, "adaptive", "Adaptive", "Whitted's subdivision of pixels that differ"),
        (Antialias::MonteCarlo, "monte-carlo", "Monte Carlo", "Several random rays per pixel, averaged"),
    ] {
        if ui.radio(now == kind, name).on_hover_text(help).clicked() && now != kind {
            set(studio, name, "film.antialias", Data::String(word.into()));
        }
    }
    if matches!(now, Antialias::Grid | Antialias::MonteCarlo) {
        ui.horizontal(|ui| {
            ui.label("Samples per pixel");
            let response = ui.add(egui::DragValue::new(&mut samples).range(1..=65536).speed(1.0));
            crate::widgets::name_number(&response, "Samples per pixel", f64::from(samples));
            if response.changed() {
                set(studio, "Samples", "film.samples", Data::Integer(i64::from(samples)));
            }
        });
    }
}

/// Debug views that are heat maps of what the picture costs: name, label, help.
const HEAT: &[(&str, &str, &str)] = &[
    ("cost", "Cost", "Boxes and tests that the camera ray takes to find its first hit"),
    ("bounces", "Bounces", "How deep paths go: the mean number of bounces of each pixel"),
];

fn shown_integrator(studio: &Studio) -> Option<&'static str> {
    studio.look.integrator.as_ref().map(IntegratorDesc::type_name)
}

fn shows_heat(studio: &Studio) -> bool {
    HEAT.iter().any(|(name, ..)| shown_integrator(studio) == Some(name))
}

fn shown(ui: &mut Ui, studio: &mut Studio) {
    ui.add_space(8.0);
    ui.strong("Show");
    for (display, name, help) in [
        (Display::Picture, "Picture", "The picture"),
        (
            Display::FalseColor,
            "False colour",
            "Luminance: black is five stops below middle grey, pale yellow five above",
        ),
        (Display::Noise, "Noise", "The estimated error of each pixel: pale yellow is 100 %"),
    ] {
        let is_shown = studio.look.display == display && !shows_heat(studio);
        if ui.radio(is_shown, name).on_hover_text(help).clicked() {
            studio.look.display = display;
            if shows_heat(studio) {
                studio.look.integrator = None;
            }
        }
    }
    for (name, label, help) in HEAT {
        let is_shown = shown_integrator(studio) == Some(name);
        if ui.radio(is_shown, *label).on_hover_text(*help).clicked() {
            studio.look.display = Display::Picture;
            studio.queue.push(Action::Show(Some(name)));
        }
    }
    Grid::new("exposure").num_columns(2).show(ui, |ui| {
        let mut exposure = studio.document.desc().film.exposure;
        ui.label("Exposure");
        let response = ui.add(egui::Slider::new(&mut exposure, -8.0..=8.0).suffix(" stops"));
        crate::widgets::name_number(&response, "Exposure", exposure);
        if response.changed() {
            let edit = ("film.exposure".to_owned(), Data::Number(exposure));
            let result = studio.document.set("Exposure", Some("exposure"), &[edit]);
            studio.check(result);
        }
    });
}

/// The layers of light, as a mixer.
fn layers(ui: &mut Ui, studio: &mut Studio) {
    ui.add_space(8.0);
    ui.strong("Light mixer");
    ui.horizontal_wrapped(|ui| {
        for (layers, name, help) in [
            (Layers::None, "Off", "The picture as it is"),
            (Layers::Groups, "Light groups", "A factor for each light group"),
            (Layers::Parts, "Direct and indirect", "Emission, direct and indirect light"),
            (
                Layers::Lobes,
                "Diffuse and specular",
                "Emission, and direct and indirect light by how the first surface scatters it",
            ),
        ] {
            if ui.radio(studio.look.layers == layers, name).on_hover_text(help).clicked() {
                studio.look.layers = layers;
                studio.look.mix.clear();
            }
        }
    });
    if studio.look.layers == Layers::None {
        return;
    }
    ui.weak("The factors apply to the film: nothing is rendered again.");
    let layers = studio.status.layers.clone();
    Grid::new("layers").num_columns(3).spacing([8.0, 4.0]).show(ui, |ui| {
        for layer in &layers {
            let name = layer.replace('_', " ");
            let mut factor = factor_of(studio, layer);
            let mut on = factor != 0.0;
            let switched = ui.checkbox(&mut on, &name).changed();
            let slider = ui.add(egui::Slider::new(&mut factor, 0.0..=4.0));
            crate::widgets::name_number(&slider, &format!("{name} factor"), f64::from(factor));
            if switched {
                factor = if on { 1.0 } else { 0.0 };
            }
            if switched || slider.changed() {
                set_factor(studio, layer, factor);
            }
            let alone = ui.small_button("Only").on_hover_text(format!("Only {name}"));
            crate::widgets::name(&alone, egui::Role::Button, &format!("Only {name}"));
            if alone.clicked() {
                for other in &layers {
                    set_factor(studio, other, if other == layer { 1.0 } else { 0.0 });
                }
            }
            ui.end_row();
        }
    });
    if !layers.is_empty() && ui.button("All").on_hover_text("All layers as they are").clicked() {
        studio.look.mix.clear();
    }
}

fn factor_of(studio: &Studio, layer: &str) -> f32 {
    studio.look.mix.iter().find(|(name, _)| name == layer).map_or(1.0, |(_, factor)| *factor)
}

fn set_factor(studio: &mut Studio, layer: &str, factor: f32) {
    studio.look.mix.retain(|(name, _)| name != layer);
    studio.look.mix.push((layer.to_owned(), factor));
}
