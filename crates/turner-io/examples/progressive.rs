//! Renders progressively until a time limit: `cargo run --release -p turner-io --example progressive -- scene.toml 2`
//!
//! Passes of one sample accumulate. A cancelled pass stops at its next tile, and the picture so far is saved.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use turner::{PassOptions, PrepareOptions, Renderer};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/assets/gltf/Box.glb");
    let file = arguments.next().unwrap_or_else(|| model.to_owned());
    let seconds: f64 = arguments.next().map_or(Ok(2.0), |text| text.parse())?;

    let mut desc = turner_io::load(&file)?;
    [desc.film.width, desc.film.height] = [320, 240];
    let scene = desc.prepare(&PrepareOptions::default())?;
    let mut renderer = Renderer::new(scene)?;
    let cancel = AtomicBool::new(false);

    std::thread::scope(|scope| {
        // An interactive program sets `cancel` when the window closes or the scene is edited.
        let timer = scope.spawn(|| {
            std::thread::park_timeout(Duration::from_secs_f64(seconds));
            cancel.store(true, Ordering::Relaxed);
        });
        while !renderer.is_complete() && !cancel.load(Ordering::Relaxed) {
            let is_whole = renderer.pass(1, &PassOptions { threads: 0, cancel: &cancel, progress: None })?;
            // An interactive program shows `renderer.develop()` here.
            println!("{} rays{}", renderer.stats.total(), if is_whole { "" } else { ", cancelled" });
        }
        timer.thread().unpark();
        Ok::<(), turner::SceneError>(())
    })?;
    turner_io::save("progressive.png", &renderer.develop())?;
    Ok(())
}
