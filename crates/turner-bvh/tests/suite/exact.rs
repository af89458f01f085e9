//! `Bvh2` misses no box that a ray intersects in exact arithmetic, and the nearest primitive does not depend on the
//! BVH.

use turner_bvh::{Aabb, Bvh2, Bvh2Options, Ray};

use crate::common::{Random, Ratio, enter};

fn one_each() -> Bvh2Options {
    Bvh2Options { threads: 1, max_leaf: 1, ..Bvh2Options::default() }
}

fn power_of_two(n: i32) -> f64 {
    let factor = if n < 0 { 0.5 } else { 2.0 };
    (0..n.abs()).fold(1.0, |x, _| x * factor)
}

/// Boxes that are often flat, for rays that often run along their faces: coordinates up to `n`.
fn integer_boxes(random: &mut Random, count: usize, n: u32) -> Vec<Aabb> {
    (0..count).map(|_| Aabb::EMPTY.grow(random.integers(n)).grow(random.integers(n))).collect()
}

fn integer_ray(random: &mut Random, n: u32) -> Ray {
    let mut direction = random.integers(n);
    for d in &mut direction {
        if random.bits().is_multiple_of(4) {
            *d = if random.bits().is_multiple_of(2) { 0.0 } else { -0.0 };
        }
    }
    Ray::new(random.integers(n), direction)
}

/// Multiplies by powers of two, which is exact. `None` if a result is not representable.
fn scaled(ray: &Ray, boxes: &[Aabb], position: i32, direction: i32) -> Option<(Ray, Vec<Aabb>)> {
    let by = |x: f32, n: i32| {
        let y = f64::from(x) * power_of_two(n);
        let single = y as f32;
        (f64::from(single) == y || x.is_infinite()).then_some(single)
    };
    let all = |v: [f32; 3], n: i32| Some([by(v[0], n)?, by(v[1], n)?, by(v[2], n)?]);
    let ray = Ray {
        origin: all(ray.origin, position)?,
        direction: all(ray.direction, direction)?,
        t_min: by(ray.t_min, position - direction)?,
        t_max: by(ray.t_max, position - direction)?,
    };
    let boxes = boxes
        .iter()
        .map(|b| Some(Aabb::new(all(b.min, position)?, all(b.max, position)?)))
        .collect::<Option<_>>()?;
    Some((ray, boxes))
}

fn visited(bvh: &Bvh2, ray: &Ray) -> Vec<u32> {
    let mut seen = Vec::new();
    bvh.closest(ray, |range, t_max| {
        seen.extend(range.map(|i| bvh.order()[i as usize]));
        t_max
    });
    seen
}

fn visited_by_any(bvh: &Bvh2, ray: &Ray) -> Vec<u32> {
    let mut seen = Vec::new();
    let found = bvh.any(ray, |range| {
        seen.extend(range.map(|i| bvh.order()[i as usize]));
        false
    });
    assert!(!found);
    seen
}

#[test]
fn no_box_is_missed_at_any_scale() {
    let mut random = Random(1);
    let (mut hit_count, mut cases, mut plain_misses, mut extra_visits) = (0, 0, 0, 0);
    for round in 0..30_000 {
        let n = [2, 5, 1000, (1 << 24) - 1][round % 4];
        let boxes = integer_boxes(&mut random, 3, n);
        let mut ray = integer_ray(&mut random, n);
        if round % 3 == 0 {
            // At the entry into one of the boxes, or one float before or after it.
            if let Some(t) = enter(&ray, &boxes[0]).map(|t| t.nearest()).filter(|&t| t > 1e-4) {
                let t = [t, t.next_up(), t.next_down()][(random.bits() % 3) as usize];
                if random.bits().is_multiple_of(2) { ray.t_max = t } else { ray.t_min = t }
            }
        }
        let scale = |random: &mut Random| if round % 5 == 0 { 0 } else { random.integer(148) as i32 };
        let (position, direction) = (scale(&mut random), scale(&mut random));
        let Some((scaled_ray, scaled_boxes)) = scaled(&ray, &boxes, position, direction) else { continue };
        let bvh = Bvh2::build(&scaled_boxes, &one_each()).unwrap();
        let seen = visited(&bvh, &scaled_ray);
        let seen_by_any = visited_by_any(&bvh, &scaled_ray);
        cases += 1;
        for (i, b) in boxes.iter().enumerate() {
            let is_hit = enter(&ray, b).is_some();
            hit_count += usize::from(is_hit);
            if !is_hit && (position, direction) == (0, 0) {
                plain_misses += 1;
                extra_visits += usize::from(seen.contains(&(i as u32)));
            }
            assert!(
                !is_hit || seen.contains(&(i as u32)) && seen_by_any.contains(&(i as u32)),
                "missed {b:?} with {ray:?}, scaled by 2^{position}, 2^{direction}"
            );
        }
    }
    // The test has enough cases, and visiting everything does not pass.
    assert!(
        cases > 10_000 && hit_count > 5_000 && plain_misses > 5_000,
        "{cases} {hit_count} {plain_misses}"
    );
    assert!(extra_visits * 20 < plain_misses, "{extra_visits} of {plain_misses} misses were visited");
}

