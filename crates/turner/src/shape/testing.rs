//! Shared by the tests of all shapes: random rays, and properties checked against a slow oracle.
//!
//! The oracle knows a shape only as a list of sheets. A sheet is a function that changes its sign at the
//! surface, and a predicate for which of its zeros belong to the shape. The oracle marches along the ray in
//! small steps and bisects where the sign changes.

use super::*;
use crate::math::{DAffine3, DMat3};
pub(crate) use crate::testing::Random;

type Value = Box<dyn Fn(DVec3) -> f64>;

pub(super) struct Sheet {
    value: Value,
    belongs: Box<dyn Fn(DVec3) -> bool>,
}

pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) shape: Shape,
    pub(super) sheets: Vec<Sheet>,
}

pub(super) fn solid(value: impl Fn(DVec3) -> f64 + 'static) -> Vec<Sheet> {
    vec![Sheet { value: Box::new(value), belongs: Box::new(|_| true) }]
}

pub(super) fn sheet(
    value: impl Fn(DVec3) -> f64 + 'static,
    belongs: impl Fn(DVec3) -> bool + 'static,
) -> Vec<Sheet> {
    vec![Sheet { value: Box::new(value), belongs: Box::new(belongs) }]
}

/// Distance from an axis, and height along it.
fn around(p: DVec3, from: DVec3, axis: DVec3) -> (f64, f64) {
    let z = (p - from).dot(axis);
    ((p - from - z * axis).length(), z)
}

fn cases() -> Vec<Case> {
    let c = DVec3::new(0.3, -0.2, 0.1);
    let n = DVec3::new(0.3, 0.8, -0.5);
    let unit = n.normalize();
    let prepare = |desc: ShapeDesc| desc.prepare(&mut MeshCache::new(&[])).unwrap();
    let mut cases = vec![
        Case {
            name: "sphere",
            shape: prepare(ShapeDesc::Sphere(SphereDesc { center: c, radius: 0.9 })),
            sheets: solid(move |p| p.distance(c) - 0.9),
        },
        Case {
            name: "plane",
            shape: prepare(ShapeDesc::Plane(PlaneDesc { point: c, normal: n })),
            sheets: solid(move |p| (p - c).dot(unit)),
        },
        Case {
            name: "box",
            shape: Shape::Box(Cuboid { min: c - DVec3::new(0.5, 0.7, 0.9), max: c + DVec3::splat(0.6) }),
            sheets: solid(move |p| (c - DVec3::new(0.5, 0.7, 0.9) - p).max(p - c - 0.6).max_element()),
        },
        Case {
            name: "ring",
            shape: prepare(ShapeDesc::Disk(DiskDesc {
                center: c,
                normal: n,
                radius: 1.0,
                inner_radius: 0.4,
                polar: false,
            })),
            sheets: sheet(move |p| (p - c).dot(unit), move |p| (0.4..=1.0).contains(&p.distance(c))),
        },
    ];
    let (u, v) = (DVec3::new(1.0, 0.2, 0.3), DVec3::new(-0.4, 1.2, 0.5));
    let m = u.cross(v).normalize();
    cases.push(Case {
        name: "rectangle",
        shape: prepare(ShapeDesc::Rectangle(RectangleDesc { center: c, edge_u: u, edge_v: v })),
        sheets: sheet(
            move |p| (p - c).dot(m),
            move |p| {
                let a = DMat3::from_cols(u, v, m).inverse() * (p - c);
                a.x.abs() <= 0.5 && a.y.abs() <= 0.5
            },
        ),
    });
    let (from, to) = (c - 0.8 * unit, c + 0.5 * unit);
    for capped in [true, false] {
        let desc = CylinderDesc { from, to, radius: 0.6, capped };
        let side = move |p| around(p, from, unit).0 - 0.6;
        cases.push(Case {
            name: "cylinder",
            shape: prepare(ShapeDesc::Cylinder(desc)),
            sheets: if capped {
                solid(move |p| side(p).max(around(p, from, unit).1 - 1.3).max(-around(p, from, unit).1))
            } else {
                sheet(side, move |p| (0.0..=1.3).contains(&around(p, from, unit).1))
            },
        });
        for (radius, tip) in [(0.9, 0.0), (0.8, 0.3), (0.2, 0.9), (0.6, 0.6 - 1e-9)] {
            let desc = ConeDesc { from, to, radius, tip_radius: tip, capped };
            let side = move |p| {
                let (rho, z) = around(p, from, unit);
                rho - (radius + (tip - radius) * z / 1.3)
            };
            cases.push(Case {
                name: "cone",
                shape: prepare(ShapeDesc::Cone(desc)),
                sheets: if capped {
                    solid(move |p| side(p).max(around(p, from, unit).1 - 1.3).max(-around(p, from, unit).1))
                } else {
                    sheet(side, move |p| (0.0..=1.3).contains(&around(p, from, unit).1))
                },
            });
        }
    }
    for (radius, tube_radius) in [(0.8, 0.3), (0.5, 0.5), (1.0, 0.02)] {
        cases.push(Case {
            name: "torus",
            shape: prepare(ShapeDesc::Torus(TorusDesc { center: c, axis: n, radius, tube_radius })),
            sheets: solid(move |p| {
                let (rho, z) = around(p, c, unit);
                ((rho - radius) * (rho - radius) + z * z).sqrt() - tube_radius
            }),
        });
    }
    cases.extend(super::solid::testing::cases());
    cases
}

