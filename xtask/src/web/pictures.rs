//! Small pictures of the scenes of the gallery and of the tutorial's steps, rendered by the library.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use turner::schema::PrepareOptions;
use turner::{PassOptions, Renderer};
use turner_io::{LoadOptions, Override, load_with, save};
use turner_live::document::STARTS;

use crate::root;

/// The longer side, pixels: twice what the page shows, for dense screens.
const SIDE: u32 = 400;

/// Samples per pixel of pictures with noise, which are denoised.
const SAMPLES: u32 = 16;

/// Writes `ID.jpg` for each scene.
pub(super) fn make(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let steps = (1..=8).map(|n| ("tutorial", format!("step-{n}")));
    let starts = STARTS.iter().map(|start| (start.folder, start.file.to_owned()));
    for (from, name) in starts.chain(steps) {
        let scene = root().join("scenes").join(from).join(format!("{name}.toml"));
        picture(&scene, &folder.join(format!("{name}.jpg")))
            .map_err(|e| format!("{}: {e}", scene.display()))?;
    }
    Ok(())
}

fn picture(scene: &Path, to: &Path) -> Result<(), String> {
    let plain = load_with(scene, &LoadOptions::default()).map_err(|e| e.to_string())?.desc;
    let (width, height) = (plain.film.width, plain.film.height);
    let scale = f64::from(SIDE) / f64::from(width.max(height));
    let side = |n: u32| ((f64::from(n) * scale).round() as u32).max(1).to_string();
    let set = |path: &str, value: String| Override { path: path.to_owned(), value };
    let mut overrides = vec![set("film.width", side(width)), set("film.height", side(height))];
    if plain.integrator.capabilities().splits_light {
        overrides.push(set("film.samples", SAMPLES.to_string()));
        overrides.push(set("film.denoise", "\"on\"".to_owned()));
    }
    let options = LoadOptions { overrides, ..LoadOptions::default() };
    let desc = load_with(scene, &options).map_err(|e| e.to_string())?.desc;
    let prepared = desc.prepare(&PrepareOptions::default()).map_err(|e| e.to_string())?;
    let mut renderer = Renderer::new(prepared).map_err(|e| e.to_string())?;
    let never = AtomicBool::new(false);
    let pass = PassOptions { threads: 0, cancel: &never, progress: None };
    renderer.pass(u32::MAX, &pass).map_err(|e| e.to_string())?;
    save(to, &renderer.develop()).map_err(|e| e.to_string())
}
