//! Tests of previews.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{Effort, NO_OBJECT, Preview, PreviewOptions};
use crate::camera::{CameraDesc, PinholeDesc};
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, DisplayTransform};
use crate::integrator::{ClassicDesc, DirectDesc, IntegratorDesc, PathDesc, Prepared};
use crate::light::{AmbientDesc, LightDesc, PointDesc};
use crate::material::{MaterialDesc, MatteMaterial};
use crate::math::DVec3;
use crate::render::{PassOptions, Renderer};
use crate::schema::{ColorSource, MaterialId, PrepareOptions};
use crate::shape::{PlaneDesc, ShapeDesc, SphereDesc};

fn matte(grey: f32) -> MaterialDesc {
    MaterialDesc::Matte(MatteMaterial {
        color: ColorSource::Constant(Spectrum::grey(grey)),
        ..Default::default()
    })
}

/// A ball on a floor under a lamp, seen from above.
fn scene(integrator: IntegratorDesc) -> SceneDesc {
    let mut desc = SceneDesc { integrator, ..SceneDesc::default() };
    desc.materials.push(matte(0.5).into());
    let camera =
        PinholeDesc { position: DVec3::new(0.0, 4.0, 6.0), look_at: DVec3::ZERO, ..Default::default() };
    desc.camera = Some(CameraDesc::Pinhole(camera).into());
    let plane = PlaneDesc { point: DVec3::ZERO, normal: DVec3::Y };
    let ball = SphereDesc { center: DVec3::new(0.0, 1.0, 0.0), radius: 1.0 };
    for shape in [ShapeDesc::Plane(plane), ShapeDesc::Sphere(ball)] {
        desc.objects.push(ObjectDesc { material: Some(MaterialId(0)), ..ObjectDesc::new(shape) });
    }
    let lamp = PointDesc { position: DVec3::new(3.0, 5.0, 2.0), intensity: 3.0, ..Default::default() };
    desc.lights.push(LightDesc::Point(lamp).into());
    desc
}

fn path() -> IntegratorDesc {
    IntegratorDesc::Path(PathDesc::default())
}

fn prepare(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions::default()).unwrap()
}

fn draw(
    preview: &mut Preview,
    prepared: &Prepared,
    size: [u32; 2],
    frames: &[(Effort, u32)],
    threads: usize,
) {
    let cancel = AtomicBool::new(false);
    for &(effort, frame) in frames {
        let options = PreviewOptions { threads, cancel: &cancel, effort, frame, size };
        assert!(preview.frame(prepared, &options).unwrap());
    }
}

const FRAMES: [(Effort, u32); 4] =
    [(Effort::Moving, 0), (Effort::Moving, 1), (Effort::Still, 2), (Effort::Still, 3)];

#[test]
fn the_number_of_threads_changes_no_bit() {
    for integrator in [path(), IntegratorDesc::Direct(DirectDesc::default()), IntegratorDesc::default()] {
        let prepared = prepare(&scene(integrator));
        let mut pictures = [1, 2, 5].map(|threads| {
            let mut preview = Preview::new();
            draw(&mut preview, &prepared, [90, 53], &FRAMES, threads);
            preview.picture().clone()
        });
        assert!(pictures[0].color.iter().any(|c| c[0] > 0.0));
        let last = pictures[2].clone();
        assert!(pictures.iter_mut().all(|picture| *picture == last));
    }
}