#[test]
fn every_shape_has_a_case() {
    // Meshes, shapes that become meshes, point clouds and curves have tests of their own.
    let is_data =
        |name| matches!(name, "mesh" | "points" | "curves" | "height_field" | "parametric" | "text");
    let formulas = ShapeDesc::DOC.entries.iter().filter(|e| !is_data(e.name));
    for entry in formulas {
        assert!(cases().iter().any(|c| c.shape.word() == entry.name), "no case for the shape {}", entry.name);
    }
}

impl Case {
    /// The nearest zero of a sheet that belongs to the shape, marching from 0 to `end`.
    fn oracle(&self, ray: &Ray, end: f64, steps: u32) -> Option<f64> {
        let first = |sheet: &Sheet| {
            let at = |i: u32| end * f64::from(i) / f64::from(steps);
            let mut before = (sheet.value)(ray.at(0.0)) < 0.0;
            for i in 1..=steps {
                let inside = (sheet.value)(ray.at(at(i))) < 0.0;
                if inside != before {
                    let (mut a, mut b) = (at(i - 1), at(i));
                    for _ in 0..60 {
                        let middle = 0.5 * (a + b);
                        let same = ((sheet.value)(ray.at(middle)) < 0.0) == before;
                        if same { a = middle } else { b = middle }
                    }
                    if (sheet.belongs)(ray.at(b)) {
                        return Some(b);
                    }
                }
                before = inside;
            }
            None
        };
        self.sheets.iter().filter_map(first).min_by(f64::total_cmp)
    }

    /// Whether the ray is nearly tangent to the surface or near its rim, where the oracle may be wrong.
    fn doubtful(&self, ray: &Ray, t: f64) -> bool {
        let p = ray.at(t);
        let d = ray.direction.normalize();
        self.sheets.iter().any(|s| {
            let slope = ((s.value)(p + 1e-6 * d) - (s.value)(p - 1e-6 * d)) / 2e-6;
            slope.abs() < 0.02
                || [DVec3::X, DVec3::Y, DVec3::Z]
                    .iter()
                    .any(|e| (s.belongs)(p + 1e-3 * e) != (s.belongs)(p - 1e-3 * e))
        })
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let f = &self.sheets[0].value;
        let h = 1e-6;
        DVec3::from(DVec3::AXES.map(|e| (f(p + h * e) - f(p - h * e)) / (2.0 * h)))
    }
}

fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = if i % 3 == 0 { random.in_cube() } else { 4.0 * random.direction() };
            let target = 1.1 * random.in_cube();
            let mut direction = (target - origin) * (0.1 + 3.0 * random.unit());
            if i % 7 == 0 {
                // Some components are zero.
                direction[i % 3] = 0.0;
            }
            Ray::new(origin, direction)
        })
        .collect()
}

#[test]
fn hits_agree_with_marching() {
    let mut random = Random::new(7);
    for case in cases() {
        let (mut hits, mut disputed) = (0, 0);
        for ray in rays(&mut random, 1200) {
            let end = 8.0 / ray.direction.length();
            let found = case.shape.intersect(&ray).filter(|h| h.t < end).map(|h| h.t);
            let expected = case.oracle(&ray, end, 800);
            match (found, expected) {
                (Some(a), Some(b)) if (a - b).abs() * ray.direction.length() < 1e-7 => hits += 1,
                (None, None) => {}
                // The oracle misses a chord between two steps, and cannot decide at rims.
                (Some(a), _) if case.sheets.iter().any(|s| (s.value)(ray.at(a)).abs() < 1e-9) => {
                    disputed += 1
                }
                (None, Some(b)) if case.doubtful(&ray, b) => disputed += 1,
                _ => panic!("{}: found {found:?}, expected {expected:?} for {ray:?}", case.name),
            }
        }
        assert!(hits > 25 && disputed < 30, "{}: {hits} hits, {disputed} disputed", case.name);
    }
}

