//! Curved shapes under non-uniform transforms: densities against sums over their area.

use std::f64::consts::TAU;

use super::tests::{POINTS, check};
use super::{Curved, CurvedEmitter, EllipsoidEmitter, SphereEmitter};
use crate::math::elementary::sin_cos;
use crate::math::{DAffine3, DMat3, DVec3};
use crate::shape::{ConeDesc, CylinderDesc, TorusDesc};

/// Non-uniform, skewed, and mirrored.
fn transforms() -> [DAffine3; 3] {
    let slanted =
        DMat3::from_cols(DVec3::new(0.6, 0.1, 0.0), DVec3::new(0.2, 0.4, -0.1), DVec3::new(0.0, 0.2, 0.9));
    let moved = |m: DMat3| DAffine3 { matrix3: m, translation: DVec3::new(0.1, 1.0, -0.2) };
    let mirrored = DMat3::from_diagonal(DVec3::new(-0.5, 0.3, 0.8));
    [moved(DMat3::IDENTITY * 0.5), moved(slanted), moved(mirrored)]
}

/// Positions, outward normals and areas of the cells of a surface over the unit square.
fn grid(n: i32, m: &DAffine3, inside: DVec3, at: impl Fn(f64, f64) -> DVec3) -> Vec<(DVec3, DVec3, f64)> {
    let step = 1.0 / f64::from(n);
    let mut out = Vec::new();
    for i in 0..n * n {
        let (u, v) = ((f64::from(i % n) + 0.5) * step, (f64::from(i / n) + 0.5) * step);
        let p = |u: f64, v: f64| m.transform_point3(at(u, v));
        let h = 0.5 * step;
        let across = (p(u + h, v) - p(u - h, v)).cross(p(u, v + h) - p(u, v - h));
        let outwards = (p(u, v) - m.transform_point3(inside)).dot(across).signum();
        if across.length() > 0.0 {
            out.push((p(u, v), outwards * across.normalize(), across.length()));
        }
    }
    out
}

fn ring_point(angle: f64, r: f64, z: f64) -> DVec3 {
    let (s, c) = sin_cos(TAU * angle);
    DVec3::new(r * c, z, r * s)
}

#[test]
fn ellipsoids() {
    let sphere = SphereEmitter { center: DVec3::new(0.2, 0.1, 0.0), radius: 0.8 };
    for m in transforms() {
        let e = EllipsoidEmitter::new(sphere, m).unwrap();
        let cells = grid(500, &m, sphere.center, |u, v| {
            let (s, c) = sin_cos(0.5 * TAU * v);
            sphere.center + ring_point(u, 0.8 * s, 0.8 * c)
        });
        let outside = [POINTS[0], POINTS[2], POINTS[3], POINTS[5]];
        check(&|p, u| e.sample(p, u), &|p, q, n| e.pdf(p, q, n), &outside, &cells, true);
        let within = [m.transform_point3(DVec3::new(0.4, 0.2, 0.1))];
        check(&|p, u| e.sample(p, u), &|p, q, n| e.pdf(p, q, n), &within, &cells, false);
        let area: f64 = cells.iter().map(|c| c.2).sum();
        assert!((e.area() / area - 1.0).abs() < 0.1, "{} and {area}", e.area());
    }
}

#[test]
fn cylinders_cones_and_tori() {
    let cylinder = CylinderDesc { from: DVec3::NEG_Y, to: DVec3::Y, radius: 0.5, capped: false };
    let cone = ConeDesc { from: DVec3::NEG_Y, to: DVec3::Y, radius: 0.9, tip_radius: 0.2, capped: false };
    let torus = TorusDesc { center: DVec3::ZERO, axis: DVec3::Y, radius: 1.0, tube_radius: 0.4 };
    let away = [POINTS[2], POINTS[3], POINTS[5]];
    for m in transforms() {
        let cells = grid(400, &m, DVec3::ZERO, |u, v| ring_point(u, 0.5, 2.0 * v - 1.0));
        curved(Curved::Cylinder(cylinder.prepare().unwrap()), m, &away, &cells);
        let cells = grid(400, &m, DVec3::ZERO, |u, v| ring_point(u, 0.9 - 0.7 * v, 2.0 * v - 1.0));
        curved(Curved::Cone(cone.prepare().unwrap()), m, &away, &cells);
        let cells = grid(400, &m, DVec3::ZERO, |u, v| {
            let (s, c) = sin_cos(TAU * v);
            ring_point(u, 1.0 + 0.4 * c, 0.4 * s)
        });
        curved(Curved::Torus(torus.prepare().unwrap()), m, &away, &cells);
    }
}

#[test]
fn caps_are_included() {
    let m = transforms()[1];
    let disk = |r: f64, y: f64| grid(400, &m, DVec3::ZERO, move |u, v| ring_point(u, r * v, y));
    let mut cells = grid(400, &m, DVec3::ZERO, |u, v| ring_point(u, 0.5, 2.0 * v - 1.0));
    cells.extend(disk(0.5, -1.0));
    cells.extend(disk(0.5, 1.0));
    let cylinder = CylinderDesc { from: DVec3::NEG_Y, to: DVec3::Y, radius: 0.5, capped: true };
    let away = [POINTS[2], POINTS[3], POINTS[5]];
    curved(Curved::Cylinder(cylinder.prepare().unwrap()), m, &away, &cells);
    let mut cells = grid(400, &m, DVec3::ZERO, |u, v| ring_point(u, 0.2 + 0.7 * v, 2.0 * v - 1.0));
    cells.extend(disk(0.2, -1.0));
    cells.extend(disk(0.9, 1.0));
    let cone = ConeDesc { from: DVec3::NEG_Y, to: DVec3::Y, radius: 0.2, tip_radius: 0.9, capped: true };
    curved(Curved::Cone(cone.prepare().unwrap()), m, &away, &cells);
}

#[track_caller]
fn curved(shape: Curved, m: DAffine3, points: &[DVec3], cells: &[(DVec3, DVec3, f64)]) {
    let e = CurvedEmitter::new(shape, m).unwrap();
    check(&|p, u| Some(e.sample(p, u)?.0), &|p, q, n| e.pdf(p, q, n), points, cells, false);
    let area: f64 = cells.iter().map(|c| c.2).sum();
    assert!((e.area() / area - 1.0).abs() < 0.05, "{} and {area}", e.area());
}

#[test]
fn singular_transforms_are_refused() {
    let flat = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)));
    let sphere = SphereEmitter { center: DVec3::ZERO, radius: 1.0 };
    assert!(EllipsoidEmitter::new(sphere, flat).is_none());
    let torus = TorusDesc { center: DVec3::ZERO, axis: DVec3::Y, radius: 1.0, tube_radius: 1.0 };
    let torus = Curved::Torus(torus.prepare().unwrap());
    assert!(CurvedEmitter::new(torus, flat).is_none());
    // A tube as thick as its ring: the inner side is a point.
    let e = CurvedEmitter::new(torus, DAffine3::IDENTITY).unwrap();
    for u in [0.0, 0.5, 0.9999999] {
        assert!(e.sample(DVec3::new(3.0, 1.0, 0.0), [u, 0.3]).is_none_or(|(s, _)| s.q.is_finite()));
    }
}
