//! Constructive solid geometry: nesting, transforms, coincident faces, closed forms of volumes.

use super::*;
use crate::math::{DAffine3, DVec3};
use crate::schema::{Asset, MeshData, MeshId, Transform};
use crate::shape::solid::testing::{cuboid, part, prepare, sphere};
use crate::shape::testing::Random;
use crate::shape::{CylinderDesc, DiskDesc, MeshCache, MeshDesc, PlaneDesc, Shape, ShapeDesc};

fn difference(parts: Vec<CsgPart>) -> ShapeDesc {
    ShapeDesc::Difference(DifferenceDesc { parts })
}

fn union(parts: Vec<CsgPart>) -> ShapeDesc {
    ShapeDesc::Union(UnionDesc { parts })
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// All crossings of a ray: t, and whether the ray enters.
fn crossings(shape: &Shape, o: [f64; 3], d: [f64; 3]) -> Vec<(f64, bool)> {
    let mut ray = Ray::new(o.into(), d.into());
    let mut found = Vec::new();
    while let Some(hit) = shape.intersect(&ray) {
        found.push((hit.t, shape.surface(&ray, &hit).ng.dot(ray.direction) < 0.0));
        ray.t_min = hit.t.next_up();
        assert!(found.len() < 100);
    }
    found
}

/// The volume of a solid in the cube from −1.2 to 1.2, by the lengths inside of rays along x.
fn volume(shape: &Shape) -> f64 {
    const RAYS: u32 = 300;
    let at = |i: u32| 2.4 * (f64::from(i) + 0.5) / f64::from(RAYS) - 1.2;
    let mut sum = 0.0;
    for (y, z) in (0..RAYS).flat_map(|i| (0..RAYS).map(move |j| (at(i), at(j)))) {
        for (t, enters) in crossings(shape, [-2.0, y, z], [1.0, 0.0, 0.0]) {
            sum += if enters { -t } else { t };
        }
    }
    sum * 2.4 * 2.4 / f64::from(RAYS * RAYS)
}

#[test]
fn volumes_have_their_closed_forms() {
    let sphere_volume = 4.0 / 3.0 * std::f64::consts::PI * 0.512;
    // Two spheres of radius 0.8 whose centres are 0.6 apart: π (4 r + d) (2 r − d)² / 12.
    let lens = std::f64::consts::PI * 3.8 * 1.0 / 12.0;
    let two = || vec![part(sphere(v(-0.3, 0.0, 0.0), 0.8)), part(sphere(v(0.3, 0.0, 0.0), 0.8))];
    let near = |shape: ShapeDesc, expected: f64| {
        let found = volume(&prepare(shape));
        assert!((found - expected).abs() < 3e-3, "{found} instead of {expected}");
    };
    near(ShapeDesc::Intersection(IntersectionDesc { parts: two() }), lens);
    near(union(two()), 2.0 * sphere_volume - lens);
    near(difference(two()), sphere_volume - lens);
    // A cube with a hole bored through it.
    let bore = CylinderDesc { from: v(0.0, -2.0, 0.0), to: v(0.0, 2.0, 0.0), radius: 0.5, capped: true };
    let cube = || part(cuboid(v(-0.9, -0.9, -0.9), v(0.9, 0.9, 0.9)));
    let bored = difference(vec![cube(), part(ShapeDesc::Cylinder(bore))]);
    near(bored.clone(), 1.8 * 1.8 * 1.8 - std::f64::consts::PI * 0.25 * 1.8);
    // What was taken away twice, from the cube, is what is left of it without the hole.
    near(difference(vec![cube(), part(bored)]), std::f64::consts::PI * 0.25 * 1.8);
}

#[test]
fn coincident_faces_leave_neither_skin_nor_wall() {
    let left = || part(cuboid(v(-1.0, -1.0, -1.0), v(0.1, 1.0, 1.0)));
    let right = || part(cuboid(v(0.1, -1.0, -1.0), v(1.0, 1.0, 1.0)));
    let two = prepare(union(vec![left(), right()]));
    // Oblique rays through the common face: rounding differs at every one of them.
    let mut random = Random::new(5);
    for _ in 0..2000 {
        let (a, b) = (random.in_cube() * 0.9, random.in_cube() * 0.9);
        let from = v(-3.0, a.y, a.z);
        let found = crossings(&two, from.to_array(), (v(3.0, b.y, b.z) - from).to_array());
        assert_eq!(found.len(), 2, "{found:?}");
    }
    // A notch that ends exactly at the top: no skin over it. Its walls and floor stay.
    let block = || part(cuboid(v(-1.0, -1.0, -1.0), v(1.0, 0.7, 1.0)));
    let notch = part(cuboid(v(-0.5, 0.0, -0.5), v(0.5, 0.7, 0.5)));
    let cut = prepare(difference(vec![block(), notch]));
    for _ in 0..2000 {
        let p = random.in_cube() * 0.4;
        let from = v(p.x, 3.0, p.z);
        let found = crossings(&cut, from.to_array(), (v(0.1 * p.z, -2.0, 0.1 * p.x) - from).to_array());
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].0 * 5.0 > 2.9, "the floor, not the top: {found:?}");
    }
    // A shape without itself is nothing.
    let nothing = prepare(difference(vec![block(), block()]));
    for _ in 0..500 {
        let from = 3.0 * random.direction();
        let found = crossings(&nothing, from.to_array(), (random.in_cube() - from).to_array());
        assert!(found.is_empty(), "{found:?}");
    }
}