/// Boxes that a ray touches in one point of an edge, where any rounding in the wrong direction is a miss.
#[test]
fn no_touch_is_missed_at_any_scale() {
    let mut random = Random(5);
    let mut cases = 0;
    for round in 0..40_000 {
        // The ray reaches `origin + j * step` at t = j / m, which is often not a float.
        let step = random.integers(300);
        let origin = random.integers(1 << 20);
        let m = if round % 2 == 0 { 64.0 } else { random.integer(60).abs() + 1.0 };
        let j = random.integer(5000).abs();
        let mut ray = Ray::new(origin, step.map(|s| s * m));
        let p: [f32; 3] = std::array::from_fn(|k| origin[k] + j * step[k]);
        let mut b = Aabb::new(p, p);
        for (axis, step) in step.into_iter().enumerate() {
            // The ray enters through one face and leaves through another at the same t.
            let width = random.integer(1000).abs();
            if (random.bits().is_multiple_of(2)) == (step > 0.0) {
                b.max[axis] += width
            } else {
                b.min[axis] -= width
            }
        }
        if m == 64.0 {
            // Exactly at an end of the interval.
            if random.bits().is_multiple_of(2) { ray.t_max = j / m } else { ray.t_min = j / m }
        }
        assert!(enter(&ray, &b).is_some(), "{ray:?} {b:?}");
        let exponent = [0, 0, random.integer(120) as i32, -75][round / 2 % 4];
        let other = [0, random.integer(120) as i32, 0, 55 + random.integer(12) as i32][round / 2 % 4];
        let Some((ray, boxes)) = scaled(&ray, &[b], exponent, other) else { continue };
        cases += 1;
        let bvh = Bvh2::build(&boxes, &one_each()).unwrap();
        assert!(bvh.any(&ray, |_| true), "missed {b:?} with {ray:?}, scaled by 2^{exponent}, 2^{other}");
    }
    assert!(cases > 15_000, "{cases}");
}

/// Boxes as primitives: the nearest is the one entered first; among equal ones, the lowest index.
fn nearest(
    candidates: impl Iterator<Item = u32>,
    boxes: &[Aabb],
    ray: &Ray,
    best: &mut Option<(Ratio, u32)>,
) {
    for i in candidates {
        let Some(t) = enter(ray, &boxes[i as usize]) else { continue };
        if best.is_none_or(|(t_best, i_best)| t.cmp(&t_best).then(i.cmp(&i_best)).is_lt()) {
            *best = Some((t, i));
        }
    }
}

