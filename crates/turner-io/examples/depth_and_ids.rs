//! Depth and IDs as plain arrays, row by row from the top left: `cargo run --release -p turner-io --example
//! depth_and_ids -- scene.toml`

use std::sync::atomic::AtomicBool;

use turner::description::SceneDesc;
use turner::film::{Antialias, Picture};
use turner::integrator::{DepthDesc, DepthMeasure, IdsDesc, IntegratorDesc};
use turner::render::{PassOptions, Renderer};
use turner::schema::{PrepareOptions, SceneError};

/// The result of an integrator for one ray through each pixel's centre.
fn shown(desc: &SceneDesc, integrator: IntegratorDesc) -> Result<Picture, SceneError> {
    let mut desc = SceneDesc { integrator, ..desc.clone() };
    desc.film.antialias = Antialias::None;
    let scene = desc.prepare(&PrepareOptions::default())?;
    let mut renderer = Renderer::new(scene)?;
    renderer.pass(1, &PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None })?;
    Ok(renderer.develop())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/assets/gltf/Box.glb");
    let mut desc = turner_io::load(std::env::args().nth(1).unwrap_or_else(|| model.to_owned()))?;
    [desc.film.width, desc.film.height] = [64, 36];

    // Depth along the viewing direction, in scene units; infinite where nothing is hit (alpha 0).
    let picture = shown(&desc, IntegratorDesc::Depth(DepthDesc { measure: DepthMeasure::Axis }))?;
    let depth: Vec<f32> =
        picture.linear.iter().map(|p| if p[3] > 0.0 { p[0] } else { f32::INFINITY }).collect();

    // [object, material, part of the object]; -1 where nothing is hit.
    let picture = shown(&desc, IntegratorDesc::Ids(IdsDesc {}))?;
    let ids: Vec<[i32; 3]> = picture
        .linear
        .iter()
        .map(|p| if p[3] > 0.0 { [0, 1, 2].map(|i| p[i] as i32) } else { [-1; 3] })
        .collect();

    let width = picture.width as usize;
    for (depths, ids) in depth.chunks(width).zip(ids.chunks(width)).step_by(2) {
        let nearest = depths.iter().copied().fold(f32::INFINITY, f32::min);
        let row: String =
            ids.iter().map(|[_, _, part]| char::from_digit(*part as u32 % 36, 36).unwrap_or('.')).collect();
        println!("{row} from {nearest:.2}");
    }
    Ok(())
}