#[test]
fn history_keeps_light_while_the_camera_moves() {
    let mut desc = scene(path());
    let mut preview = Preview::new();
    draw(&mut preview, &prepare(&desc), [64, 36], &FRAMES[..2], 1);
    let base = prepare(&desc);
    let Some(CameraDesc::Pinhole(camera)) = desc.camera.as_mut().map(|camera| &mut camera.value) else {
        unreachable!()
    };
    camera.position.x += 0.05;
    let moved = base.with_camera(desc.camera.clone().unwrap().value, desc.integrator.integrator()).unwrap();
    draw(&mut preview, &base, [64, 36], &[(Effort::Moving, 2), (Effort::Moving, 3)], 1);
    draw(&mut preview, &moved, [64, 36], &[(Effort::Moving, 4)], 1);
    let mut fresh = Preview::new();
    draw(&mut fresh, &moved, [64, 36], &[(Effort::Moving, 4)], 1);
    let mut converged = Preview::new();
    let still: Vec<_> = (0..64).map(|i| (Effort::Still, i)).collect();
    draw(&mut converged, &moved, [64, 36], &still, 1);
    let error = |of: &Preview| {
        let pairs = of.picture().color.iter().zip(&converged.picture().color);
        pairs.map(|(a, b)| f64::from((a[0] - b[0]).abs())).sum::<f64>()
    };
    assert!(error(&preview) < error(&fresh), "{} {}", error(&preview), error(&fresh));
}

#[test]
fn direct_light_of_a_lamp_on_a_floor() {
    let mut desc = scene(IntegratorDesc::Direct(DirectDesc::default()));
    desc.objects.truncate(1);
    // While the view moves, the filter reaches over twice as many pixels: less of a larger picture.
    for (effort, scale) in [(Effort::Still, 1), (Effort::Moving, 4)] {
        compare_light_of_a_lamp(&prepare(&desc), effort, scale);
    }
}

fn compare_light_of_a_lamp(prepared: &Prepared, effort: Effort, scale: u32) {
    let [width, height] = [80 * scale, 45 * scale];
    let mut preview = Preview::new();
    draw(&mut preview, prepared, [width, height], &[(effort, 0)], 2);
    let picture = preview.picture();
    let mut compared = 0;
    for y in 10 * scale..height {
        for x in 0..width {
            let ray = crate::view::camera_ray(
                &super::view_of(prepared, width, height),
                crate::sampler::SampleId { x, y, index: 0, seed: 0 },
                [f64::from(x) + 0.5, f64::from(y) + 0.5],
            );
            let ray = ray.unwrap();
            let t = -ray.origin.y / ray.direction.y;
            if !(t > 0.0 && t < 12.0) {
                continue;
            }
            let to_lamp = DVec3::new(3.0, 5.0, 2.0) - ray.at(t);
            let expected = 3.0 * 0.5 * std::f64::consts::FRAC_1_PI * to_lamp.normalize().y;
            let found = f64::from(picture.color[(y * width + x) as usize][1]);
            assert!((found / expected - 1.0).abs() < 0.02, "{x} {y}: {found} {expected}");
            assert!((f64::from(picture.depth[(y * width + x) as usize]) / t - 1.0).abs() < 1e-3);
            compared += 1;
        }
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn a_white_furnace_stays_white() {
    // Inside of uniform light a convex white body reflects all of it.
    let mut desc = scene(path());
    desc.objects.remove(0);
    desc.lights.clear();
    desc.materials[0] = matte(1.0).into();
    desc.background.color = Spectrum::WHITE;
    let mut preview = Preview::new();
    let still: Vec<_> = (0..8).map(|i| (Effort::Still, i)).collect();
    draw(&mut preview, &prepare(&desc), [48, 27], &still, 2);
    let picture = preview.picture();
    assert!(picture.object.contains(&0));
    assert!((picture.color[0][1] - 1.0).abs() < 1e-6);
    for color in &picture.color {
        assert!((color[1] - 1.0).abs() < 0.03, "{color:?}");
    }
}

#[test]
fn the_classic_integrator_is_exact() {
    let mut desc = scene(IntegratorDesc::Classic(ClassicDesc::default()));
    desc.materials.clear();
    desc.objects.iter_mut().for_each(|object| object.material = None);
    let ambient = AmbientDesc { intensity: 0.1, ..Default::default() };
    desc.lights.push(LightDesc::Ambient(ambient).into());
    (desc.film.width, desc.film.height, desc.film.antialias) = (70, 41, Antialias::None);
    let prepared = prepare(&desc);
    let mut preview = Preview::new();
    draw(&mut preview, &prepared, [70, 41], &[(Effort::Still, 0)], 2);
    let never = AtomicBool::new(false);
    let mut renderer = Renderer::new(prepared.clone()).unwrap();
    renderer.pass(1, &PassOptions { threads: 2, cancel: &never, progress: None }).unwrap();
    let expected = renderer.develop();
    let picture = preview.picture();
    let linear: Vec<[f32; 4]> =
        picture.color.iter().zip(&picture.alpha).map(|([r, g, b], a)| [*r, *g, *b, *a]).collect();
    let transform: DisplayTransform = expected.transform(&prepared.view.film);
    for (found, expected) in transform.to_8_bits(&linear, 1).iter().zip(&expected.display) {
        assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff(*b) <= 1), "{found:?} {expected:?}");
    }
    // While the view moves, some pixels are the mean of those around them.
    let mut moving = Preview::new();
    draw(&mut moving, &prepared, [70, 41], &[(Effort::Moving, 0)], 2);
    assert_eq!(moving.picture().object, picture.object);
    for (found, expected) in moving.picture().color.iter().zip(&picture.color) {
        let near = |(a, b): (&f32, &f32)| (a - b).abs() <= 0.04 * b.abs() + 0.006;
        assert!(found.iter().zip(expected).all(near), "{found:?} {expected:?}");
    }
    assert_ne!(moving.picture().color, picture.color);
}

