//! The pixel under the pointer: its colour, the light and the surface that it shows, and all AOVs and debug views.

use egui::{CollapsingHeader, Grid, Ui};
use turner::explain::{Probe, SurfaceValues, number, probe};
use turner::film::Aov;
use turner_live::engine::{Frame, Stage};

use crate::pixel::{Found, name_of};
use crate::studio::Studio;

/// A name, a value, and what it means.
type Row = (String, String, &'static str);

fn row(name: &str, value: String) -> Row {
    (name.to_owned(), value, "")
}

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    let Some(frame) = studio.frame.clone() else { return };
    let film = &frame.stand.prepared.view.film;
    let size = [film.width, film.height];
    let inside = |at: [f64; 2]| {
        let fits = at[0] >= 0.0 && at[1] >= 0.0 && at[0] < f64::from(size[0]) && at[1] < f64::from(size[1]);
        fits.then(|| at.map(|v| v as u32))
    };
    let view = &mut studio.viewport;
    let pointed = view.under_pointer.and_then(inside);
    // The pointer may leave the picture to read on here.
    view.last_pixel = pointed.or(view.last_pixel).filter(|[x, y]| *x < size[0] && *y < size[1]);
    let Some([x, y]) = pointed.or(view.explained).or(view.last_pixel) else {
        ui.weak("Point at the picture.");
        return;
    };
    let samples = match frame.stage {
        Stage::Preview => 0,
        Stage::Film { samples, .. } => samples,
        Stage::Settled => film.samples_per_pixel(),
    };
    let may_trace = !studio.is_moving();
    let wake = studio.wake().clone();
    let found = studio.pixel.of(&wake, &frame.stand, [x, y], samples, may_trace);
    egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        rows(ui, "pixel", &colors(&frame, [x, y], size));
        match found {
            Some(Ok(found)) => {
                if let Some(fault) = &found.fault {
                    ui.label(fault);
                }
                section(ui, "Light", &light(found, &frame));
                surface(ui, &frame, [x, y]);
                section(ui, "AOVs", &aovs(found, &frame));
                section(ui, "Samples", &of_samples(found));
                section(ui, "Debug views", &views(found));
            }
            other => {
                if let Some(Err(fault)) = other {
                    ui.label(fault);
                }
                surface(ui, &frame, [x, y]);
                if other.is_none() {
                    ui.weak(if may_trace {
                        "Tracing the AOVs…"
                    } else {
                        "AOVs follow when the view is still."
                    });
                }
            }
        }
    });
}

fn section(ui: &mut Ui, title: &str, list: &[Row]) {
    if list.is_empty() {
        return;
    }
    CollapsingHeader::new(title).default_open(true).show(ui, |ui| rows(ui, title, list));
}

fn rows(ui: &mut Ui, id: &str, list: &[Row]) {
    Grid::new(id).num_columns(2).spacing([12.0, 3.0]).striped(true).show(ui, |ui| {
        for (name, value, meaning) in list {
            let label = ui.label(name);
            if !meaning.is_empty() {
                label.on_hover_text(*meaning);
            }
            ui.monospace(value);
            ui.end_row();
        }
    });
}

/// The colour in the picture. A preview may be smaller than the film.
fn colors(frame: &Frame, [x, y]: [u32; 2], size: [u32; 2]) -> Vec<Row> {
    let picture = &frame.picture;
    let place = |v: u32, of: u32, to: u32| (u64::from(v) * u64::from(to) / u64::from(of.max(1))) as usize;
    let index = place(y, size[1], picture.height) * picture.width as usize + place(x, size[0], picture.width);
    let mut list = vec![row("Pixel", format!("{x}, {y}"))];
    if let (Some([r, g, b, a]), Some(shown)) = (picture.linear.get(index), picture.display.get(index)) {
        list.push(row("Scene value", format!("{r:.4} {g:.4} {b:.4}")));
        list.push(row("Coverage", format!("{a:.3}")));
        let [r, g, b, _] = shown;
        list.push(row("Display value", format!("{r} {g} {b}   #{r:02x}{g:02x}{b:02x}")));
    }
    list
}

/// What an AOV is, in its own words.
fn meaning(aov: Aov) -> &'static str {
    Aov::DOCS.iter().find(|(word, _)| *word == aov.word()).map_or("", |(_, meaning)| meaning)
}

fn words(layer: &str) -> String {
    let text = layer.replace('_', " ");
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(|v| number::number(*v)).collect::<Vec<_>>().join(" ")
}

