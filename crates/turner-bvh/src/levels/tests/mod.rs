//! Groups against a search without any tree.

mod made;

use std::sync::Arc;

use proptest::prelude::*;

use super::bounds::{Extent, Place, Reach};
use super::*;
use crate::generate::{Random, noisy_icosphere};
use crate::{Aabb, BuildOptions, Bvh, Hit, Ray, RefitError, Triangles};
pub(crate) use made::kernels;
use made::*;

#[test]
fn instances_of_meshes_equal_brute_force() {
    let mut random = Random::new(1);
    for (count, spread) in [(1, 0.0), (5, 1.0), (60, 5.0), (300, 300.0)] {
        let things = vec![mesh(&mut random, 40), mesh(&mut random, 3), mesh(&mut random, 0)];
        let mut instances = instances(&mut random, count, 3, spread);
        // Equal ones: ties go to the lower number.
        if count > 4 {
            instances[4] = instances[1];
        }
        let made = Made::new(things, instances, Vec::new(), 0);
        let rays = rays(&mut random, &made, 400);
        let hits = check(&made, &rays);
        assert!(count < 60 || hits > 50, "{hits}");
    }
}

#[test]
fn singular_transforms_are_dropped_and_nearly_singular_ones_are_not() {
    let mut random = Random::new(2);
    let things = vec![mesh(&mut random, 30)];
    let mut instances = instances(&mut random, 40, 1, 3.0);
    instances[3].transform[1] = [0.0; 4];
    instances[4].transform = [[0.0; 4]; 3];
    instances[5].transform[0][0] = f32::NAN;
    instances[6].transform[2][3] = f32::INFINITY;
    instances[7].transform = [[1e-39; 4]; 3];
    instances[8].transform = [[1e-30, 0.0, 0.0, 0.0], [0.0, 1e-30, 0.0, 0.0], [0.0, 0.0, 1e-41, 0.0]];
    // Almost flat, and turned.
    for instance in &mut instances[10..30] {
        let t = &mut instance.transform;
        let other: [f32; 3] = std::array::from_fn(|row| t[row][0] + t[row][1]);
        for row in 0..3 {
            t[row][2] = other[row] + 1e-5 * t[row][2];
        }
    }
    let made = Made::new(things, instances, Vec::new(), 2);
    let stats = made.group.stats();
    assert_eq!(stats.singular, 6);
    assert!(stats.loose >= 20, "{stats:?}");
    let rays = rays(&mut random, &made, 300);
    assert!(check(&made, &rays) > 50);
    assert_eq!(made.group.bounds(), None);
    // Loose ones within another group.
    let outer = vec![Thing::Group(Box::new(made)), mesh(&mut random, 5)];
    let placed = self::instances(&mut random, 6, 2, 3.0);
    let made = Made::new(outer, placed, Vec::new(), 1);
    let rays = self::rays(&mut random, &made, 200);
    check(&made, &rays);
}

#[test]
fn more_loose_instances_than_a_node_has_leaves() {
    let mut random = Random::new(21);
    let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 1.0, 1e-6, 0.0]];
    for count in [1, 15, 16, 106, 900] {
        let mut instances = vec![Instance { object: 0, transform: flat }; count];
        for instance in &mut instances {
            instance.transform[0][3] = random.unit();
        }
        instances.push(Instance { object: 0, transform: identity() });
        let made = Made::new(vec![mesh(&mut random, 2)], instances, Vec::new(), 0);
        assert_eq!(made.group.stats().loose, count);
        let rays = rays(&mut random, &made, 40);
        check(&made, &rays);
    }
}

#[test]
fn nothing_is_hit_in_empty_groups() {
    let made = Made::new(Vec::new(), Vec::new(), Vec::new(), 0);
    assert_eq!(made.group.bounds(), Some(Aabb::EMPTY));
    let mut random = Random::new(3);
    let some = rays(&mut random, &made, 30);
    assert_eq!(check(&made, &some), 0);
    let empty =
        Made::new(vec![Thing::Group(Box::new(made))], instances(&mut random, 3, 1, 1.0), Vec::new(), 0);
    assert_eq!(empty.group.stats().empty, 3);
    assert_eq!(check(&empty, &some), 0);
    empty.group.intersect_batch(&[], &mut []);
}

#[test]
fn groups_in_groups_equal_brute_force() {
    let mut random = Random::new(4);
    for levels in 1..=4 {
        for moving in [false, true] {
            let made = nested(&mut random, levels, moving);
            let rays = rays(&mut random, &made, 150);
            assert!(check(&made, &rays) > 20);
        }
    }
}

