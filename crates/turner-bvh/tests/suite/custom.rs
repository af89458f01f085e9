//! `BoxBvh` against brute force.

use proptest::prelude::*;
use turner_bvh::{Aabb, BoxBvh, BuildOptions, Quality, Ray, RefitError};

use crate::common::{Random, enter};

fn build(boxes: &[Aabb]) -> BoxBvh {
    BoxBvh::build(boxes, &BuildOptions::default()).unwrap()
}

/// All four queries visit every box that the ray intersects in exact arithmetic.
fn check(bvh: &BoxBvh, boxes: &[Aabb], rays: &[Ray]) {
    let order = bvh.order();
    let mut of_batch = vec![Vec::new(); rays.len()];
    bvh.closest_batch(rays, |ray, range, t_max| {
        of_batch[ray].extend(range.map(|i| order[i as usize]));
        t_max
    });
    for (i, ray) in rays.iter().enumerate() {
        let mut seen = Vec::new();
        let t = bvh.closest(ray, |range, t_max| {
            seen.extend(range.map(|i| order[i as usize]));
            t_max
        });
        assert_eq!(t, ray.t_max);
        for (id, b) in boxes.iter().enumerate().filter(|(_, b)| b.is_valid()) {
            if enter(ray, b).is_some() {
                assert!(seen.contains(&(id as u32)), "{ray:?} misses {b:?}");
                assert!(of_batch[i].contains(&(id as u32)), "{ray:?} misses {b:?} in a batch");
                assert!(bvh.any(ray, |mut range| range.any(|i| order[i as usize] == id as u32)));
            }
        }
        seen.sort_unstable();
        seen.dedup();
        of_batch[i].sort_unstable();
        of_batch[i].dedup();
        assert_eq!(seen, of_batch[i]);
    }
    let mut any = vec![false; rays.len()];
    bvh.any_batch(rays, &mut any, |_, _| true);
    for (ray, any) in rays.iter().zip(any) {
        assert_eq!(bvh.any(ray, |_| true), any);
    }
}

fn scene(random: &mut Random, count: usize) -> (Vec<Aabb>, Vec<Ray>) {
    let boxes = (0..count)
        .map(|_| {
            let (a, b) = (random.integers(1000), random.integers(30).map(f32::abs));
            Aabb::new(a, [0, 1, 2].map(|i| a[i] + b[i]))
        })
        .collect();
    let rays = (0..60)
        .map(|i| {
            let mut ray = Ray::new(random.integers(2000), random.integers([3, 100, 2000][i % 3]));
            if i % 5 == 0 {
                ray.t_max = 2.0;
            }
            ray
        })
        .collect();
    (boxes, rays)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn no_box_is_missed(seed in any::<u64>(), count in 0_usize..300) {
        let mut random = Random(seed);
        let (mut boxes, rays) = scene(&mut random, count);
        if count > 3 {
            boxes[2].min[1] = f32::NAN;
        }
        let mut bvh = build(&boxes);
        prop_assert_eq!(bvh.dropped().len(), usize::from(count > 3));
        check(&bvh, &boxes, &rays);
        let (mut other, _) = scene(&mut random, count);
        if count > 3 {
            other[2] = boxes[2];
            other[3].max[0] = f32::INFINITY;
        }
        bvh.refit(&other).unwrap();
        check(&bvh, &other, &rays);
        if count > 3 {
            other[2] = other[1];
            prop_assert_eq!(bvh.refit(&other), Err(RefitError::Omitted { primitive: 2 }));
        }
    }
}

