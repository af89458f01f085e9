//! Traversal of `Bvh2`: order, pruning, early exit, and termination for any input.

use proptest::prelude::*;
use turner_bvh::{Aabb, Bvh2, Bvh2Options, Ray};

use crate::common::Random;

/// Unit cubes at even x.
fn row(count: usize) -> Vec<Aabb> {
    (0..count).map(|i| Aabb::new([2.0 * i as f32, 0.0, 0.0], [2.0 * i as f32 + 1.0, 1.0, 1.0])).collect()
}

fn build(boxes: &[Aabb], max_leaf: u8) -> Bvh2 {
    Bvh2::build(boxes, &Bvh2Options { threads: 1, max_leaf, ..Bvh2Options::default() }).unwrap()
}

#[test]
fn near_boxes_come_first_and_far_ones_are_pruned() {
    let bvh = build(&row(64), 1);
    for (origin, direction) in [(-1.0, 1.0), (200.0, -1.0)] {
        let ray = Ray::new([origin, 0.5, 0.5], [direction, 0.0, 0.0]);
        let mut seen = Vec::new();
        bvh.closest(&ray, |range, t_max| {
            seen.extend(range.map(|i| bvh.order()[i as usize]));
            t_max
        });
        let mut expected: Vec<u32> = (0..64).collect();
        if direction < 0.0 {
            expected.reverse();
        }
        assert_eq!(seen, expected);
        let mut visits = 0;
        let t = bvh.closest(&ray, |_, _| {
            visits += 1;
            1.5
        });
        assert_eq!((visits, t), (1, 1.5), "everything but the first box begins beyond 1.5");
    }
}

#[test]
fn boxes_as_near_as_the_nearest_hit_are_visited() {
    let boxes = vec![Aabb::new([0.0, 0.0, 1.0], [1.0, 1.0, 1.0]); 20];
    let bvh = build(&boxes, 1);
    let mut visits = 0;
    bvh.closest(&Ray::new([0.3, 0.3, 0.0], [0.0, 0.0, 1.0]), |range, _| {
        visits += range.len();
        1.0
    });
    assert_eq!(visits, 20);
}

#[test]
fn a_larger_t_max_is_ignored_and_nan_ends_the_traversal() {
    let bvh = build(&row(64), 1);
    let ray = Ray { t_max: 3.0, ..Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]) };
    let mut visits = 0;
    let t = bvh.closest(&ray, |_, _| {
        visits += 1;
        1e9
    });
    assert_eq!((visits, t), (2, 3.0));
    visits = 0;
    bvh.closest(&ray, |_, _| {
        visits += 1;
        f32::NAN
    });
    assert_eq!(visits, 1);
}

#[test]
fn any_stops_at_the_first_hit() {
    let bvh = build(&row(64), 1);
    let ray = Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
    let mut visits = 0;
    assert!(bvh.any(&ray, |_| {
        visits += 1;
        visits == 3
    }));
    assert_eq!(visits, 3);
    assert!(!bvh.any(&ray, |_| false));
    assert!(!bvh.any(&Ray { t_max: 0.9, ..ray }, |_| true));
    assert!(!bvh.any(&Ray { t_min: 128.1, ..ray }, |_| true));
}

#[test]
fn from_inside_and_from_a_negative_start() {
    let bvh = build(&row(3), 1);
    let ray = Ray { t_min: -10.0, ..Ray::new([2.5, 0.5, 0.5], [1.0, 0.0, 0.0]) };
    let mut seen = Vec::new();
    bvh.closest(&ray, |range, t_max| {
        seen.extend(range.map(|i| bvh.order()[i as usize]));
        t_max
    });
    assert_eq!(
        seen,
        [1, 2],
        "the traversal starts at 0: it visits the box around the origin, but nothing behind it"
    );
}

#[test]
fn an_empty_bvh_and_invalid_rays_visit_nothing() {
    let nothing = build(&[], 4);
    assert!(!nothing.any(&Ray::new([0.0; 3], [1.0; 3]), |_| true));
    let bvh = build(&row(64), 4);
    for bad in [f32::NAN, f32::INFINITY] {
        for axis in 0..3 {
            let mut ray = Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
            ray.origin[axis] = bad;
            assert!(!bvh.any(&ray, |_| true));
            let mut ray = Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
            ray.direction[axis] = bad;
            assert!(!bvh.any(&ray, |_| true));
        }
    }
}

fn any_float() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<u32>().prop_map(f32::from_bits),
        -2.0..2.0_f32,
        prop::sample::select(vec![0.0, -0.0, 1.0, f32::MAX, f32::MIN, f32::INFINITY, f32::NAN, 1e-45]),
    ]
}

fn any_triple() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(any_float())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    /// For any bits in boxes, rays and answers, traversal ends and visits no primitive twice.
    #[test]
    fn every_traversal_ends(
        corners in prop::collection::vec((any_triple(), any_triple()), 0..60),
        (origin, direction) in (any_triple(), any_triple()),
        (t_min, t_max) in (any_float(), any_float()),
        answers in prop::collection::vec(any_float(), 1..8),
    ) {
        let boxes: Vec<Aabb> = corners.iter().map(|&(a, b)| Aabb::EMPTY.grow(a).grow(b)).collect();
        let bvh = build(&boxes, 2);
        prop_assert_eq!(bvh.validate(&boxes), Ok(()));
        let ray = Ray { origin, direction, t_min, t_max };
        let mut visited = vec![0; bvh.order().len()];
        let mut answers = answers.into_iter().cycle();
        bvh.closest(&ray, |range, _| {
            range.for_each(|i| visited[i as usize] += 1);
            answers.next().unwrap_or(0.0)
        });
        prop_assert!(visited.iter().all(|&n| n <= 1));
    }

    /// A ray through a point of a box hits that box. The box is enlarged by the rounding error of the direction.
    #[test]
    fn a_ray_aimed_at_a_box_hits_it(seed in any::<u64>(), scale in -60..60_i32) {
        let mut random = Random(seed);
        let scale = (0..scale.abs()).fold(1.0_f32, |x, _| if scale < 0 { x * 0.5 } else { x * 2.0 });
        let boxes: Vec<Aabb> = (0..50)
            .map(|_| {
                let p = random.point().map(|x| x * scale);
                Aabb::new(p.map(|x| x - 1e-5 * scale), p.map(|x| x + 1e-5 * scale))
            })
            .collect();
        let bvh = build(&boxes, 4);
        let origin = random.point().map(|x| x * scale);
        for (i, target) in boxes.iter().map(|b| b.center()).enumerate() {
            let direction: [f32; 3] = std::array::from_fn(|k| target[k] - origin[k]);
            let ray = Ray { t_max: 1.01, ..Ray::new(origin, direction) };
            prop_assert!(bvh.any(&ray, |mut range| range.any(|k| bvh.order()[k as usize] as usize == i)));
        }
    }
}
