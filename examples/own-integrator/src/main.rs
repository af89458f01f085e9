//! Renders a scene under the light of its sky: `cargo run --release -p own-integrator -- [scene.toml [image.png]]`

use std::sync::atomic::AtomicBool;

use own_integrator::SkyLight;
use turner::color::{Spectrum, Transfer};
use turner::film::Antialias;
use turner::math::DVec3;
use turner::shape::{PlaneDesc, ShapeDesc, SphereDesc, TorusDesc};
use turner::{ObjectDesc, PassOptions, PrepareOptions, Renderer, SceneDesc};

/// A sphere and a torus on a plane under a blue sky.
fn still_life() -> SceneDesc {
    let ball = SphereDesc { center: DVec3::new(-0.8, 1.0, 0.0), ..Default::default() };
    let ring = TorusDesc { center: DVec3::new(1.2, 0.25, 0.8), ..Default::default() };
    let shapes = [ShapeDesc::Plane(PlaneDesc::default()), ShapeDesc::Sphere(ball), ShapeDesc::Torus(ring)];
    let mut desc = SceneDesc { objects: shapes.map(ObjectDesc::new).into(), ..Default::default() };
    desc.background.color = Spectrum::WHITE;
    desc.background.zenith = Some(Spectrum::new(0.3, 0.5, 1.0));
    (desc.film.width, desc.film.height) = (320, 240);
    desc.film.antialias = Antialias::MonteCarlo;
    desc.film.samples = 64;
    desc.film.transfer = Transfer::Srgb;
    desc
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let desc = arguments.next().map_or_else(|| Ok(still_life()), turner_io::load)?;
    let file = arguments.next().unwrap_or_else(|| "own-integrator.png".to_owned());

    let prepared = desc.prepare_with(&SkyLight::default(), &PrepareOptions::default())?;
    let mut renderer = Renderer::new(prepared)?;
    let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
    renderer.pass(renderer.samples_per_pixel(), &options)?;
    turner_io::save(&file, &renderer.develop())?;
    println!("{file}: {} rays", renderer.stats.total());
    Ok(())
}