/// The nearest box that each ray enters, and its t; among equally near ones, the lowest index.
fn nearest(bvh: &BoxBvh, boxes: &[Aabb], rays: &[Ray]) -> Vec<Option<(f32, u32)>> {
    let mut found = vec![None; rays.len()];
    bvh.closest_batch(rays, |i, range, t_max| {
        for &id in &bvh.order()[range.start as usize..range.end as usize] {
            let b = &boxes[id as usize];
            let Some(t) = b.is_valid().then(|| enter(&rays[i], b)).flatten() else { continue };
            let hit = (t.nearest(), id);
            if found[i].is_none_or(|best| hit < best) {
                found[i] = Some(hit);
            }
        }
        found[i].map_or(t_max, |(t, _)| t.min(t_max))
    });
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn a_refitted_bvh_has_the_hits_of_a_fresh_one(seed in any::<u64>(), count in 1_usize..400) {
        let mut random = Random(seed);
        // Large enough that some rays hit.
        let large = |b: &Aabb| Aabb::new(b.min, b.max.map(|x| x + 600.0));
        let mut boxes_and_rays = || {
            let (boxes, rays) = scene(&mut random, count);
            (boxes.iter().map(large).collect::<Vec<Aabb>>(), rays)
        };
        let (first, rays) = boxes_and_rays();
        let mut refitted = build(&first);
        let mut hits = 0;
        for round in 0..5 {
            // Refits: a few boxes move, all move randomly, all coincide, one becomes invalid, all return.
            let (anywhere, _) = boxes_and_rays();
            let boxes: Vec<Aabb> = match round {
                0 => (0..count).map(|i| if i % 17 == 0 { anywhere[i] } else { first[i] }).collect(),
                1 => anywhere,
                2 => vec![first[0]; count],
                3 => {
                    let gone = Aabb::new([f32::NAN; 3], [0.0; 3]);
                    (0..count).map(|i| if i == count / 2 { gone } else { first[i] }).collect()
                }
                _ => first.clone(),
            };
            refitted.refit(&boxes).unwrap();
            let fresh = build(&boxes);
            let expected = nearest(&fresh, &boxes, &rays);
            prop_assert_eq!(nearest(&refitted, &boxes, &rays), expected.clone(), "round {}", round);
            prop_assert_eq!(refitted.bounds(), fresh.bounds());
            hits += expected.iter().flatten().count();
        }
        prop_assert!(count < 100 || hits > 20, "{} hits", hits);
    }
}

#[test]
fn t_is_in_the_units_of_the_caller() {
    let mut random = Random(5);
    for size in [1.0_f32, 1e-25, 1e25] {
        let boxes: Vec<Aabb> = (0..200)
            .map(|_| random.point().map(|x| x * size))
            .map(|p| Aabb::new(p, p.map(|x| x + 0.1 * size)))
            .collect();
        for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
            let bvh = BoxBvh::build(&boxes, &BuildOptions { quality, ..BuildOptions::default() }).unwrap();
            for i in 0..200 {
                let length = if i % 2 == 0 { size } else { 1.0 };
                let ray = Ray::new(random.point().map(|x| x * size), random.point().map(|x| x * length));
                let enters = |id: u32| {
                    let b = &boxes[id as usize];
                    let (mut near, mut far) = (0.0_f32, f32::INFINITY);
                    for axis in 0..3 {
                        let t =
                            [b.min[axis], b.max[axis]].map(|x| (x - ray.origin[axis]) / ray.direction[axis]);
                        near = near.max(t[0].min(t[1]));
                        far = far.min(t[0].max(t[1]));
                    }
                    (near <= far).then_some(near)
                };
                let expected = (0..200).filter_map(enters).fold(f32::INFINITY, f32::min);
                let found = bvh.closest(&ray, |range, t_max| {
                    range.filter_map(|i| enters(bvh.order()[i as usize])).fold(t_max, f32::min)
                });
                assert_eq!(found, expected, "{ray:?}");
            }
        }
    }
}

#[test]
fn every_valid_ray_is_traced() {
    let boxes = [Aabb::new([-1.0; 3], [1.0; 3])];
    let bvh = build(&boxes);
    let far = Ray::new([1e30, 0.0, 0.0], [-1e30, 0.0, 0.0]);
    let still = Ray::new([0.5; 3], [0.0; 3]);
    let slow = Ray::new([0.5; 3], [1e-44, 0.0, 0.0]);
    for ray in [far, still, slow] {
        assert_eq!(bvh.closest(&ray, |_, _| 0.25), 0.25);
        assert!(bvh.any(&ray, |_| true));
        let mut hits = [false];
        bvh.any_batch(&[ray], &mut hits, |_, _| true);
        assert!(hits[0]);
    }
    for bad in [Ray { t_min: f32::NAN, ..still }, Ray { origin: [f32::NAN; 3], ..still }] {
        assert!(!bvh.any(&bad, |_| true));
        bvh.closest_batch(&[bad], |_, _, _| panic!("an invalid ray visited a leaf"));
    }
    // NaN ends the traversal; larger values are ignored.
    assert!(bvh.closest(&Ray::new([0.0; 3], [1.0; 3]), |_, _| f32::NAN).is_nan());
    assert_eq!(bvh.closest(&Ray { t_max: 3.0, ..Ray::new([0.0; 3], [1.0; 3]) }, |_, _| 4.0), 3.0);
    let empty = build(&[]);
    assert_eq!(empty.bounds(), Aabb::EMPTY);
    assert!(!empty.any(&far, |_| true));
}