#[test]
fn surface_points_and_normals_are_exact() {
    let mut random = Random::new(8);
    for case in cases() {
        let bounds = case.shape.bounds();
        for ray in rays(&mut random, 1500) {
            let Some(hit) = case.shape.intersect(&ray) else { continue };
            let s = case.shape.surface(&ray, &hit);
            assert!((s.ng.length() - 1.0).abs() < 1e-14 && s.ns == s.ng);
            let off = case.sheets.iter().map(|x| (x.value)(s.p).abs()).fold(f64::INFINITY, f64::min);
            assert!(off <= s.error, "{}: {off} from the surface, bound {}", case.name, s.error);
            let away = s.p.distance(ray.at(hit.t));
            assert!(away < 1e-7 * (1.0 + s.p.length()), "{}: moved by {away}, {ray:?}", case.name);
            let uv = case.shape.uv(&hit, &s);
            if let Some(b) = bounds {
                let (low, high) = (b.min - s.error, b.max + s.error);
                assert!(s.p.cmpge(low).all() && s.p.cmple(high).all(), "{}", case.name);
                assert!(uv.min_element() >= 0.0 && uv.max_element() <= 1.0, "{}: {uv}", case.name);
            }
            assert!(uv.is_finite());
            let g = case.gradient(s.p);
            // At edges the gradient is that of two faces.
            if (g.length() - 1.0).abs() < 1e-6 && g.dot(s.ng) < 1.0 - 1e-8 {
                let edge = case.gradient(s.p - 1e-4 * s.ng);
                assert!(edge.dot(s.ng) < 0.99, "{}: normal {} but gradient {g}", case.name, s.ng);
            }
        }
    }
}

#[test]
fn leaving_rays_do_not_hit_again() {
    // From a point on a convex side, offset by the error bound, outwards.
    let mut random = Random::new(9);
    for case in cases() {
        for ray in rays(&mut random, 2000) {
            let Some(hit) = case.shape.intersect(&ray) else { continue };
            let s = case.shape.surface(&ray, &hit);
            let mut d = random.direction();
            if d.dot(s.ng) < 0.0 {
                d = -d;
            }
            let leaving = Ray::new(s.p + s.error * s.ng, d);
            let again = case.shape.intersect(&leaving).map(|h| h.t);
            let concave = matches!(case.shape, Shape::Torus(_) | Shape::Solid(_));
            match again {
                None => {}
                Some(t) if concave => assert!(t > 1e-7, "{}: again at {t} {ray:?}", case.name),
                Some(t) => panic!("{}: again at {t} from {ray:?}", case.name),
            }
        }
    }
}

#[test]
fn ranges_transforms_and_broken_rays() {
    let mut random = Random::new(10);
    let turn = DMat3::from_cols(
        DVec3::new(0.36, 0.48, -0.8),
        DVec3::new(-0.8, 0.6, 0.0),
        DVec3::new(0.48, 0.64, 0.6),
    );
    let place = DAffine3 { matrix3: 2.5 * turn, translation: DVec3::new(1.0, -2.0, 3.0) };
    for case in cases() {
        for ray in rays(&mut random, 300) {
            let Some(hit) = case.shape.intersect(&ray) else { continue };
            let exactly = Ray { t_min: hit.t, t_max: hit.t, ..ray };
            assert!(
                case.shape.intersect(&exactly).is_some() && case.shape.occludes(&exactly),
                "{}",
                case.name
            );
            let short = Ray { t_max: hit.t * (1.0 - 1e-9) - 1e-12, ..ray };
            assert!(case.shape.intersect(&short).is_none() && !case.shape.occludes(&short), "{}", case.name);
            let later = Ray { t_min: hit.t * (1.0 + 1e-9) + 1e-12, ..ray };
            assert!(case.shape.intersect(&later).is_none_or(|h| h.t >= later.t_min));
            let there = ray.transformed(&place);
            let back = case.shape.intersect(&there.transformed(&place.inverse()));
            assert!(back.is_none_or(|h| (h.t - hit.t).abs() < 1e-6), "{}", case.name);
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                for axis in 0..3 {
                    let (mut a, mut b) = (ray, ray);
                    a.origin[axis] = bad;
                    b.direction[axis] = bad;
                    for r in [a, b] {
                        assert!(case.shape.intersect(&r).is_none(), "{}: {r:?}", case.name);
                    }
                }
            }
            for r in [
                Ray { direction: DVec3::ZERO, ..ray },
                Ray { t_min: f64::NAN, ..ray },
                Ray { t_max: f64::NAN, ..ray },
                Ray { t_min: 2.0, t_max: 1.0, ..ray },
            ] {
                assert!(case.shape.intersect(&r).is_none(), "{}: {r:?}", case.name);
            }
        }
    }
}

#[test]
fn from_far_away_shapes_are_still_hit() {
    let mut random = Random::new(11);
    for case in cases() {
        for _ in 0..300 {
            let near = Ray::new(4.0 * random.direction(), DVec3::ZERO);
            let near = Ray { direction: 0.5 * random.in_cube() - near.origin, ..near };
            let (Some(hit), d) = (case.shape.intersect(&near), near.direction.normalize()) else { continue };
            let far = Ray::new(near.origin - 1e7 * d, d);
            if case.doubtful(&near, hit.t) || case.shape.intersect(&Ray { t_max: 1e7, ..far }).is_some() {
                continue;
            }
            let again = case.shape.intersect(&far).expect("a hit from afar").t - 1e7;
            let t = hit.t * near.direction.length();
            assert!((again - t).abs() < 1e-5, "{}: {again} {t}", case.name);
        }
    }
}
