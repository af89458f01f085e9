use std::sync::atomic::AtomicBool;

use turner::{PassOptions, PrepareOptions, Renderer};

let mut desc = turner_io::load("room.glb")?; // or .toml, .pbrt, .xml, .obj, .ply, .stl
[desc.film.width, desc.film.height] = [160, 120];
desc.film.samples = 4;

let prepared = desc.prepare(&PrepareOptions::default())?;
let mut renderer = Renderer::new(prepared)?;
let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
renderer.pass(renderer.samples_per_pixel(), &options)?;
turner_io::save("room.png", &renderer.develop())?; // or .exr, .hdr, .jpg