#[test]
fn a_cancelled_frame_ends_and_the_next_is_whole() {
    let prepared = prepare(&scene(path()));
    let mut preview = Preview::new();
    let cancel = AtomicBool::new(true);
    let options =
        |frame| PreviewOptions { threads: 2, cancel: &cancel, effort: Effort::Moving, frame, size: [64, 36] };
    assert!(!preview.frame(&prepared, &options(0)).unwrap());
    cancel.store(false, Ordering::Relaxed);
    assert!(preview.frame(&prepared, &options(1)).unwrap());
    cancel.store(true, Ordering::Relaxed);
    assert!(!preview.frame(&prepared, &options(2)).unwrap());
    cancel.store(false, Ordering::Relaxed);
    assert!(preview.frame(&prepared, &options(3)).unwrap());
    // The same light as without cancels: frame 1 is the history of frame 3.
    let mut other = Preview::new();
    draw(&mut other, &prepared, [64, 36], &[(Effort::Moving, 1), (Effort::Moving, 3)], 1);
    assert_eq!(preview.picture(), other.picture());
}

#[test]
fn small_pictures_and_empty_scenes() {
    for size in [[1, 1], [1, 9], [5, 1], [0, 0], [33, 17]] {
        let mut preview = Preview::new();
        draw(&mut preview, &prepare(&scene(path())), size, &FRAMES, 3);
        assert_eq!(preview.picture().color.len() as u32, size[0].max(1) * size[1].max(1));
        let empty = SceneDesc { integrator: path(), ..SceneDesc::default() };
        draw(&mut preview, &prepare(&empty), size, &FRAMES, 3);
        assert!(preview.picture().object.iter().all(|object| *object == NO_OBJECT));
        assert!(preview.picture().depth.iter().all(|depth| *depth == f32::INFINITY));
    }
}

#[test]
fn objects_and_alpha() {
    let mut desc = scene(path());
    desc.objects.remove(0);
    desc.background.transparent = true;
    let mut preview = Preview::new();
    draw(&mut preview, &prepare(&desc), [40, 30], &FRAMES[..1], 1);
    let picture = preview.picture();
    assert_eq!((picture.alpha[0], picture.object[0]), (0.0, NO_OBJECT));
    let middle = 15 * 40 + 20;
    assert_eq!((picture.alpha[middle], picture.object[middle]), (1.0, 0));
}
