//! Constructive solid geometry in pictures: as the boundary of media, as glass, and with the classic integrator.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use crate::description::SceneDesc;
use crate::integrator::{ClassicDesc, IntegratorDesc, PathDesc};
use crate::light::LightDesc;
use crate::material::{ClassicMaterial, DielectricMaterial, MaterialDesc};
use crate::math::DVec3;
use crate::medium::HomogeneousMedium;
use crate::shape::ShapeDesc;
use crate::shape::solid::{CsgPart, DifferenceDesc, IntersectionDesc, UnionDesc};
use crate::testing::scenes::{called, cuboid, even, lamp, mean, path, render, scene, sphere, v};

fn parts(shapes: impl IntoIterator<Item = ShapeDesc>) -> Vec<CsgPart> {
    shapes.into_iter().map(|shape| CsgPart { shape, ..CsgPart::default() }).collect()
}

fn cube() -> ShapeDesc {
    cuboid(v(-1.0, -1.0, -1.0), v(1.0, 1.0, 1.0))
}

/// A camera that looks along −z through the origin, before a background of 1.
fn through(depth: u32) -> SceneDesc {
    path(PathDesc { max_depth: depth, ..PathDesc::default() }).seen_from_front(10.0, 0.001).before(1.0)
}

#[test]
fn media_fill_what_solids_enclose() {
    let chord = |shape: ShapeDesc, length: f64| {
        let fog = HomogeneousMedium { absorption: even(0.7), ..HomogeneousMedium::default() };
        mean(2, through(8).filled(shape, fog)).is_grey((-0.7 * length).exp(), 1e-5);
    };
    let hole = || sphere(DVec3::ZERO, 0.5);
    chord(ShapeDesc::Difference(DifferenceDesc { parts: parts([cube(), hole()]) }), 1.0);
    // Two spheres of radius 1 whose centres are 1 apart along the ray.
    let two = || parts([sphere(v(0.0, 0.0, -0.5), 1.0), sphere(v(0.0, 0.0, 0.5), 1.0)]);
    chord(ShapeDesc::Union(UnionDesc { parts: two() }), 3.0);
    chord(ShapeDesc::Intersection(IntersectionDesc { parts: two() }), 1.0);
}

/// Four boxes side by side are one block of glass: two faces reflect light, not eight.
#[test]
fn glass_has_no_inner_walls() {
    let slices = (0..4).map(|i| {
        let z = -1.0 + 0.5 * f64::from(i);
        cuboid(v(-1.0, -1.0, z), v(1.0, 1.0, z + 0.5))
    });
    // With two bounces a ray gets through two faces, but not through eight.
    let glass = DielectricMaterial { ior: 1.5, ..DielectricMaterial::default() };
    let block = ShapeDesc::Union(UnionDesc { parts: parts(slices) });
    let seen = |shape: ShapeDesc| mean(64, through(2).with(shape, glass.clone())).value()[1];
    let (union, whole) = (seen(block), seen(cube()));
    assert!((union - whole).abs() < 1e-6 && union > 0.9, "{union} {whole}");
}

#[test]
fn classic_pictures_of_a_union_of_one_are_those_of_the_part() {
    let of = |shape: ShapeDesc| {
        let paint = ClassicMaterial {
            color: called("tomato"),
            ks: 0.5,
            k_reflect: 0.3,
            ..ClassicMaterial::default()
        };
        let desc = scene(IntegratorDesc::Classic(ClassicDesc::default()))
            .seen_from_front(4.0, 40.0)
            .before(0.2)
            .with(shape, MaterialDesc::Classic(paint));
        let light: LightDesc = lamp(v(3.0, 4.0, 5.0), 30.0);
        render(&desc.lit(light).filmed([48, 48], 1)).0
    };
    for shape in [sphere(DVec3::ZERO, 1.0), cube()] {
        let union = ShapeDesc::Union(UnionDesc { parts: parts([shape.clone()]) });
        let (a, b) = (of(shape), of(union));
        let differs = |(p, q): (&[f32; 4], &[f32; 4])| p.iter().zip(q).any(|(p, q)| (p - q).abs() > 1e-5);
        assert!(!a.linear.iter().zip(&b.linear).any(differs));
    }
}
