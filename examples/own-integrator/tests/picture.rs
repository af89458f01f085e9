//! Compares the integrator's images with closed-form results, for any number of threads.

use std::sync::atomic::AtomicBool;

use own_integrator::SkyLight;
use turner::camera::{CameraDesc, OrthographicDesc, Viewport};
use turner::color::Spectrum;
use turner::film::Antialias;
use turner::material::{ClassicMaterial, MaterialDesc};
use turner::math::DVec3;
use turner::schema::{ColorSource, MaterialId};
use turner::shape::{PlaneDesc, ShapeDesc, SphereDesc};
use turner::{ObjectDesc, PassOptions, PrepareOptions, Renderer, SceneDesc};

const SKY: f32 = 0.5;
const ALBEDO: f32 = 0.8;

/// Shapes of one albedo under a constant sky. An orthographic camera at `position` looks at a square of size `side`
/// around `look_at`; 16x16 pixels.
fn scene(shapes: Vec<ShapeDesc>, position: DVec3, look_at: DVec3, side: f64) -> SceneDesc {
    let color = ColorSource::Constant(Spectrum::grey(ALBEDO));
    let material = MaterialDesc::Classic(ClassicMaterial { color, ..Default::default() });
    let viewport = Viewport::Height(side);
    let camera = OrthographicDesc { position, look_at, viewport, ..Default::default() };
    let object = |shape| ObjectDesc { material: Some(MaterialId(0)), ..ObjectDesc::new(shape) };
    let mut desc = SceneDesc {
        camera: Some(CameraDesc::Orthographic(camera).into()),
        materials: vec![material.into()],
        objects: shapes.into_iter().map(object).collect(),
        ..Default::default()
    };
    desc.background.color = Spectrum::grey(SKY);
    (desc.film.width, desc.film.height) = (16, 16);
    desc.film.antialias = Antialias::MonteCarlo;
    desc.film.samples = 64;
    desc
}

fn rendered(desc: &SceneDesc, integrator: &SkyLight, threads: usize) -> Renderer {
    let prepared = desc.prepare_with(integrator, &PrepareOptions::default()).unwrap();
    let mut renderer = Renderer::new(prepared).unwrap();
    let options = PassOptions { threads, cancel: &AtomicBool::new(false), progress: None };
    assert!(renderer.pass(renderer.samples_per_pixel(), &options).unwrap());
    renderer
}

/// A plane, and a sphere of radius 1 with its centre 2 above; the camera looks at the plane directly below it.
fn ball_over_floor(side: f64) -> SceneDesc {
    let ball = SphereDesc { center: DVec3::new(0.0, 2.0, 0.0), radius: 1.0 };
    let shapes = vec![ShapeDesc::Plane(PlaneDesc::default()), ShapeDesc::Sphere(ball)];
    scene(shapes, DVec3::new(4.0, 2.0, 0.0), DVec3::ZERO, side)
}

/// The mean of the red channel.
fn mean(renderer: &Renderer) -> f64 {
    let linear = renderer.develop().linear;
    linear.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / linear.len() as f64
}

#[test]
fn a_convex_surface_receives_the_complete_sky() {
    let ball = vec![ShapeDesc::Sphere(SphereDesc::default())];
    let desc = scene(ball, DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 4.0);
    let renderer = rendered(&desc, &SkyLight::default(), 1);
    let picture = renderer.develop();
    let pixel = |x: usize, y: usize| picture.linear[16 * y + x];
    // For any direction, the sample is albedo times radiance.
    let [red, _, _, alpha] = pixel(8, 8);
    assert!((red - ALBEDO * SKY).abs() < 1e-6, "{red}");
    assert_eq!(alpha, 1.0);
    // The corner is sky.
    assert_eq!(pixel(0, 0), [SKY, SKY, SKY, 1.0]);
    // Each sample is a camera ray; those on the sphere have a sky ray.
    assert_eq!(renderer.stats.camera, 16 * 16 * 64);
    let fraction = renderer.stats.shadow as f64 / renderer.stats.camera as f64;
    let disk = std::f64::consts::PI / 16.0;
    assert!((fraction - disk).abs() < 0.005, "{fraction} of the image, not {disk}");
}

#[test]
fn a_sphere_occludes_its_form_factor_of_the_sky() {
    // Nusselt: a sphere of radius r at height h directly above occludes (r/h)² = 1/4 of the cosine-weighted hemisphere.
    let open = f64::from(ALBEDO * SKY) * 0.75;
    let found = mean(&rendered(&ball_over_floor(0.01), &SkyLight::default(), 2));
    // Four standard deviations of 16 * 16 * 64 independent directions.
    let tolerance = 4.0 * f64::from(ALBEDO * SKY) * (0.75 * 0.25 / (16.0 * 16.0 * 64.0f64)).sqrt();
    assert!((found - open).abs() < tolerance, "{found}, not {open} ± {tolerance}");
    // The sphere begins one unit above the plane: within half of that nothing is occluded.
    let near = mean(&rendered(&ball_over_floor(0.01), &SkyLight { distance: 0.5 }, 2));
    assert!((near - f64::from(ALBEDO * SKY)).abs() < 1e-6, "{near}");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let desc = ball_over_floor(6.0);
    let one = rendered(&desc, &SkyLight::default(), 1);
    let two = rendered(&desc, &SkyLight::default(), 2);
    assert_eq!(one.film.to_bytes(), two.film.to_bytes());
    assert_eq!(one.develop().display, two.develop().display);
    assert_eq!(one.stats, two.stats);
}
