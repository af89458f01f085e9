//! Orbits a camera around a model as an interactive viewer would: each frame is an edit, an update and a coarse
//! preview.
//! `cargo run --release -p turner-io --example edits -- model.glb 120`

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use turner::camera::{CameraDesc, PinholeDesc};
use turner::math::DVec3;
use turner::math::elementary::sin_cos;
use turner::prepare::Preparer;
use turner::{PassOptions, PrepareOptions, Renderer};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/assets/gltf/Box.glb");
    let mut desc = turner_io::load(std::env::args().nth(1).unwrap_or_else(|| model.to_owned()))?;
    let frames: u32 = std::env::args().nth(2).map_or(Ok(60), |text| text.parse())?;
    [desc.film.width, desc.film.height] = [320, 240];

    // The first update prepares everything; later updates prepare only what the edit changed.
    let mut preparer = Preparer::new(PrepareOptions::default());
    let bounds = preparer.update(&desc)?.scene.stats.bounds.ok_or("the scene has no bounded geometry")?;
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 0, cancel: &never, progress: None };
    let start = Instant::now();
    let mut updating = 0.0;
    for frame in 0..frames {
        let (sin, cos) = sin_cos(std::f64::consts::TAU * f64::from(frame) / f64::from(frames));
        let away = DVec3::new(sin, 0.5, cos) * 1.2 * bounds.size().length();
        let camera = PinholeDesc {
            position: bounds.center() + away,
            look_at: bounds.center(),
            fov: Some(40.0),
            ..PinholeDesc::default()
        };
        desc.camera = Some(CameraDesc::Pinhole(camera).into());

        let before = Instant::now();
        let prepared = preparer.update(&desc)?;
        updating += before.elapsed().as_secs_f64();
        let mut renderer = Renderer::new(prepared)?;
        // A viewer shows this preview first and continues with `pass` while nothing changes.
        renderer.preview_pass(&options)?;
        let shown = renderer.develop();
        assert_eq!(shown.display.len(), 320 * 240);
    }
    let each = 1e3 / f64::from(frames);
    println!(
        "{:.1} ms per frame, of which {:.2} ms for the update",
        start.elapsed().as_secs_f64() * each,
        updating * each
    );
    Ok(())
}