fn assert_nearest_as_brute_force(random: &mut Random, boxes: &[Aabb], n: u32, rays: usize) {
    for max_leaf in [1, 4] {
        let bvh = Bvh2::build(boxes, &Bvh2Options { max_leaf, ..one_each() }).unwrap();
        bvh.validate(boxes).unwrap();
        let mut hits = 0;
        for _ in 0..rays {
            let ray = integer_ray(random, n);
            let mut expected = None;
            nearest(0..boxes.len() as u32, boxes, &ray, &mut expected);
            let mut found = None;
            bvh.closest(&ray, |range, t_max| {
                nearest(range.map(|i| bvh.order()[i as usize]), boxes, &ray, &mut found);
                // Not below the exact value, as the contract requires.
                found.map_or(t_max, |(t, _)| if t.nearest() == 0.0 { 0.0 } else { t.nearest().next_up() })
            });
            assert_eq!(found.map(|(_, i)| i), expected.map(|(_, i)| i), "{ray:?}");
            let any = bvh.any(&ray, |mut range| {
                range.any(|i| enter(&ray, &boxes[bvh.order()[i as usize] as usize]).is_some())
            });
            assert_eq!(any, expected.is_some(), "{ray:?}");
            hits += usize::from(any);
        }
        assert!(hits > rays / 50 && hits < rays, "{hits} of {rays} hit");
    }
}

#[test]
fn ties_on_a_small_grid_go_to_the_lowest_index() {
    let mut random = Random(2);
    // Unit boxes on a grid of 13^3 points, many of them flat or equal.
    let boxes: Vec<Aabb> = (0..300)
        .map(|_| {
            let p = random.integers(6);
            Aabb::EMPTY.grow(p).grow(p.map(|x| x + (random.bits() % 2) as f32))
        })
        .collect();
    assert_nearest_as_brute_force(&mut random, &boxes, 9, 1500);
}

#[test]
fn nearest_box_of_a_wide_range_of_sizes() {
    let mut random = Random(3);
    let boxes: Vec<Aabb> = (0..200)
        .map(|i| {
            let p = random.integers(1 << 22);
            let size = random.integers(1 << (i % 22));
            Aabb::EMPTY.grow(p).grow([p[0] + size[0], p[1] + size[1], p[2] + size[2]])
        })
        .collect();
    assert_nearest_as_brute_force(&mut random, &boxes, 1 << 22, 1500);
}

#[test]
fn nearest_sphere_in_double_precision() {
    let mut random = Random(4);
    let spheres: Vec<([f64; 3], f64)> =
        (0..500).map(|_| (random.point().map(f64::from), f64::from(0.15 * random.unit()))).collect();
    let boxes: Vec<Aabb> = spheres
        .iter()
        .map(|(c, r)| {
            let r = r * (1.0 + 1e-6) + 1e-12;
            Aabb::outward(c.map(|c| c - r), c.map(|c| c + r))
        })
        .collect();
    let bvh = Bvh2::build(&boxes, &Bvh2Options::default()).unwrap();
    let hit = |i: u32, ray: &Ray| -> Option<f64> {
        let (c, r) = spheres[i as usize];
        let oc: [f64; 3] = std::array::from_fn(|k| c[k] - f64::from(ray.origin[k]));
        let d = ray.direction.map(f64::from);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (a, b, c) = (dot(d, d), dot(oc, d), dot(oc, oc) - r * r);
        let discriminant = b * b - a * c;
        let root = (discriminant >= 0.0).then(|| discriminant.sqrt())?;
        [(b - root) / a, (b + root) / a].into_iter().find(|&t| t >= 0.0)
    };
    let mut hits = 0;
    for _ in 0..3000 {
        let ray = Ray::new(random.point(), random.point());
        let nearer = |best: Option<(f64, u32)>, i: u32| match (best, hit(i, &ray)) {
            (None, Some(t)) => Some((t, i)),
            (Some((t_best, _)), Some(t)) if t < t_best => Some((t, i)),
            _ => best,
        };
        let expected = (0..spheres.len() as u32).fold(None, nearer);
        let mut found = None;
        let t_max = bvh.closest(&ray, |range, t_max| {
            found = range.map(|i| bvh.order()[i as usize]).fold(found, nearer);
            found.map_or(t_max, |(t, _)| (t as f32).next_up())
        });
        assert_eq!(found, expected, "{ray:?}");
        assert_eq!(t_max, found.map_or(f32::INFINITY, |(t, _)| (t as f32).next_up()));
        hits += usize::from(found.is_some());
    }
    assert!(hits > 1000 && hits < 3000, "{hits} hits");
}