/// The parts of the light, and the shadow where the scene has shadow catchers.
fn light(found: &Found, frame: &Frame) -> Vec<Row> {
    let catches = frame.stand.prepared.view.film.aovs.catches_shadows();
    let is_light = |aov: Aov| aov.is_light() || catches && aov == Aov::Shadow;
    let name = |layer: &str| match layer.strip_prefix("light.") {
        Some(group) => format!("Light group {group}"),
        None => words(layer),
    };
    let of_light = found.aovs.iter().filter(|own| is_light(own.aov));
    of_light.map(|own| (name(&own.layer), numbers(&own.values), meaning(own.aov))).collect()
}

/// AOVs of the first hit: means over the samples of the pixel.
fn aovs(found: &Found, frame: &Frame) -> Vec<Row> {
    let is_own = |aov: Aov| !aov.is_light() && aov != Aov::Shadow && !of_all_samples(aov);
    let own = found.aovs.iter().filter(|own| is_own(own.aov));
    own.map(|own| {
        let value = match own.aov.labels() {
            None => numbers(&own.values),
            Some(_) => match name_of(own, &frame.stand.prepared) {
                Some(name) => format!("{}  {name}", numbers(&own.values)),
                None => "0  nothing".to_owned(),
            },
        };
        (words(own.aov.word()), value, meaning(own.aov))
    })
    .collect()
}

/// Whether an AOV tells of the samples of a pixel, not of what they show.
fn of_all_samples(aov: Aov) -> bool {
    matches!(aov, Aov::SampleCount | Aov::Cost | Aov::Bounces | Aov::Variance | Aov::Error)
}

fn of_samples(found: &Found) -> Vec<Row> {
    let own = found.aovs.iter().filter(|own| of_all_samples(own.aov));
    let mut list: Vec<Row> = own
        .map(|own| {
            let unit = own.aov.layout().unit;
            (words(&own.layer), format!("{} {unit}", numbers(&own.values)), meaning(own.aov))
        })
        .collect();
    let variance = found.aovs.iter().find(|own| own.aov == Aov::Variance).and_then(|own| own.values.first());
    if let Some(variance) = variance.filter(|_| found.samples > 1) {
        let error = (variance.max(0.0) / f64::from(found.samples)).sqrt();
        let meaning = "The standard deviation of the mean luminance of these samples";
        list.push(("Standard error".to_owned(), number::number(error), meaning));
    }
    list
}

fn views(found: &Found) -> Vec<Row> {
    let value = |[r, g, b, a]: [f32; 4]| {
        if a == 0.0 {
            return "nothing".to_owned();
        }
        let [r, g, b] = [r / a, g / a, b / a].map(|v| number::number(f64::from(v)));
        if r == g && g == b { r } else { format!("{r} {g} {b}") }
    };
    found.views.iter().map(|(name, shown)| row(&words(&name.replace('-', " ")), value(*shown))).collect()
}

/// The surface at the pixel's centre, by one ray: it is known in moving views, too.
fn surface(ui: &mut Ui, frame: &Frame, [x, y]: [u32; 2]) {
    let list = match probe(&frame.stand.prepared, &frame.stand.desc, x, y) {
        Err(error) => vec![row("Surface", error.message)],
        Ok(None) => vec![row("Surface", "none: the background".into())],
        Ok(Some(probe)) => of_surface(probe),
    };
    section(ui, "Surface", &list);
}

fn of_surface(p: Probe) -> Vec<Row> {
    let mut list = vec![
        row("Object", p.object),
        row("Shape", format!("{}, number {}", p.shape, p.primitive)),
        row("Material", p.material),
        row("Position", numbers(&p.position.to_array())),
        row("Shading normal", numbers(&p.normal.to_array())),
        row("Geometric normal", numbers(&p.geometric_normal.to_array())),
        row("uv", format!("{:.4} {:.4}", p.uv[0], p.uv[1])),
        row("Distance", number::number(p.distance)),
        row("Depth", number::number(p.depth)),
        row("Side", if p.outside { "outside" } else { "inside" }.into()),
        row("Albedo", number::color(p.albedo)),
    ];
    if let Some(SurfaceValues {
        metalness, specular, roughness, ior, transmission, subsurface, coat, ..
    }) = p.surface
    {
        let values = [
            ("Metalness", f64::from(metalness)),
            ("Specular weight", f64::from(specular)),
            ("Roughness", f64::from(roughness)),
            ("Index of refraction", ior),
            ("Transmission", f64::from(transmission)),
            ("Subsurface", f64::from(subsurface)),
            ("Coat", f64::from(coat)),
        ];
        list.extend(values.map(|(name, value)| row(name, format!("{value:.3}"))));
    }
    if let Some(s) = p.surface {
        list.push(row("Opacity", format!("{:.3}", s.opacity)));
        list.push(row("Emission", number::color(s.emission)));
    }
    list
}
