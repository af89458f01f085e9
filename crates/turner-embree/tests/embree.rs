//! Tests with Embree itself: TURNER_EMBREE names the shared library. Without it, tests that need it do nothing.

use std::path::Path;
use std::sync::Arc;

use turner_bvh::Ray;
use turner_bvh::generate::{SceneKind, rays};
use turner_embree::*;

const OPTIONS: SceneOptions = SceneOptions { quality: Quality::Medium, robust: true };

fn device() -> Option<Device> {
    let path = std::env::var_os("TURNER_EMBREE")?;
    Some(Embree::load(Path::new(&path)).unwrap().device(1).unwrap())
}

#[test]
fn a_missing_library_is_an_error() {
    let error = Embree::load(Path::new("/there/is/no/such/library.so")).unwrap_err();
    assert!(error.to_string().starts_with("Embree cannot be loaded: "), "{error}");
}

#[test]
fn indices_are_checked() {
    let mesh = Mesh { positions: &[[0.0; 3]; 2], triangles: &[[0, 1, 2]] };
    assert_eq!(Geometry::new(mesh).unwrap_err(), EmbreeError::Index { index: 2, count: 2 });
}

#[test]
fn packets_have_the_hits_of_single_rays() {
    let Some(device) = device() else { return };
    for kind in [SceneKind::Cornell, SceneKind::Scan] {
        let scene = kind.generate(20_000);
        let mesh = Mesh { positions: &scene.meshes[0].positions, triangles: &scene.meshes[0].triangles };
        let built = Scene::build(&device, &Geometry::new(mesh).unwrap(), OPTIONS).unwrap();
        assert!(built.bytes() > 36 * mesh.triangles.len());
        // Not a multiple of 16.
        let rays = rays::primary(&scene.camera, 45);
        let packets = Packets::new(&rays);
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut occluded = vec![false; rays.len()];
        built.intersect_packets(&packets, 0..packets.len(), &mut hits);
        built.occluded_packets(&packets, 0..packets.len(), &mut occluded);
        let mut hit_count = 0;
        for ((ray, packet), occluded) in rays.iter().zip(hits).zip(occluded) {
            let single = built.intersect(ray);
            assert_eq!(single.t.is_finite(), packet.t.is_finite());
            assert_eq!(single.t.is_finite(), occluded);
            assert_eq!(built.occluded(ray), occluded);
            if occluded {
                hit_count += 1;
                assert!((single.t - packet.t).abs() <= 1e-5 * single.t);
                let [a, b, c] = scene.triangle(u32::MAX, single.primitive);
                let (u, v) = (single.u, single.v);
                for i in 0..3 {
                    let at = a[i] * (1.0 - u - v) + b[i] * u + c[i] * v;
                    assert!((at - ray.at(single.t)[i]).abs() < 1e-3 * scene.extent());
                }
            }
        }
        assert!(hit_count > 500, "{hit_count}");
    }
}

#[test]
fn instances_are_hit_where_they_are_placed() {
    let Some(device) = device() else { return };
    let mesh = Mesh { positions: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: &[[0, 1, 2]] };
    let part = Arc::new(Scene::build(&device, &Geometry::new(mesh).unwrap(), OPTIONS).unwrap());
    let at = |x: f32, z: f32| Instance {
        mesh: 0,
        transform: [[2.0, 0.0, 0.0, x], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 1.0, z]],
    };
    let built = Scene::instances(&device, &[part], &[at(0.0, 5.0), at(10.0, 7.0)], OPTIONS).unwrap();
    let hit = |x: f32| {
        let hit = built.intersect(&Ray::new([x, 0.5, 0.0], [0.0, 0.0, 1.0]));
        (hit.t, hit.instance)
    };
    assert_eq!(hit(0.5), (5.0, 0));
    assert_eq!(hit(10.5), (7.0, 1));
    assert_eq!(hit(5.0), (f32::INFINITY, u32::MAX));
    let wrong = Instance { mesh: 1, ..at(0.0, 0.0) };
    let error = Scene::instances(&device, &[], &[wrong], OPTIONS).unwrap_err();
    assert_eq!(error, EmbreeError::Index { index: 1, count: 0 });
}
