//! Solids as cases of the tests that all shapes share.

use super::*;
use crate::shape::testing::{Case, sheet, solid};
use crate::shape::{BoxDesc, MeshCache, PlaneDesc, ShapeDesc, SphereDesc};

pub(in crate::shape) fn prepare(desc: ShapeDesc) -> crate::shape::Shape {
    desc.prepare(&mut MeshCache::new(&[])).unwrap()
}

/// A part without material.
pub(in crate::shape) fn part(shape: ShapeDesc) -> CsgPart {
    CsgPart { shape, ..CsgPart::default() }
}

pub(in crate::shape) fn sphere(center: DVec3, radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere(SphereDesc { center, radius })
}

pub(in crate::shape) fn cuboid(min: DVec3, max: DVec3) -> ShapeDesc {
    ShapeDesc::Box(BoxDesc { min: Some(min), max: Some(max), center: None, size: None })
}

fn csg() -> Vec<Case> {
    let (a, b) = (DVec3::new(0.3, -0.2, 0.1), DVec3::new(-0.2, 0.3, 0.3));
    let (low, high) = (DVec3::new(-0.7, -0.6, -0.5), DVec3::new(0.5, 0.6, 0.7));
    let ball = move |p: DVec3| p.distance(a) - 0.8;
    let other = move |p: DVec3| p.distance(b) - 0.6;
    let block = move |p: DVec3| (low - p).max(p - high).max_element();
    let parts = || vec![part(cuboid(low, high)), part(sphere(a, 0.8)), part(sphere(b, 0.6))];
    let n = DVec3::new(1.0, 2.0, -1.0);
    let half = ShapeDesc::Plane(PlaneDesc { point: a, normal: n });
    vec![
        Case {
            name: "union",
            shape: prepare(ShapeDesc::Union(UnionDesc { parts: parts() })),
            sheets: solid(move |p| block(p).min(ball(p)).min(other(p))),
        },
        Case {
            name: "intersection",
            shape: prepare(ShapeDesc::Intersection(IntersectionDesc { parts: parts() })),
            sheets: solid(move |p| block(p).max(ball(p)).max(other(p))),
        },
        Case {
            name: "difference",
            shape: prepare(ShapeDesc::Difference(DifferenceDesc { parts: parts() })),
            sheets: solid(move |p| block(p).max(-ball(p)).max(-other(p))),
        },
        Case {
            name: "clipped",
            shape: prepare(ShapeDesc::Clipped(ClippedDesc { parts: vec![part(sphere(a, 0.8)), part(half)] })),
            sheets: sheet(ball, move |p| (p - a).dot(n) < 0.0),
        },
    ]
}

pub(in crate::shape) fn cases() -> Vec<Case> {
    csg()
}
