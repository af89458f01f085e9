//! Checks that the generated scenes are as documented.

use super::*;
use crate::Ray;

/// A size that is quick to generate.
fn small(kind: SceneKind) -> usize {
    match kind {
        SceneKind::Cornell => 36,
        SceneKind::Architecture => 50_000,
        SceneKind::Scan => 6_000,
        SceneKind::Sticks => 5_000,
        SceneKind::Terrain => 20_000,
        SceneKind::Instances1k | SceneKind::Instances1m => 50,
    }
}

fn check(mesh: &Mesh, name: &str) {
    assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()), "{name}");
    assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()), "{name}");
    for i in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.triangle(i);
        let area = math::length(math::cross(math::sub(b, a), math::sub(c, a)));
        assert!(area > 0.0, "{name}: triangle {i} of {a:?} {b:?} {c:?}");
    }
}

#[test]
fn scenes_are_the_same_each_time_and_sound() {
    for kind in SceneKind::ALL {
        let scene = kind.generate(small(kind));
        assert_eq!(scene, kind.generate(small(kind)), "{}", kind.name());
        for mesh in &scene.meshes {
            check(mesh, kind.name());
        }
        assert!(scene.instances.iter().all(|i| (i.mesh as usize) < scene.meshes.len()));
        assert!(scene.instances.iter().flat_map(|i| i.transform).flatten().all(f32::is_finite));
        assert!(scene.bounds().is_valid() && scene.extent() > 0.0);
    }
}

#[test]
fn scenes_have_as_many_triangles_as_they_say() {
    let count = |kind: SceneKind, size| kind.generate(size).triangles();
    assert_eq!(count(SceneKind::Cornell, 1_000), 36);
    assert_eq!(count(SceneKind::Scan, 6_000), 5_120);
    assert_eq!(count(SceneKind::Sticks, 5_000), 4_998);
    assert_eq!(count(SceneKind::Terrain, 20_001), 20_000);
    assert_eq!(count(SceneKind::Instances1k, 10), 10 * 81_920);
    assert_eq!(count(SceneKind::Instances1m, 10), 10 * 1_280);
    for size in [50_000, 66_000, 300_000] {
        let triangles = count(SceneKind::Architecture, size);
        assert!(triangles <= size && triangles + 80 > size, "{triangles} of {size}");
    }
    assert_eq!(count(SceneKind::Architecture, 0), 26_364, "without ornament");
}

#[test]
fn the_hall_has_triangles_of_all_sizes() {
    let scene = SceneKind::Architecture.generate(66_000);
    let mesh = &scene.meshes[0];
    let longest = |i| {
        let [a, b, c] = mesh.triangle(i);
        [(a, b), (b, c), (c, a)].map(|(p, q)| math::length(math::sub(p, q))).into_iter().fold(0.0, f32::max)
    };
    let lengths: Vec<f32> = (0..mesh.triangles.len()).map(longest).collect();
    let largest = lengths.iter().copied().fold(0.0, f32::max);
    let smallest = lengths.iter().copied().fold(f32::INFINITY, f32::min);
    assert!(largest > 2_000.0 * smallest, "{smallest} .. {largest}");
}

#[test]
fn spheres_are_closed() {
    // Euler: V - E + F = 2, with three edges to two faces.
    for levels in 0..4 {
        let mesh = noisy_icosphere(levels, 0.1, 1);
        assert_eq!(mesh.triangles.len(), 20 << (2 * levels));
        assert_eq!(mesh.positions.len(), 2 + mesh.triangles.len() / 2);
    }
}

#[test]
fn camera_rays_come_in_squares_and_each_once() {
    let camera = SceneKind::Cornell.generate(36).camera;
    for resolution in [1, 6, 8] {
        let rays = rays::primary(&camera, resolution);
        assert_eq!(rays.len(), (resolution * resolution) as usize);
        assert_eq!(rays, rays::primary(&camera, resolution));
        assert!(rays.iter().all(Ray::is_valid));
    }
    // The camera looks along z, and the first four pixels of an 8 x 8 image are in one corner.
    let rays = rays::primary(&camera, 8);
    let pixel = |ray: &Ray| {
        let [x, y, z] = ray.direction;
        [x, y].map(|a| (4.0 * a.abs() / (z * camera.half_width)) as i32)
    };
    let mut first: Vec<[i32; 2]> = rays[..4].iter().map(pixel).collect();
    first.sort();
    assert_eq!(first, [[2, 2], [2, 3], [3, 2], [3, 3]]);
    let seen: std::collections::BTreeSet<_> =
        rays.iter().map(|r| (pixel(r), r.direction[0] > 0.0, r.direction[1] > 0.0)).collect();
    assert_eq!(seen.len(), 64);
}

#[test]
fn secondary_rays_leave_the_side_that_was_seen() {
    let scene = SceneKind::Cornell.generate(36);
    let extent = scene.extent();
    let ray = Ray::new([278.0, 273.0, -780.0], [0.0, -0.3, 1.0]);
    // The floor is the first quad.
    let t = 273.0 / 0.3;
    let point = rays::point(&scene, extent, &ray, t, u32::MAX, 0).unwrap();
    assert_eq!(point.normal.map(f32::abs), [0.0, 1.0, 0.0]);
    assert!(point.normal[1] > 0.0 && point.position[1] > 0.0);
    let points = [point; 200];
    let diffuse = rays::diffuse(&points);
    assert_eq!(diffuse, rays::diffuse(&points));
    let mean = diffuse.iter().map(|r| r.direction[1]).sum::<f32>() / 200.0;
    assert!(diffuse.iter().all(|r| r.direction[1] > 0.0 && r.is_valid()));
    // The mean of the cosine is 2/3, its standard deviation 0.24.
    assert!((mean - 2.0 / 3.0).abs() < 5.0 * 0.24 / 200f32.sqrt(), "{mean}");
    assert!(rays::ambient(&points, 5.0).iter().all(|r| r.t_max == 5.0));
    let shadow = rays::shadow(&points[..1], scene.light)[0];
    assert!(
        shadow.at(shadow.t_max)[1] < scene.light[1] && shadow.at(1.001 * shadow.t_max)[1] > scene.light[1]
    );
}

#[test]
fn copies_lie_where_their_boxes_say() {
    let scene = SceneKind::Instances1m.generate(20);
    let bounds = scene.bounds();
    for (i, placed) in (0..).zip(&scene.instances) {
        let own = placed.bounds(scene.meshes[0].bounds());
        for primitive in [0, 700, 1_279] {
            for corner in scene.triangle(i, primitive) {
                let roomy = Aabb::new(own.min.map(|x| x - 1e-5), own.max.map(|x| x + 1e-5));
                assert!(roomy.contains_point(corner) && bounds.contains(own));
            }
        }
    }
}