#[test]
fn planes_are_half_spaces() {
    let plane = |y: f64| part(ShapeDesc::Plane(PlaneDesc { point: v(0.0, y, 0.0), normal: DVec3::Y }));
    let cap = prepare(ShapeDesc::Intersection(IntersectionDesc {
        parts: vec![part(sphere(DVec3::ZERO, 1.0)), plane(0.5)],
    }));
    assert_eq!(crossings(&cap, [0.0, 3.0, 0.0], [0.0, -1.0, 0.0]), [(2.5, true), (4.0, false)]);
    assert_eq!(crossings(&cap, [-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), [(2.0, true), (4.0, false)]);
    // From inside, away from the plane.
    assert_eq!(crossings(&cap, [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]), [(1.0, false)]);
    // A slab is unbounded.
    let slab = prepare(difference(vec![plane(0.5), plane(0.0)]));
    assert_eq!(slab.bounds(), None);
    assert_eq!(crossings(&slab, [7.0, 3.0, 0.0], [0.0, -1.0, 0.0]), [(2.5, true), (3.0, false)]);
    // What is outside the sphere, within a cube.
    let outside = CsgPart { inverse: true, ..part(sphere(DVec3::ZERO, 1.0)) };
    let frame = prepare(ShapeDesc::Intersection(IntersectionDesc {
        parts: vec![part(cuboid(DVec3::NEG_ONE, DVec3::ONE)), outside],
    }));
    let found = crossings(&frame, [-3.0, 0.6, 0.0], [1.0, 0.0, 0.0]);
    let expected = [(2.0, true), (2.2, false), (3.8, true), (4.0, false)];
    assert!(
        found.len() == 4 && found.iter().zip(expected).all(|(a, b)| (a.0 - b.0).abs() < 1e-12 && a.1 == b.1)
    );
}

#[test]
fn transforms_and_nesting() {
    let place = DAffine3::from_translation(v(0.2, 0.0, 0.0)) * DAffine3::from_scale(v(0.5, 1.0, 2.0));
    let ellipsoid = CsgPart { transform: Transform(place), ..part(sphere(DVec3::ZERO, 1.0)) };
    let bitten = difference(vec![ellipsoid, part(sphere(v(0.7, 0.0, 0.0), 0.25))]);
    // Nested under a transform of its own: scaled by 2.
    let twice = Transform(DAffine3::from_scale(DVec3::splat(2.0)));
    let shape = prepare(union(vec![CsgPart { transform: twice, ..part(bitten) }]));
    let found = crossings(&shape, [-9.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert!(
        found.len() == 2 && (found[0].0 - 8.4).abs() < 1e-12 && (found[1].0 - 9.9).abs() < 1e-12,
        "{found:?}"
    );
    let ray = Ray::new(v(9.0, 0.0, 0.0), DVec3::NEG_X);
    let hit = shape.intersect(&ray).unwrap();
    let surface = shape.surface(&ray, &hit);
    assert!((surface.ng - DVec3::X).length() < 1e-12 && (surface.p - v(0.9, 0.0, 0.0)).length() < 1e-12);
    // The bite is concave.
    assert!((shape.curvature(&hit) + 2.0).abs() < 1e-9, "{}", shape.curvature(&hit));
    let b = shape.bounds().unwrap();
    assert!((b.max - v(1.4, 2.0, 4.0)).length() < 1e-9 && (b.min - v(-0.6, -2.0, -4.0)).length() < 1e-9);
}

#[test]
fn meshes_are_parts() {
    // A cube of side 2 whose faces share vertices.
    let positions =
        (0..8u8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0f32 } else { -1.0 })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let data = std::sync::Arc::new(MeshData { positions, triangles, ..MeshData::default() });
    let assets = [Asset { uri: String::new(), data }];
    let mut meshes = MeshCache::new(&assets);
    let mesh = ShapeDesc::Mesh(MeshDesc { mesh: MeshId(0), ..MeshDesc::default() });
    let shape = difference(vec![part(mesh), part(sphere(DVec3::ZERO, 1.2))]).prepare(&mut meshes).unwrap();
    assert!(meshes.warnings().is_empty(), "{:?}", meshes.warnings());
    let as_box = difference(vec![part(cuboid(DVec3::NEG_ONE, DVec3::ONE)), part(sphere(DVec3::ZERO, 1.2))]);
    let as_box = prepare(as_box);
    let mut random = Random::new(4);
    for _ in 0..3000 {
        let o = 3.0 * random.direction();
        let d = 1.2 * random.in_cube() - o;
        let (a, b) = (crossings(&shape, o.into(), d.into()), crossings(&as_box, o.into(), d.into()));
        assert_eq!(a.len(), b.len(), "{o} {d}");
        assert!(a.iter().zip(&b).all(|(a, b)| (a.0 - b.0).abs() < 1e-9 && a.1 == b.1));
    }
}

#[test]
fn parts_that_enclose_nothing_are_refused() {
    let refused = |shape: ShapeDesc| shape.prepare(&mut MeshCache::new(&[])).unwrap_err().message;
    let disk = || part(ShapeDesc::Disk(DiskDesc::default()));
    assert!(refused(union(vec![disk()])).contains("a disk encloses no volume"));
    let open = CylinderDesc { capped: false, ..CylinderDesc::default() };
    assert!(refused(union(vec![part(ShapeDesc::Cylinder(open))])).contains("encloses no volume"));
    assert!(refused(union(Vec::new())).contains("at least one part"));
    let many = (0..300).map(|_| part(sphere(DVec3::ZERO, 1.0))).collect();
    assert!(refused(union(many)).contains("more than 256"));
    let flat = Transform(DAffine3::from_scale(v(1.0, 0.0, 1.0)));
    let flat = CsgPart { transform: flat, ..part(sphere(DVec3::ZERO, 1.0)) };
    assert!(refused(union(vec![flat])).contains("not invertible"));
    // What is clipped may be open.
    let half = part(ShapeDesc::Plane(PlaneDesc { point: DVec3::ZERO, normal: DVec3::X }));
    let clipped = prepare(ShapeDesc::Clipped(ClippedDesc { parts: vec![disk(), half] }));
    let radius = DiskDesc::default().radius;
    let n = DiskDesc::default().normal;
    let down = |x: f64| crossings(&clipped, (v(x * radius, 0.0, 0.0) + 3.0 * n).into(), (-n).into()).len();
    assert_eq!((down(-0.5), down(0.5)), (1, 0));
}

#[test]
fn materials_of_parts() {
    let own = |id: u32, shape: ShapeDesc| CsgPart { material: Some(MaterialId(id)), ..part(shape) };
    let inner = difference(vec![part(sphere(DVec3::ZERO, 1.0)), own(7, sphere(v(1.0, 0.0, 0.0), 0.5))]);
    let shape = prepare(union(vec![own(3, inner), part(sphere(v(-2.0, 0.0, 0.0), 0.5))]));
    let Shape::Solid(solid) = &shape else { panic!() };
    assert_eq!(solid.materials(), [Some(MaterialId(3)), Some(MaterialId(7)), None]);
    let slot = |o: DVec3, d: DVec3| solid.material_slot(&shape.intersect(&Ray::new(o, d)).unwrap());
    assert_eq!(slot(v(0.0, 3.0, 0.0), DVec3::NEG_Y), 0);
    assert_eq!(slot(v(3.0, 0.0, 0.0), DVec3::NEG_X), 1);
    assert_eq!(slot(v(-3.0, 0.0, 0.0), DVec3::X), 2);
    let plain = prepare(union(vec![part(sphere(DVec3::ZERO, 1.0))]));
    let Shape::Solid(plain) = &plain else { panic!() };
    assert!(plain.materials().is_empty());
}
