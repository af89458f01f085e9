//! Frames of the window's interface while the picture is rendered: all that is done for a frame but the graphics card's
//! part.

use std::time::{Duration, Instant};

use egui::{Context, RawInput, Rect, pos2, vec2};

use super::motion::orbit;
use super::scenes::Scene;
use super::table::{Row, Table};
use crate::app::App;

/// Frames that are measured.
const FRAMES: usize = 240;
/// The first frames load fonts and lay out everything.
const WARM: usize = 10;
/// Milliseconds of a frame at 60 frames per second.
const TARGET: f64 = 16.0;

pub(super) fn measure(scene: &Scene, table: &mut Table) -> Result<(), String> {
    let home = tempfile::tempdir().map_err(|e| e.to_string())?;
    let ctx = Context::default();
    let mut app = App::new(&ctx, home.path().to_owned());
    app.studio.show(scene.open([1280, 720])?);
    let [mut still, mut moving] = [Vec::new(), Vec::new()];
    let begun = Instant::now();
    for i in 0..WARM + 2 * FRAMES {
        let started = Instant::now();
        let moves = i >= WARM + FRAMES;
        if moves {
            let shown = app.studio.frame.clone();
            orbit(&mut app.studio.document, shown.as_deref(), 0.01)?;
            app.studio.moving();
        }
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(1440.0, 900.0))),
            time: Some(begun.elapsed().as_secs_f64()),
            ..RawInput::default()
        };
        let mut output = ctx.run_ui(input, |ui| app.show(ui));
        let shapes = std::mem::take(&mut output.shapes);
        let meshes = ctx.tessellate(shapes, output.pixels_per_point);
        std::hint::black_box(meshes);
        let took = started.elapsed();
        if i >= WARM {
            if moves { &mut moving } else { &mut still }.push(took.as_secs_f64() * 1e3);
        }
        std::thread::sleep(Duration::from_secs_f64(1.0 / 60.0).saturating_sub(took));
    }
    for (what, values) in
        [("interface frame while rendering", still), ("interface frame while moving", moving)]
    {
        let (size, target, note) = (Some([1440, 900]), Some(TARGET), String::new());
        table.add(&Row { scene: &scene.name, size, what, unit: "ms", values, target, note });
    }
    app.studio.quit = true;
    app.studio.close();
    Ok(())
}