#[test]
fn no_more_than_the_greatest_depth() {
    let mut random = Random::new(5);
    let mut made = Made::new(vec![mesh(&mut random, 20)], instances(&mut random, 3, 1, 1.0), Vec::new(), 0);
    for _ in 1..MAX_LEVELS {
        let placed = vec![
            Instance { object: 0, transform: gentle(&mut random) },
            Instance { object: 1, transform: gentle(&mut random) },
        ];
        made = Made::new(vec![Thing::Group(Box::new(made)), mesh(&mut random, 4)], placed, Vec::new(), 0);
    }
    let rays = rays(&mut random, &made, 60);
    check(&made, &rays);
    assert_eq!(made.group.path(0), [0; MAX_LEVELS]);
    assert_eq!(made.group.path(2), [0, 0, 0, 0, 0, 0, 0, 2]);
    assert_eq!(made.group.path(3), [0, 0, 0, 0, 0, 0, 1]);
    assert_eq!(made.group.path(9), [1]);
    assert_eq!(made.group.path(Hit::NONE), []);
    let parts =
        GroupParts { instances: &[Instance { object: 0, transform: identity() }], ..GroupParts::default() };
    let deeper = Group::build(vec![Object::Group(Arc::clone(&made.group))], &parts, &BuildOptions::default());
    assert_eq!(deeper.unwrap_err(), GroupError::TooDeep);
    let missing = Group::build(Vec::new(), &parts, &BuildOptions::default());
    assert_eq!(missing.unwrap_err(), GroupError::NoSuchObject { instance: 0, object: 0 });
    let ends = GroupParts { ends: &[identity(); 2], ..parts };
    let ends = Group::build(vec![Object::Group(made.group)], &ends, &BuildOptions::default());
    assert_eq!(ends.unwrap_err(), GroupError::Ends { instances: 1, ends: 2 });
}

#[test]
fn very_large_and_very_small_scenes() {
    let mut random = Random::new(6);
    for size in [1e-25_f32, 1e-14, 1e14, 1e25] {
        let things = vec![mesh(&mut random, 40)];
        let mut placed = instances(&mut random, 20, 1, 1.0);
        for instance in &mut placed {
            instance.transform = gentle(&mut random).map(|row| row.map(|x| x * size));
        }
        let made = Made::new(things, placed, Vec::new(), 0);
        let mut rays = rays(&mut random, &made, 200);
        for (i, ray) in rays.iter_mut().enumerate() {
            ray.origin = random.in_cube().map(|x| 2.0 * x * size);
            ray.direction = random.direction().map(|x| if i % 2 == 0 { x } else { x * size });
        }
        assert!(check(&made, &rays) > 20, "{size}");
    }
}

#[test]
fn filters_see_the_hits_that_the_caller_would_get() {
    struct Odd;
    impl Visit for Odd {
        fn accept(&self, _: u32, hit: &Hit) -> bool {
            assert!(hit.t > 100.0 && hit.t < 1e7);
            hit.instance % 2 == 1 && hit.primitive % 2 == 1
        }
    }
    let mut random = Random::new(7);
    let things = vec![mesh(&mut random, 60)];
    let placed: Vec<Instance> =
        (0..20).map(|_| Instance { object: 0, transform: gentle(&mut random) }).collect();
    let made = Made::new(things, placed, Vec::new(), 0);
    let inner = made.group.clone();
    let outer = [Instance { object: 0, transform: identity() }; 2];
    let parts = GroupParts { instances: &outer, ..GroupParts::default() };
    let outer = Group::build(vec![Object::Group(inner)], &parts, &BuildOptions::default()).unwrap();
    let rays: Vec<Ray> = (0..200)
        .map(|_| {
            let d = random.direction();
            Ray::new(d.map(|x| -x * 10.0), d.map(|x| x * 1e-2))
        })
        .collect();
    kernels(|_| {
        let mut hits = vec![Hit::MISS; rays.len()];
        outer.intersect_batch_with(&rays, &mut hits, &Odd);
        for (ray, hit) in rays.iter().zip(&hits) {
            assert_eq!(made.group.intersect_with(ray, &Odd).unwrap_or(Hit::MISS), *hit);
            assert_eq!(outer.occluded_with(ray, &Odd), hit.is_hit());
        }
        assert!(hits.iter().filter(|h| h.is_hit()).count() > 50);
    });
}

