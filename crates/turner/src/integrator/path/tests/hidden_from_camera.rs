//! Objects that are hidden from the camera: its rays pass through them, all others meet them.

use std::sync::atomic::AtomicBool;

use crate::camera::PinholeDesc;
use crate::description::{GroupDesc, ObjectContent, ObjectDesc, SceneDesc};
use crate::film::{Aov, Aovs};
use crate::integrator::{ClassicDesc, DirectDesc, IntegratorDesc, NormalsDesc, PathDesc};
use crate::render::{PassOptions, Renderer};
use crate::schema::{GroupId, PrepareOptions};
use crate::shape::ShapeDesc;
use crate::testing::scenes::{emissive, grey, matte, path, plane, rectangle, render, sphere, v};

fn hidden(shape: ShapeDesc) -> ObjectDesc {
    ObjectDesc { hidden_from_camera: true, ..ObjectDesc::new(shape) }
}

fn wall(z: f64) -> ShapeDesc {
    rectangle(v(0.0, 0.0, z), v(90.0, 0.0, 0.0), v(0.0, 90.0, 0.0))
}

fn from_front() -> PinholeDesc {
    PinholeDesc { position: v(0.0, 0.0, 10.0), fov: Some(5.0), ..PinholeDesc::default() }
}

/// Two walls that are hidden from the camera, and one behind them with the radiance 0.25.
fn walls(integrator: IntegratorDesc) -> SceneDesc {
    SceneDesc { integrator, ..SceneDesc::default() }
        .with_object(hidden(wall(2.0)), emissive(8.0, grey(1.0)))
        .with_object(hidden(wall(1.0)), matte(grey(0.5)))
        .with(wall(-1.0), emissive(0.25, grey(1.0)))
        .seen(from_front())
        .filmed([8, 8], 4)
}

#[test]
fn the_camera_sees_what_is_behind() {
    for integrator in
        [IntegratorDesc::Path(PathDesc::default()), IntegratorDesc::Direct(DirectDesc::default())]
    {
        let mut desc = walls(integrator);
        desc.film.aovs = Aovs::new(&[Aov::Depth]);
        let scene = desc.prepare(&PrepareOptions::default()).unwrap();
        let mut renderer = Renderer::new(scene).unwrap();
        renderer
            .pass(u32::MAX, &PassOptions { threads: 1, cancel: &AtomicBool::new(false), progress: None })
            .unwrap();
        let picture = renderer.develop();
        assert!(picture.linear.iter().all(|p| p[..3] == [0.25; 3]), "{:?}", picture.linear[0]);
        let depths = renderer.film.channel_values("Z", 1);
        assert!(!depths.is_empty() && depths.iter().all(|z| (z - 11.0).abs() < 1e-5), "{depths:?}");
    }
}

/// The classic integrator and the debug views show the same surface.
#[test]
fn other_integrators_see_what_is_behind() {
    let view = |integrator: IntegratorDesc, objects: std::ops::Range<usize>| {
        let mut desc = walls(integrator);
        desc.objects = desc.objects[objects].to_vec();
        render(&desc).0.linear
    };
    for integrator in
        [IntegratorDesc::Classic(ClassicDesc::default()), IntegratorDesc::Normals(NormalsDesc::default())]
    {
        assert_eq!(view(integrator.clone(), 0..3), view(integrator.clone(), 2..3));
        assert_eq!(view(integrator.clone(), 0..2), view(integrator, 0..0));
    }
}

/// A floor of albedo a, seen from above through a sphere of radius r and radiance L, whose centre has the height h: below it
/// the irradiance is πL (r/h)², so the radiance a L (r/h)².
#[test]
fn it_still_gives_light() {
    let mut desc = path(PathDesc { max_depth: 1, ..PathDesc::default() })
        .with_object(hidden(sphere(v(0.0, 2.0, 0.0), 0.5)), emissive(6.0, grey(1.0)))
        .with(plane(), matte(grey(0.5)))
        .seen(PinholeDesc {
            position: v(0.0, 9.0, 0.0),
            up: v(0.0, 0.0, -1.0),
            fov: Some(0.1),
            ..PinholeDesc::default()
        })
        .filmed([4, 4], 256);
    let mean = |desc: &SceneDesc| {
        let (picture, _) = render(desc);
        picture.linear.iter().map(|p| f64::from(p[0])).sum::<f64>() / 16.0
    };
    let expected = 0.5 * 6.0 / 16.0;
    assert!((mean(&desc) / expected - 1.0).abs() < 0.01, "{} {expected}", mean(&desc));
    desc.objects[0].hidden_from_camera = false;
    assert_eq!(mean(&desc), 6.0);
}

/// The rays of a mirror meet it, also as part of an instance.
#[test]
fn mirrors_show_it() {
    let silver = crate::material::PrincipledMaterial {
        base_metalness: grey(1.0),
        base_color: grey(1.0),
        specular_roughness: grey(0.0),
        ..Default::default()
    };
    for instance in [false, true] {
        let mut desc = path(PathDesc::default())
            .with_object(hidden(wall(12.0)), emissive(3.0, grey(1.0)))
            .with_object(hidden(wall(5.0)), emissive(2.0, grey(1.0)))
            .with(wall(0.0), silver.clone())
            .seen(from_front())
            .filmed([4, 4], 4);
        if instance {
            let mut parts: Vec<ObjectDesc> = desc.objects.drain(..2).collect();
            parts.iter_mut().for_each(|part| part.hidden_from_camera = false);
            desc.groups.push(GroupDesc { objects: parts, ..GroupDesc::default() }.into());
            let content = ObjectContent::Instance(GroupId(0));
            desc.objects.push(ObjectDesc { content, hidden_from_camera: true, ..ObjectDesc::default() });
        }
        let (picture, _) = render(&desc);
        assert!(picture.linear.iter().all(|p| (p[0] - 2.0).abs() < 1e-3), "{:?}", picture.linear[0]);
    }
}
