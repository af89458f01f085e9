//! Builds a scene in code and renders it: `cargo run --release -p turner-io --example hello`

use std::sync::atomic::AtomicBool;

use turner::color::{Spectrum, Tonemap, Transfer};
use turner::film::Antialias;
use turner::integrator::{IntegratorDesc, PathDesc};
use turner::light::{EnvironmentDesc, LightDesc};
use turner::material::{MaterialDesc, PrincipledMaterial};
use turner::math::DVec3;
use turner::schema::{ColorSource, MaterialId};
use turner::shape::{PlaneDesc, ShapeDesc, SphereDesc};
use turner::{ObjectDesc, PassOptions, PrepareOptions, Renderer, SceneDesc};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut desc = SceneDesc::default();
    [desc.film.width, desc.film.height] = [320, 240];
    desc.film.antialias = Antialias::MonteCarlo;
    desc.film.samples = 32;
    desc.film.transfer = Transfer::Srgb;
    desc.film.tonemap = Tonemap::Neutral;
    desc.integrator = IntegratorDesc::Path(PathDesc::default());
    // The built-in studio environment light.
    desc.lights.push(LightDesc::Environment(EnvironmentDesc::studio()).into());

    // Objects refer to materials by index.
    let red = ColorSource::Constant(Spectrum::new(0.8, 0.1, 0.05));
    let paint = PrincipledMaterial { base_color: red, ..PrincipledMaterial::default() };
    desc.materials.push(MaterialDesc::Principled(paint).into());
    let ball = SphereDesc { center: DVec3::new(0.0, 1.0, 0.0), ..Default::default() };
    desc.objects
        .push(ObjectDesc { material: Some(MaterialId(0)), ..ObjectDesc::new(ShapeDesc::Sphere(ball)) });
    desc.objects.push(ObjectDesc::new(ShapeDesc::Plane(PlaneDesc::default())));

    let scene = desc.prepare(&PrepareOptions::default())?;
    let mut renderer = Renderer::new(scene)?;
    let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
    renderer.pass(renderer.samples_per_pixel(), &options)?;
    turner_io::save("hello.png", &renderer.develop())?;
    Ok(())
}
