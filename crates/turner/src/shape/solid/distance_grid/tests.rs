use super::*;
use crate::schema::{Limits, Memory, PrepareOptions};
use crate::shape::{Shape, ShapeDesc};
use crate::testing::Random;

/// A grid of a function in the box from -1 to 1.
fn sampled(size: [u32; 3], f: impl Fn(DVec3) -> f64) -> DistanceGridDesc {
    let at = |i: u32, n: u32| 2.0 * f64::from(i) / f64::from(n - 1) - 1.0;
    let mut values = Vec::new();
    for z in 0..size[2] {
        for y in 0..size[1] {
            let row = (0..size[0]).map(|x| DVec3::new(at(x, size[0]), at(y, size[1]), at(z, size[2])));
            values.extend(row.map(|p| f(p) as f32));
        }
    }
    let data = Arc::new(GridData::of_distances(size, values).unwrap());
    DistanceGridDesc { file: GridFile { uri: String::new(), data }, ..DistanceGridDesc::default() }
}

fn prepared(desc: &DistanceGridDesc) -> Shape {
    ShapeDesc::DistanceGrid(desc.clone()).prepare(&mut MeshCache::new(&[])).unwrap()
}

/// All hits of a ray.
fn hits(shape: &Shape, ray: &Ray) -> Vec<f64> {
    let (mut found, mut ray) = (Vec::new(), *ray);
    while let Some(hit) = shape.intersect(&ray) {
        found.push(hit.t);
        ray.t_min = hit.t.next_up();
    }
    found
}

