//! Renders a model: `cargo run --release -p turner-io --example model_to_png -- model.glb model.png`
//!
//! If the model has no camera, light or floor, the default studio adds them, as `turner model.glb` does.

use std::sync::atomic::AtomicBool;

use turner::{PassOptions, PrepareOptions, Renderer};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/assets/gltf/Box.glb");
    let model = arguments.next().unwrap_or_else(|| model.to_owned());
    let out = arguments.next().unwrap_or_else(|| "model.png".to_owned());

    // An error names its position and the remedy.
    let mut desc = turner_io::load(&model)?;
    // A description is plain data.
    [desc.film.width, desc.film.height] = [320, 240];
    desc.film.samples = 16;
    desc.warnings.iter().for_each(|warning| eprintln!("{}", warning.message));

    let scene = desc.prepare(&PrepareOptions::default())?;
    let mut renderer = Renderer::new(scene)?;
    let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
    renderer.pass(renderer.samples_per_pixel(), &options)?;
    turner_io::save(&out, &renderer.develop())?;
    println!("{out}");
    Ok(())
}
