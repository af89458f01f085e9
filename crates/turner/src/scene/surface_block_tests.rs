use std::sync::Arc;

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{LANES, Work, dispatch};

use super::*;
use crate::description::{ObjectDesc, SceneDesc};
use crate::integrator::IntegratorDesc;
use crate::integrator::path::PathDesc;
use crate::material::Material;
use crate::material::vertex::prepare;
use crate::math::{DAffine3, DMat3, Ray};
use crate::schema::{Asset, MeshData, MeshId, PrepareOptions, Transform};
use crate::shape::{BoxDesc, DiskDesc, MeshDesc, PlaneDesc, RectangleDesc, ShapeDesc, SphereDesc};
use crate::testing::Random;

struct Compute<'a>(&'a mut SurfaceBlock);

impl Work for Compute<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.0.compute(simd);
    }
}

/// Triangles with vertex normals on either side, some of them 0, opposite or far from the geometric normal; the same
/// mesh once more for each of `placed`.
fn triangles(random: &mut Random, smooth: bool, placed: &[DAffine3]) -> SceneDesc {
    let mut data = MeshData::default();
    for i in 0..60u32 {
        let corner = |random: &mut Random| {
            let [x, y, z, _] = random.units::<4>();
            [4.0 * x - 2.0, 4.0 * y - 2.0, 4.0 * z - 2.0].map(|v| v as f32)
        };
        for _ in 0..3 {
            let p = corner(random);
            data.positions.push(p);
            let [x, y, z] = corner(random);
            let normal = match i % 5 {
                0 => [0.0; 3],
                1 => [x, y, z],
                2 => [0.0, 0.0, 1.0],
                _ => [0.3 * x, 0.3 * y, -1.0],
            };
            data.normals.push(normal);
        }
        data.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let mut desc =
        SceneDesc { integrator: IntegratorDesc::Path(PathDesc::default()), ..SceneDesc::default() };
    desc.meshes.push(Asset { uri: String::new(), data: Arc::new(data) });
    let shown = MeshDesc { mesh: MeshId(0), smooth: Some(smooth), ..MeshDesc::default() };
    let object = ObjectDesc::new(ShapeDesc::Mesh(shown));
    desc.objects
        .extend(placed.iter().map(|placed| ObjectDesc { transform: Transform(*placed), ..object.clone() }));
    desc.objects.push(object);
    desc
}

/// Shapes other than meshes, with and without a transform.
#[test]
fn other_shapes_equal_scalar_surfaces() {
    let mut random = Random::new(9);
    let mut desc =
        SceneDesc { integrator: IntegratorDesc::Path(PathDesc::default()), ..SceneDesc::default() };
    let shapes = [
        ShapeDesc::Sphere(SphereDesc::default()),
        ShapeDesc::Rectangle(RectangleDesc::default()),
        ShapeDesc::Disk(DiskDesc::default()),
        ShapeDesc::Plane(PlaneDesc { point: DVec3::new(0.0, -1.5, 0.0), ..PlaneDesc::default() }),
        ShapeDesc::Box(BoxDesc::default()),
    ];
    for (i, shape) in shapes.iter().enumerate() {
        let turn = DMat3::from_rotation_x(0.7 + i as f64);
        let shift = DVec3::new(1.3 * i as f64 - 2.0, 0.4, -0.3 * i as f64);
        let placed = DAffine3 { matrix3: 0.8 * turn, translation: shift };
        for transform in [DAffine3::IDENTITY, placed] {
            desc.objects
                .push(ObjectDesc { transform: Transform(transform), ..ObjectDesc::new(shape.clone()) });
        }
    }
    let scene = desc.prepare(&PrepareOptions::default()).unwrap().scene;
    let mut taken = vec![0; scene.primitives.len()];
    let mut block = SurfaceBlock::default();
    for _ in 0..20_000 {
        let [a, b, c, d] = random.units::<4>();
        let [e, f, ..] = random.units::<4>();
        let from = DVec3::new(8.0 * a - 4.0, 8.0 * b - 4.0, 8.0 * c - 4.0);
        let ray =
            Ray::new(from, (DVec3::new(4.0 * d - 2.0, 3.0 * e - 1.5, 3.0 * f - 1.5) - from).normalize());
        let Some(hit) = scene.intersect(&ray) else { continue };
        let surface = scene.surface(&ray, &hit);
        if !block.take(&scene, 3, &hit, &ray, true) {
            continue;
        }
        taken[hit.primitive as usize] += 1;
        for set in InstructionSet::available() {
            dispatch(set, Compute(&mut block));
            let own = (block.point(3), block.normal(3), block.shading_normal(3), block.mapped_normal(3));
            assert_eq!(own, (surface.p, surface.ng, surface.ns, surface.ns));
            assert_eq!((block.error.0[3], block.direction(3)), (surface.error, ray.direction));
        }
    }
    // Some are hidden, and a turned box is computed in its own space.
    assert!(taken.iter().filter(|n| **n > 20).count() >= 8, "{taken:?}");
}

#[test]
fn triangles_in_lanes_equal_scalar_surfaces() {
    let mut random = Random::new(8);
    let (mut smooth_hits, mut bent) = (0, 0);
    // Alone, and merged with a mirrored and a sheared copy into one mesh.
    let turned = DMat3::from_rotation_x(0.7) * DMat3::from_diagonal(DVec3::new(-1.0, 0.6, 1.3));
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.8, 1.0, 0.0), DVec3::new(-0.3, 0.2, 0.7));
    let copies = [turned, sheared].map(|m| DAffine3 { matrix3: m, translation: DVec3::new(0.4, -0.2, 0.3) });
    for (smooth, placed) in [(false, &[][..]), (true, &[]), (false, &copies), (true, &copies)] {
        let scene = triangles(&mut random, smooth, placed).prepare(&PrepareOptions::default()).unwrap().scene;
        let mut block = SurfaceBlock::default();
        for _ in 0..400 {
            let mut surfaces = Vec::new();
            while surfaces.len() < LANES {
                let [a, b, c, d] = random.units::<4>();
                let [e, f, ..] = random.units::<4>();
                let from = DVec3::new(8.0 * a - 4.0, 8.0 * b - 4.0, 8.0 * c - 4.0);
                let to = DVec3::new(3.0 * d - 1.5, 3.0 * e - 1.5, 3.0 * f - 1.5);
                let ray = Ray::new(from, (to - from).normalize());
                let Some(hit) = scene.intersect(&ray) else { continue };
                let lane = surfaces.len();
                let surface = scene.surface(&ray, &hit);
                // Every third lane is stored as it is.
                if lane % 3 == 2 {
                    block.set(lane, &surface, surface.ns, ray.direction);
                } else {
                    assert_eq!(block.take(&scene, lane, &hit, &ray, true), !smooth);
                    assert!(block.take(&scene, lane, &hit, &ray, false));
                }
                surfaces.push((ray, surface));
            }
            for set in InstructionSet::available() {
                dispatch(set, Compute(&mut block));
                for (lane, (ray, surface)) in surfaces.iter().enumerate() {
                    let own = (block.point(lane), block.normal(lane), block.shading_normal(lane));
                    assert_eq!(own, (surface.p, surface.ng, surface.ns));
                    assert_eq!(block.error.0[lane], surface.error);
                    let Material::OpenPbr(material) = scene.material_at(&surface.hit) else { panic!() };
                    let outside = ray.direction.dot(surface.ng) < 0.0;
                    let bsdf = material.constant_bsdf(outside).unwrap();
                    let vertex = prepare(&*scene, ray, material, surface, bsdf, outside);
                    let frame = block.frame.each_ref().map(|axis| vector(axis, lane));
                    assert_eq!(frame, [vertex.frame.x, vertex.frame.y, vertex.frame.z]);
                    smooth_hits += usize::from(surface.ns != surface.ng);
                    bent += usize::from(vertex.frame.z.abs() != surface.ns.abs());
                }
            }
        }
    }
    assert!(smooth_hits > 1000 && bent > 100, "{smooth_hits} {bent}");
}