/// The interpolation in the box from -1 to 1, weight by weight.
fn interpolated(desc: &DistanceGridDesc, p: DVec3) -> f64 {
    let size = desc.file.data.size();
    let mut sum = 0.0;
    for (i, value) in desc.file.data.density().iter().enumerate() {
        let i = i as u32;
        let at = [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
        let weight = |axis: usize| {
            let q = 0.5 * (p[axis] + 1.0) * f64::from(size[axis] - 1);
            (1.0 - (q - f64::from(at[axis])).abs()).max(0.0)
        };
        sum += f64::from(*value) * weight(0) * weight(1) * weight(2);
    }
    sum
}

#[test]
fn linear_functions_are_exact() {
    let (n, c) = (DVec3::new(0.5, -0.25, 1.0), 0.125);
    let desc = DistanceGridDesc { capped: false, ..sampled([5, 3, 9], |p| p.dot(n) + c) };
    let mut random = Random::new(1);
    let mut found = 0;
    for smooth in [false, true] {
        let shape = prepared(&DistanceGridDesc { smooth, ..desc.clone() });
        for _ in 0..400 {
            let origin = 3.0 * random.direction();
            let ray = Ray::new(origin, random.in_cube() - origin);
            let t = -(ray.origin.dot(n) + c) / ray.direction.dot(n);
            let inside = ray.at(t).abs().max_element();
            let hit = shape.intersect(&ray).filter(|_| (inside - 1.0).abs() > 1e-9);
            let expected = inside < 1.0 - 1e-9 && t > 0.0;
            assert_eq!(hit.is_some(), expected, "{ray:?} {t}");
            let Some(hit) = hit else { continue };
            found += 1;
            assert!((hit.t - t).abs() < 1e-13, "{} {t}", hit.t);
            let s = shape.surface(&ray, &hit);
            assert!((s.ng - n.normalize()).length() < 1e-13 && (s.ns - s.ng).length() < 1e-13);
        }
    }
    assert!(found > 200, "{found}");
}

/// The error of trilinear interpolation is at most h²/8 times the sum of the second derivatives along the axes, which
/// is 2/r for the distance from a sphere.
#[test]
fn a_sphere_is_as_exact_as_its_grid() {
    let radius = 0.6;
    let shape = prepared(&sampled([32; 3], |p| p.length() - radius));
    let step = 2.0 / 31.0;
    let most = step * step / 8.0 * 2.0 / (radius - step);
    let mut random = Random::new(2);
    let (mut smooth, mut flat) = (0.0f64, 0.0f64);
    for _ in 0..2000 {
        let origin = 3.0 * random.direction();
        let ray = Ray::new(origin, 0.5 * random.in_cube() - origin);
        let found = hits(&shape, &ray);
        // The hull of the interpolation is within its error.
        let nearest =
            ray.origin - ray.direction * (ray.origin.dot(ray.direction) / ray.direction.length_squared());
        assert!(found.len() == 2 || nearest.length() > radius - most, "{found:?} {ray:?}");
        let Some(hit) = shape.intersect(&ray) else { continue };
        let s = shape.surface(&ray, &hit);
        assert!((s.p.length() - radius).abs() < most, "{}", s.p.length() - radius);
        let n = s.p.normalize();
        (smooth, flat) = (smooth.max((s.ns - n).length()), flat.max((s.ng - n).length()));
    }
    // Second derivatives times half a cell, and what remains of them between cells.
    assert!(flat < step / radius && smooth < 0.25 * flat, "{flat} {smooth}");
}

#[test]
fn smooth_normals_are_continuous() {
    let mut random = Random::new(3);
    let desc = sampled([9, 8, 7], |p| p.length() - 0.7 + 0.2 * p.x * p.y);
    let Solid::DistanceGrid(grid) = desc.prepare_solid(&mut MeshCache::new(&[])).unwrap() else { panic!() };
    for i in 0..300 {
        // On a plane of vertices or of the centres of cells.
        let mut p = random.in_cube();
        let axis = i % 3;
        let cells = grid.field.lattice.cells[axis] as f64;
        let half = f64::from((random.unit() * 2.0 * cells) as u32) * 0.5;
        p[axis] = 2.0 * half / cells - 1.0;
        let away = 1e-9 * DVec3::AXES[axis];
        let [a, b] = [p - away, p + away].map(|p| grid.field.lattice.smooth_normal(p).unwrap());
        assert!((a - b).length() < 1e-6, "{p}: {a} {b}");
    }
}

/// Random values have up to three crossings in a cell.
#[test]
fn all_crossings_are_found() {
    let mut random = Random::new(4);
    let mut three = 0;
    for capped in [false, true] {
        let values: Vec<f64> = (0..6 * 5 * 7).map(|_| 2.0 * random.unit() - 1.0).collect();
        let next = std::cell::Cell::new(0);
        let desc = sampled([6, 5, 7], |_| values[next.replace(next.get() + 1)]);
        let desc = DistanceGridDesc { capped, ..desc };
        let shape = prepared(&desc);
        for _ in 0..150 {
            let origin = 3.0 * random.direction();
            let ray = Ray::new(origin, random.in_cube() - origin);
            let found = hits(&shape, &ray);
            let value = |t: f64| {
                let p = ray.at(t);
                if p.abs().max_element() > 1.0 { None } else { Some(interpolated(&desc, p)) }
            };
            for t in &found {
                let near = value(*t).unwrap_or(0.0).abs();
                let is_face = ray.at(*t).abs().max_element() > 1.0 - 1e-12;
                assert!(near < 1e-12 || capped && is_face, "{near}");
            }
            let below = |t: f64| value(t).map_or(capped.then_some(false), |v| Some(v < 0.0));
            // Between two steps there is an odd number of crossings if the sign changes, else an even one.
            let steps = 700;
            for i in 0..steps {
                let [a, b] = [i, i + 1].map(|i| 2.5 * f64::from(i) / f64::from(steps));
                let (Some(before), Some(after)) = (below(a), below(b)) else { continue };
                let count = found.iter().filter(|t| (a..b).contains(*t)).count();
                assert_eq!(count % 2 == 1, before != after, "{a} {b}: {found:?} {ray:?}");
                three += usize::from(count > 1);
            }
            assert!(!capped || found.len().is_multiple_of(2), "{found:?}");
            // What is found does not depend on where the ray begins.
            for (i, t) in found.iter().enumerate() {
                let later = Ray { t_min: *t, ..ray };
                assert_eq!(hits(&shape, &later), found[i..], "{ray:?}");
            }
        }
    }
    assert!(three > 0);
}

/// The surface lies in a plane of vertices, on which rays pass from cell to cell, along edges and through vertices.
#[test]
fn surfaces_in_planes_of_vertices_have_one_crossing() {
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let desc = DistanceGridDesc { capped: false, ..sampled([5; 3], |p| sign * p[axis]) };
            let shape = prepared(&desc);
            for (x, y) in [(0.0f64, 0.0), (0.5, 0.0), (0.25, 0.1), (0.5, -0.5), (1.0, 0.3), (-1.0, -1.0)] {
                for slope in [DVec3::ZERO, DVec3::new(0.25, 0.5, 0.0), DVec3::splat(0.5)] {
                    if x.abs() == 1.0 && slope != DVec3::ZERO {
                        // It would leave the box at the surface.
                        continue;
                    }
                    let mut target = DVec3::ZERO;
                    (target[(axis + 1) % 3], target[(axis + 2) % 3]) = (x, y);
                    let mut direction = slope;
                    direction[axis] = -1.0;
                    let ray = Ray::new(target - 2.0 * direction, direction);
                    let found = hits(&shape, &ray);
                    assert_eq!(found, [2.0], "{ray:?}");
                    let s = shape.surface(&ray, &shape.intersect(&ray).unwrap());
                    assert!((s.ng[axis] - sign).abs() < 1e-12, "{}", s.ng);
                }
            }
        }
    }
}