#[test]
fn refitted_groups_equal_brute_force() {
    let mut random = Random::new(8);
    let things = vec![mesh(&mut random, 20), mesh(&mut random, 30)];
    let mut placed = instances(&mut random, 80, 2, 3.0);
    placed[0].transform = [[0.0; 4]; 3];
    let mut made = Made::new(things, placed, Vec::new(), 3);
    let boxes: Vec<Aabb> = (0..3).map(Spheres::bounds).collect();
    for round in 0..4 {
        made.instances = instances(&mut random, 80, 2, 4.0);
        made.ends = if round % 2 == 1 {
            made.instances
                .iter()
                .map(|i| if i.object == 0 { i.transform } else { gentle(&mut random) })
                .collect()
        } else {
            Vec::new()
        };
        made.instances[round].transform[1] = [f32::NAN; 4];
        made.instances[20].transform[2] = made.instances[20].transform[1];
        made.instances[21].transform[2] = made.instances[21].transform[1].map(|x| x * 1.000_01);
        let parts = GroupParts { instances: &made.instances, ends: &made.ends, boxes: &boxes };
        let objects = made.group.objects().to_vec();
        let group = Arc::make_mut(&mut made.group);
        group.refit(objects, &parts, &BuildOptions::default()).unwrap();
        let rays = rays(&mut random, &made, 200);
        assert!(check(&made, &rays) > 50);
    }
    let parts = GroupParts { instances: &made.instances[1..], ends: &[], boxes: &boxes };
    let objects = made.group.objects().to_vec();
    let error = Arc::make_mut(&mut made.group).refit(objects, &parts, &BuildOptions::default());
    assert_eq!(error, Err(GroupError::Refit(RefitError::Count { built: 80, given: 79 })));
}

/// The bound itself: places of hits, in double precision.
#[test]
fn hits_lie_within_the_padded_boxes() {
    let mut random = Random::new(9);
    let sphere = noisy_icosphere(1, 0.2, 1);
    let triangles = Triangles { positions: &sphere.positions, triangles: &sphere.triangles };
    let mesh = Arc::new(Bvh::build(&triangles, &BuildOptions::default()).unwrap());
    let extent = Extent::new(Some(sphere.bounds()), f64::from(mesh.space.reach), 0.0);
    let mut worst = 0.0_f64;
    for _ in 0..200 {
        let matrix = transform(&mut random, 3.0);
        let reach = Reach::new(Place::Still(&matrix), &extent, 1.0);
        let Reach::Box { min, max, base, by_reach, by_origin } = reach else { continue };
        let r = reach.needed();
        let inverse = inverse(&matrix).unwrap();
        for _ in 0..50 {
            let p = random.in_cube().map(|x| 0.8 * x);
            let target = matrix.map(|m| m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3]);
            let away = [1.0, 100.0][(random.bits() % 2) as usize] * r as f32;
            let origin = random.in_cube().map(|x| x * away);
            let direction: [f32; 3] = std::array::from_fn(|i| target[i] - origin[i]);
            let inside = Ray::new(
                inverse.map(|m| m[0] * origin[0] + m[1] * origin[1] + m[2] * origin[2] + m[3]),
                inverse.map(|m| m[0] * direction[0] + m[1] * direction[1] + m[2] * direction[2]),
            );
            let Some(hit) = mesh.intersect(&inside) else { continue };
            let a = origin.iter().fold(0.0_f64, |a, x| a.max(f64::from(x.abs())));
            for i in 0..3 {
                let x = f64::from(origin[i]) + f64::from(hit.t) * f64::from(direction[i]);
                let off = (min[i] - x).max(x - max[i]);
                worst = worst.max(off / (base[i] + by_reach[i] * r + by_origin[i] * a));
            }
        }
    }
    assert!(worst < 0.5, "{worst}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_group_equals_brute_force(
        seed in any::<u64>(),
        count in 0_usize..40,
        triangles in 0_usize..30,
        spread in 0.0_f32..100.0,
        spheres in 0_usize..5,
        moving in any::<bool>(),
        deep in any::<bool>(),
    ) {
        let mut random = Random::new(seed);
        let mut things = vec![mesh(&mut random, triangles), moving_mesh(&mut random, triangles / 2)];
        if deep {
            things.push(Thing::Group(Box::new(nested(&mut random, 2, moving))));
        }
        let placed = instances(&mut random, count, things.len(), spread);
        let ends = placed.iter().map(|_| transform(&mut random, spread)).collect();
        let made = Made::new(things, placed, if moving { ends } else { Vec::new() }, spheres);
        let rays = rays(&mut random, &made, 60);
        check(&made, &rays);
    }
}
