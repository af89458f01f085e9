//! Builds of `Bvh2` are complete, of bounded depth, and the same for any number of threads.

use crate::common::Random;
use turner_bvh::{Aabb, Bvh2, Bvh2Options, MAX_DEPTH, Ray};

fn options(threads: usize) -> Bvh2Options {
    Bvh2Options { threads, ..Bvh2Options::default() }
}

fn small_boxes(count: usize, size: f32) -> Vec<Aabb> {
    let mut random = Random(7);
    (0..count)
        .map(|_| {
            let p = random.point();
            let s = size * random.unit();
            Aabb::new(p, p.map(|x| x + s))
        })
        .collect()
}

#[test]
fn the_same_bvh_for_any_number_of_threads() {
    let mut boxes = small_boxes(60_000, 0.02);
    // Identical boxes need halving, in a subtree that another thread builds.
    boxes.extend(vec![Aabb::new([0.5; 3], [0.6; 3]); 10_000]);
    let one = Bvh2::build(&boxes, &options(1)).unwrap();
    one.validate(&boxes).unwrap();
    for threads in [0, 2, 7, 16] {
        assert!(Bvh2::build(&boxes, &options(threads)).unwrap() == one, "{threads} threads");
    }
}

#[test]
fn the_sah_cost_is_low() {
    let boxes = small_boxes(10_000, 0.02);
    let stats = *Bvh2::build(&boxes, &options(1)).unwrap().stats();
    // The cost is 50.1; a list costs 10,000.
    assert!(stats.sah_cost < 52.0, "{stats:?}");
    assert!(stats.max_depth < 30 && stats.leaves == stats.nodes + 1, "{stats:?}");
    assert!(stats.bytes <= 68 * boxes.len(), "{stats:?}");
}

#[test]
fn invalid_boxes_are_dropped_and_counted() {
    let good = Aabb::new([0.0; 3], [1.0; 3]);
    let nan = Aabb { min: [f32::NAN, 0.0, 0.0], ..good };
    let infinite = Aabb { max: [1.0, f32::INFINITY, 1.0], ..good };
    let inverted = Aabb { max: [1.0, 1.0, -1.0], ..good };
    let boxes = [nan, good, infinite, good, inverted, Aabb::EMPTY];
    let bvh = Bvh2::build(&boxes, &options(0)).unwrap();
    bvh.validate(&boxes).unwrap();
    assert_eq!(bvh.dropped(), [0, 2, 4, 5]);
    assert_eq!(bvh.stats().dropped, 4);
    assert_eq!(bvh.bounds(), good);
    let none = Bvh2::build(&boxes[4..], &options(1)).unwrap();
    none.validate(&boxes[4..]).unwrap();
    assert_eq!((none.order().len(), none.dropped().len(), none.bounds()), (0, 2, Aabb::EMPTY));
}

#[test]
fn no_primitive_and_one_primitive() {
    let none = Bvh2::build(&[], &options(0)).unwrap();
    none.validate(&[]).unwrap();
    assert_eq!((none.stats().nodes, none.stats().leaves, none.stats().bytes), (0, 0, 0));
    let point = [Aabb::new([1.0; 3], [1.0; 3])];
    let one = Bvh2::build(&point, &options(0)).unwrap();
    one.validate(&point).unwrap();
    assert_eq!((one.stats().nodes, one.stats().leaves, one.stats().max_depth), (1, 1, 1));
    assert!(one.any(&Ray::new([0.0; 3], [1.0; 3]), |range| range == (0..1)));
    assert!(!one.any(&Ray::new([0.0; 3], [1.0, 1.0, 1.001]), |_| true));
}

#[test]
fn a_million_identical_boxes() {
    let boxes = vec![Aabb::new([0.0; 3], [1.0; 3]); 1_000_000];
    let bvh = Bvh2::build(&boxes, &options(2)).unwrap();
    bvh.validate(&boxes).unwrap();
    assert!(bvh.stats().max_depth <= 20, "{:?}", bvh.stats());
}

#[test]
fn concentric_boxes_are_split_by_size() {
    // Halving in input order would give two children as large as their parent.
    let mut random = Random(3);
    let boxes: Vec<Aabb> = (0..64).map(|_| random.unit()).map(|r| Aabb::new([-r; 3], [r; 3])).collect();
    let bvh = Bvh2::build(&boxes, &options(1)).unwrap();
    bvh.validate(&boxes).unwrap();
    let mut visits = 0;
    bvh.closest(&Ray::new([0.999, 0.9, -2.0], [0.0, 0.0, 1.0]), |range, t_max| {
        visits += range.len();
        t_max
    });
    assert!(visits <= 8, "{visits} visits");
}

#[test]
fn depth_is_bounded_for_boxes_that_grow_exponentially() {
    // Each split separates only the largest few, over the range of f32.
    let mut boxes = Vec::new();
    for axis in 0..3 {
        let mut x = f32::MIN_POSITIVE;
        while x < f32::MAX / 2.0 {
            let mut p = [0.0; 3];
            p[axis] = x;
            boxes.push(Aabb::new(p, p));
            boxes.push(Aabb::new(p.map(|x| -x), p));
            x *= 1.5;
        }
    }
    for bins in [0, 2, 3, 16, 255] {
        for max_leaf in [0, 1, 4, 255] {
            let bvh = Bvh2::build(&boxes, &Bvh2Options { threads: 1, bins, max_leaf }).unwrap();
            bvh.validate(&boxes).unwrap();
            assert!(bvh.stats().max_depth <= MAX_DEPTH);
            if bins == 2 && max_leaf == 1 {
                assert!(bvh.stats().max_depth > 40, "no test of the bound: {:?}", bvh.stats());
            }
        }
    }
}

#[test]
fn boxes_at_the_ends_of_the_range() {
    let ends = [f32::MIN, -1.0, -1e-45, 0.0, 1e-45, 1.0, f32::MAX];
    let mut boxes = Vec::new();
    for x in ends {
        for y in ends {
            boxes.extend(ends.map(|z| Aabb::new([x, y, z], [x, y, z])));
        }
    }
    boxes.push(Aabb::new([f32::MIN; 3], [f32::MAX; 3]));
    let bvh = Bvh2::build(&boxes, &options(1)).unwrap();
    bvh.validate(&boxes).unwrap();
    assert!(bvh.stats().sah_cost.is_finite());
}