#[test]
fn levels_move_the_surface_and_faces_close_it() {
    let ball = sampled([33; 3], |p| p.length() - 0.5);
    let along = Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z);
    for (level, capped, ends) in [
        (0.0, true, Some([2.5, 3.5])),
        (0.25, false, Some([2.25, 3.75])),
        (0.75, true, Some([2.0, 4.0])),
        (0.75, false, None),
    ] {
        let shape = prepared(&DistanceGridDesc { level, capped, ..ball.clone() });
        assert_eq!(shape.is_closed(), ends.is_some());
        let bounds = shape.bounds().unwrap();
        let found = hits(&shape, &along);
        assert_eq!(found.len(), if ends.is_some() { 2 } else { 0 }, "{level}: {found:?}");
        for (t, expected) in found.iter().zip(ends.into_iter().flatten()) {
            assert!((t - expected).abs() < 1e-6, "{t} {expected}");
            assert!(along.at(*t).z <= bounds.max.z && along.at(*t).z >= bounds.min.z);
        }
        // The bounds are those of the surface, not those of the grid.
        assert_eq!(bounds.max.x < 0.9, level < 0.5, "{bounds:?}");
    }
}

#[test]
fn grids_that_are_none_are_refused() {
    let error = |desc: DistanceGridDesc| desc.prepare_solid(&mut MeshCache::new(&[])).unwrap_err().message;
    let flat = GridData::of_distances([4, 1, 4], vec![0.5; 16]).unwrap();
    let flat = GridFile { uri: String::new(), data: Arc::new(flat) };
    let message = error(DistanceGridDesc { file: flat, ..DistanceGridDesc::default() });
    assert!(message.contains("found 4 × 1 × 4"), "{message}");
    let message = error(DistanceGridDesc { min: Some(DVec3::ONE), ..DistanceGridDesc::default() });
    assert!(message.contains("`min` of a distance grid must be less"), "{message}");
    for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY] {
        let message = GridData::of_distances([2, 2, 2], vec![bad; 8]).unwrap_err();
        assert!(message.contains("expected -1e30 to 1e30"), "{message}");
    }
    assert!(GridData::of_distances([2, 2, 2], vec![0.0; 7]).is_err());
    let mut meshes = MeshCache::new(&[]);
    DistanceGridDesc { level: -2.0, ..DistanceGridDesc::default() }.prepare_solid(&mut meshes).unwrap();
    assert!(meshes.warnings()[0].contains("has no surface"), "{:?}", meshes.warnings());
    let limits = Limits { memory: Arc::new(Memory::new(1000, || None)), ..Limits::default() };
    let options = PrepareOptions { limits, ..PrepareOptions::default() };
    let large = sampled([128; 3], |p| p.length() - 0.5);
    let error = large.prepare_solid(&mut MeshCache::with_options(&[], &options)).err().unwrap();
    assert!(error.message.contains("the cells of a distance grid needs"), "{}", error.message);
}

/// The largest values that a file may have.
#[test]
fn huge_values_give_finite_surfaces() {
    let desc = sampled([4; 3], |p| if p.x + p.y > 0.1 { 1e30 } else { -1e-30 });
    let shape = prepared(&desc);
    let mut random = Random::new(5);
    for _ in 0..200 {
        let origin = 3.0 * random.direction();
        let ray = Ray::new(origin, random.in_cube() - origin);
        let Some(hit) = shape.intersect(&ray) else { continue };
        let s = shape.surface(&ray, &hit);
        assert!(s.p.is_finite() && s.ng.is_normalized() && s.ns.is_normalized() && s.error.is_finite());
    }
}

/// Cells of a grid of densities have their values at their centres.
#[test]
fn the_first_and_the_last_values_lie_on_the_box() {
    let bounds = [DVec3::ZERO, DVec3::new(4.0, 2.0, 2.0)];
    let densities = GridData::new([4, 2, 2], vec![1.0; 16], None).unwrap().with_bounds(bounds).unwrap();
    assert_eq!(densities.vertex_bounds(), Some([DVec3::splat(0.5), DVec3::new(3.5, 1.5, 1.5)]));
    let distances = GridData::of_distances([4, 2, 2], vec![1.0; 16]).unwrap().with_bounds(bounds).unwrap();
    assert_eq!(distances.vertex_bounds(), Some(bounds));
    let file = GridFile { uri: String::new(), data: Arc::new(distances) };
    let desc = DistanceGridDesc { file, max: Some(DVec3::splat(9.0)), ..DistanceGridDesc::default() };
    assert_eq!(desc.bounds(), [DVec3::ZERO, DVec3::splat(9.0)]);
}
