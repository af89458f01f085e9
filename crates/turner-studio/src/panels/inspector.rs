//! The pixel under the pointer: its colour, and the surface that it shows.

use egui::{Grid, Ui};
use turner::explain::{number, probe};

use crate::studio::Studio;

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    let Some(frame) = studio.frame.clone() else { return };
    let film = &frame.stand.prepared.view.film;
    let size = [film.width, film.height];
    let inside = |at: [f64; 2]| {
        let fits = at[0] >= 0.0 && at[1] >= 0.0 && at[0] < f64::from(size[0]) && at[1] < f64::from(size[1]);
        fits.then(|| at.map(|v| v as u32))
    };
    let at = studio.viewport.under_pointer.and_then(inside).or(studio.viewport.explained);
    let Some([x, y]) = at else {
        ui.weak("Point at the picture.");
        return;
    };
    let picture = &frame.picture;
    // A preview may be smaller than the film.
    let place = |v: u32, of: u32, to: u32| (u64::from(v) * u64::from(to) / u64::from(of.max(1))) as usize;
    let index = place(y, size[1], picture.height) * picture.width as usize + place(x, size[0], picture.width);
    let rows = |ui: &mut Ui, rows: &[(&str, String)]| {
        for (name, value) in rows {
            ui.label(*name);
            ui.monospace(value);
            ui.end_row();
        }
    };
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        Grid::new("pixel").num_columns(2).spacing([12.0, 3.0]).striped(true).show(ui, |ui| {
            let mut list = vec![("Pixel", format!("{x}, {y}"))];
            if let (Some([r, g, b, a]), Some(shown)) = (picture.linear.get(index), picture.display.get(index))
            {
                list.push(("Scene value", format!("{r:.4} {g:.4} {b:.4}")));
                list.push(("Coverage", format!("{a:.3}")));
                let [r, g, b, _] = shown;
                list.push(("Display value", format!("{r} {g} {b}   #{r:02x}{g:02x}{b:02x}")));
            }
            rows(ui, &list);
            match probe(&frame.stand.prepared, &frame.stand.desc, x, y) {
                Err(error) => rows(ui, &[("Surface", error.message)]),
                Ok(None) => rows(ui, &[("Surface", "none: the background".into())]),
                Ok(Some(p)) => {
                    rows(
                        ui,
                        &[
                            ("Object", p.object),
                            ("Shape", format!("{}, number {}", p.shape, p.primitive)),
                            ("Material", p.material),
                            ("Position", number::vector(p.position)),
                            ("Shading normal", number::vector(p.normal)),
                            ("Geometric normal", number::vector(p.geometric_normal)),
                            ("uv", format!("{:.4} {:.4}", p.uv[0], p.uv[1])),
                            ("Distance", number::number(p.distance)),
                            ("Depth", number::number(p.depth)),
                            ("Side", if p.outside { "outside" } else { "inside" }.into()),
                            ("Albedo", number::color(p.albedo)),
                        ],
                    );
                    if let Some(s) = p.surface {
                        rows(
                            ui,
                            &[
                                ("Metalness", format!("{:.3}", s.metalness)),
                                ("Specular weight", format!("{:.3}", s.specular)),
                                ("Roughness", format!("{:.3}", s.roughness)),
                                ("Index of refraction", format!("{:.3}", s.ior)),
                                ("Transmission", format!("{:.3}", s.transmission)),
                                ("Subsurface", format!("{:.3}", s.subsurface)),
                                ("Coat", format!("{:.3}", s.coat)),
                                ("Opacity", format!("{:.3}", s.opacity)),
                                ("Emission", number::color(s.emission)),
                            ],
                        );
                    }
                }
            }
        });
    });
}
