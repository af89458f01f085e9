//! Emissive shapes: sampled directions follow the pdf of their hits.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::camera::PinholeDesc;
use crate::description::{ObjectContent, ObjectDesc, SceneDesc};
use crate::integrator::{LightSampling, PathDesc};
use crate::material::PrincipledMaterial;
use crate::math::{DAffine3, DVec2, DVec3, Ray};
use crate::scene::Scene;
use crate::schema::transform::rotation;
use crate::schema::{Asset, MeshData, MeshId, Transform};
use crate::shape::solid::*;
use crate::shape::{
    ConeDesc, CylinderDesc, DiskDesc, MeshDesc, ParametricDesc, PlaneDesc, PointsDesc, Shape, ShapeDesc,
    ShapeHit, TextAlign, TextDesc, TorusDesc, text_testing,
};
use crate::testing::scenes::{
    Mean, cuboid, emissive, grey, matte, mean, path, plane, rectangle, rgb, sphere, v,
};
use crate::texture::{CheckerboardDesc, TextureDesc};

fn lamp() -> PrincipledMaterial {
    emissive(2.0, rgb([1.0, 0.5, 0.25]))
}

/// With a transform that scales non-uniformly.
fn slanted(shape: ShapeDesc) -> ObjectDesc {
    let turn = rotation(DVec3::Z, 40.0) * rotation(DVec3::Y, 30.0) * rotation(DVec3::X, 20.0);
    let placed = DAffine3::from_translation(v(0.2, 0.1, 0.0)) * DAffine3::from_mat3(turn);
    let transform = Transform(placed * DAffine3::from_scale(v(1.6, 0.5, 0.8)));
    ObjectDesc { transform, ..ObjectDesc::new(shape) }
}

/// The meshes of the shapes that need one: a cloud of points, a tetrahedron.
fn meshes() -> [MeshData; 2] {
    let cloud = vec![[-0.6, 0.0, 0.0], [0.5, 0.3, 0.0], [0.0, -0.4, 0.5]];
    let corners = vec![[-0.6, -0.5, 0.0], [0.7, -0.4, 0.3], [0.0, 0.6, -0.2], [0.1, 0.1, 0.9]];
    let triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    [
        MeshData { positions: cloud, ..MeshData::default() },
        MeshData { positions: corners, triangles, ..MeshData::default() },
    ]
}

/// Every bounded shape with a transform that scales non-uniformly, the basic ones also without. Points and the mesh are of
/// [`meshes`].
fn shapes() -> Vec<ObjectDesc> {
    let (from, to) = (v(0.0, -0.6, 0.1), v(0.2, 0.7, 0.0));
    let mut plain = vec![
        sphere(DVec3::ZERO, 0.8),
        cuboid(v(-0.7, -0.5, -0.4), v(0.6, 0.5, 0.5)),
        rectangle(DVec3::ZERO, v(1.5, 0.0, 0.2), v(0.0, 1.0, 0.3)),
        ShapeDesc::Disk(DiskDesc { radius: 0.9, normal: v(0.3, 1.0, 0.4), ..DiskDesc::default() }),
        ShapeDesc::Cylinder(CylinderDesc { from, to, radius: 0.5, ..CylinderDesc::default() }),
        ShapeDesc::Cylinder(CylinderDesc { radius: 0.5, capped: false, ..CylinderDesc::default() }),
        ShapeDesc::Cone(ConeDesc { from, to, radius: 0.7, ..ConeDesc::default() }),
        ShapeDesc::Cone(ConeDesc { radius: 0.4, tip_radius: 0.7, ..ConeDesc::default() }),
        ShapeDesc::Torus(TorusDesc { axis: v(0.3, 1.0, 0.1), ..torus() }),
        ShapeDesc::Points(PointsDesc { points: MeshId(0), radius: None, radii: vec![0.4, 0.3, 0.2] }),
        ShapeDesc::Mesh(MeshDesc { mesh: MeshId(1), ..MeshDesc::default() }),
        ShapeDesc::Text(TextDesc {
            size: 1.6,
            depth: 0.6,
            align: TextAlign::Center,
            ..text_testing::text("I")
        }),
        ShapeDesc::Parametric(ParametricDesc { tolerance: 0.1, ..ParametricDesc::default() }),
    ];
    plain.extend(solids());
    for entry in
        ShapeDesc::DOC.entries.iter().filter(|e| !matches!(e.name, "plane" | "height_field" | "curves"))
    {
        assert!(plain.iter().any(|s| s.type_name() == entry.name), "no shape of the kind {}", entry.name);
    }
    let basic = plain.len() - solids().len();
    let as_it_is = plain[..basic].iter().cloned().map(ObjectDesc::new);
    as_it_is.chain(plain.iter().cloned().map(slanted)).collect()
}

fn solids() -> Vec<ShapeDesc> {
    let part = |shape: ShapeDesc| CsgPart { shape, ..CsgPart::default() };
    let parts =
        || vec![part(cuboid(v(-0.6, -0.5, -0.5), v(0.5, 0.5, 0.5))), part(sphere(v(0.2, 0.2, 0.2), 0.55))];
    let half = part(ShapeDesc::Plane(PlaneDesc { point: v(0.0, 0.2, 0.0), normal: v(0.2, 1.0, 0.3) }));
    let at = DVec2::new;
    let box_of = |size: f64| (DVec3::splat(-size), DVec3::splat(size));
    let (min, max) = box_of(0.6);
    vec![
        ShapeDesc::Union(UnionDesc { parts: parts() }),
        ShapeDesc::Intersection(IntersectionDesc { parts: parts() }),
        ShapeDesc::Difference(DifferenceDesc { parts: parts() }),
        ShapeDesc::Clipped(ClippedDesc { parts: vec![part(sphere(DVec3::ZERO, 0.8)), half] }),
        ShapeDesc::Prism(PrismDesc {
            points: vec![at(-0.6, -0.5), at(0.5, -0.4), at(0.4, 0.6), at(0.0, 0.0)],
            bottom: -0.3,
            top: 0.4,
            ..PrismDesc::default()
        }),
        ShapeDesc::Lathe(LatheDesc {
            points: vec![at(0.3, -0.5), at(0.6, 0.0), at(0.2, 0.5)],
            spline: LatheSpline::CatmullRom,
        }),
        ShapeDesc::SphereSweep(SphereSweepDesc {
            spheres: vec![[-0.4, 0.0, 0.0, 0.2], [0.3, 0.3, 0.1, 0.35]],
            path: SweepPath::Linear,
        }),
        ShapeDesc::Superellipsoid(SuperellipsoidDesc { east_west: 1.2, north_south: 1.6 }),
        ShapeDesc::Blob(BlobDesc {
            spheres: vec![[-0.3, 0.0, 0.0, 0.7, 1.0], [0.3, 0.2, 0.0, 0.6, 1.0]],
            ..BlobDesc::default()
        }),
        ShapeDesc::Quadric(QuadricDesc { squared: v(3.0, 2.0, 4.0), ..QuadricDesc::default() }),
        ShapeDesc::Polynomial(PolynomialDesc {
            terms: vec![
                [1.0, 2.0, 0.0, 0.0],
                [1.0, 0.0, 4.0, 0.0],
                [1.0, 0.0, 0.0, 2.0],
                [-0.2, 0.0, 0.0, 0.0],
            ],
            min,
            max,
            capped: true,
        }),
        ShapeDesc::Isosurface(IsosurfaceDesc {
            function: "x*x + y*y + z*z - 0.3 - 0.1*x*y".to_owned(),
            min,
            max,
            capped: true,
        }),
        ShapeDesc::DistanceGrid(DistanceGridDesc { level: 0.1, ..DistanceGridDesc::default() }),
    ]
}

fn is_solid(shape: &ObjectDesc) -> bool {
    let ObjectContent::Shape(shape) = &shape.content else { return false };
    solids().iter().any(|solid| solid.type_name() == shape.type_name())
}

fn torus() -> TorusDesc {
    TorusDesc { radius: 0.6, tube_radius: 0.3, ..TorusDesc::default() }
}

/// A scene for the shapes.
fn empty(desc: PathDesc) -> SceneDesc {
    let meshes = meshes().map(|data| Asset { uri: String::new(), data: Arc::new(data) });
    SceneDesc { meshes: meshes.into(), ..path(desc) }
}

fn scene(shape: &ObjectDesc) -> Arc<Scene> {
    let desc = empty(PathDesc::default()).with_object(shape.clone(), lamp());
    desc.prepare(&Default::default()).unwrap().scene
}

/// Pseudo-random numbers (PCG).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = ((self.0 >> 22) ^ self.0) >> (22 + (self.0 >> 61));
        f64::from(x as u32) / 4_294_967_296.0
    }
}

/// The sum of the pdfs of all hits of a ray: the pdf of its direction. Spheres are sampled on their front only, solids
/// (`first_only`) at the first hit.
fn density(scene: &Scene, p: DVec3, w: DVec3, fronts: bool, first_only: bool) -> f64 {
    let mut ray = Ray::new(p, w);
    let mut sum = 0.0;
    for _ in 0..12 {
        let Some(hit) = scene.intersect(&ray) else { break };
        let surface = scene.surface(&ray, &hit);
        if !fronts || surface.ng.dot(w) < 0.0 {
            sum += scene.emitters.pdf_hit(scene, p, &surface);
        }
        ray.t_min = hit.shape.t + 1e-7;
        if first_only {
            break;
        }
    }
    sum
}

/// Rows of equal height around the axis to the shape, and columns of equal angle.
const ROWS: usize = 12;
const COLUMNS: usize = 12;
const SAMPLES: u32 = 20_000;

#[test]
fn samples_follow_the_density_and_the_density_covers_the_shape_once() {
    let p = DVec3::new(1.2, 1.6, 2.2);
    let axis = -p.normalize();
    let side = axis.any_orthonormal_vector();
    let up = axis.cross(side);
    // All of each shape is within that angle.
    let least = 0.72;
    for shape in shapes() {
        let scene = scene(&shape);
        let fronts =
            matches!(shape.content, ObjectContent::Shape(ShapeDesc::Sphere(_) | ShapeDesc::Points(_)));
        let first_only = is_solid(&shape);
        let has_triangles = matches!(scene.primitives[0].shape, Shape::Mesh(_));
        let cell = |w: DVec3| {
            let row = ((1.0 - w.dot(axis)) / (1.0 - least) * ROWS as f64) as usize;
            let turn = (w.dot(up).atan2(w.dot(side)) / TAU).rem_euclid(1.0);
            assert!(row < ROWS, "{shape:?}: {w}");
            row * COLUMNS + ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1)
        };
        let mut found = vec![0u32; ROWS * COLUMNS];
        let mut random = Random(7);
        let (mut outside, mut front) = (0u32, 0u32);
        for _ in 0..SAMPLES {
            let u = [random.next(), random.next(), random.next()];
            let Some(s) = scene.emitters.sample(&scene, p, u) else { continue };
            let w = s.to_light.normalize();
            found[cell(w)] += 1;
            // The first hit is the sample, unless another part of the shape occludes it.
            let ray = Ray::new(p, w);
            let Some(hit) = scene.intersect(&ray) else {
                outside += 1;
                continue;
            };
            // The end of a shadow ray lies a little in front of the light: near an edge, behind which another triangle has
            // another density.
            let ShapeHit { u, v, .. } = hit.shape;
            let on_edge = has_triangles && u.min(v).min(1.0 - u - v) < 1e-5;
            if (hit.shape.t - s.to_light.length()).abs() < 1e-6 && !on_edge {
                front += 1;
                let pdf = scene.emitters.pdf_hit(&scene, p, &scene.surface(&ray, &hit));
                // Alias tables hold probabilities in single precision, and silhouettes are steep.
                assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{shape:?}: {pdf} and {}", s.pdf);
            }
            assert!((s.radiance.r - 2.0).abs() < 1e-6 && (s.radiance.b - 0.5).abs() < 1e-6);
        }
        assert!(
            outside < SAMPLES / 500 && front > SAMPLES / if first_only { 16 } else { 4 },
            "{shape:?}: {outside} {front}"
        );
        let (mut chi2, mut cells, mut whole) = (0.0, 0, 0.0);
        let n = if is_solid(&shape) { 32 } else { 64 };
        for (i, &count) in found.iter().enumerate() {
            let (row, column) = ((i / COLUMNS) as f64, (i % COLUMNS) as f64);
            let mut mean = 0.0;
            for k in 0..n * n {
                let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
                let c = 1.0 - (row + at(k % n)) / ROWS as f64 * (1.0 - least);
                let phi = (column + at(k / n)) / COLUMNS as f64 * TAU;
                let s = (1.0 - c * c).sqrt();
                mean += density(
                    &scene,
                    p,
                    c * axis + s * (phi.cos() * side + phi.sin() * up),
                    fronts,
                    first_only,
                );
            }
            let size = TAU * (1.0 - least) / (ROWS * COLUMNS) as f64;
            let share = mean / f64::from(n * n) * size;
            whole += share;
            let expected = share * f64::from(SAMPLES);
            if expected > 8.0 {
                // The quadrature misses edges and silhouettes within a cell; that is no deviation.
                let off = ((f64::from(count) - expected).abs() - 0.02 * expected).max(0.0);
                chi2 += off * off / expected;
                cells += 1;
            }
        }
        // Directions to a solid may miss it.
        let sampled = f64::from(found.iter().sum::<u32>()) / f64::from(SAMPLES);
        let all = if first_only { sampled } else { 1.0 };
        assert!((whole - all).abs() < 0.03, "{shape:?}: {whole} instead of {all}");
        let limit = f64::from(cells) + 5.0 * f64::from(2 * cells).sqrt();
        assert!(cells > 5 && chi2 < limit, "{shape:?}: {chi2} in {cells} cells");
    }
}

/// A directly lit floor below the shapes, seen from near.
fn floor(light_sampling: LightSampling) -> SceneDesc {
    let camera = PinholeDesc {
        position: v(0.0, -1.4, 0.0),
        look_at: v(0.0, -1.5, 0.0),
        up: DVec3::NEG_Z,
        fov: Some(0.001),
        ..PinholeDesc::default()
    };
    let floor = PlaneDesc { point: v(0.0, -1.5, 0.0), ..PlaneDesc::default() };
    empty(PathDesc { max_depth: 1, light_sampling, ..PathDesc::default() })
        .seen(camera)
        .with(ShapeDesc::Plane(floor), matte(grey(0.5)))
}

/// Light sampling and BSDF sampling agree on the light of each shape on a matte floor.
#[test]
fn shapes_light_a_floor_as_much_by_sampling_as_by_chance() {
    for shape in shapes() {
        let lit = |samples, way| mean(samples, floor(way).with_object(shape.clone(), lamp()));
        let chance = lit(1024, LightSampling::Bsdf);
        let (both, sampled) = (lit(64, LightSampling::Both), lit(128, LightSampling::Light));
        both.agrees(&chance, 0.03);
        sampled.agrees(&chance, 0.05);
    }
}

/// A textured emitter is sampled where the texture is bright.
#[test]
fn textured_emission_of_curved_shapes() {
    let cone = ConeDesc { radius: 0.7, ..ConeDesc::default() };
    for shape in [ShapeDesc::Torus(torus()), ShapeDesc::Cone(cone)] {
        let lit = |samples, way| -> Mean {
            let mut desc = floor(way);
            let board = CheckerboardDesc {
                even: rgb([1.0, 0.2, 0.1]),
                odd: grey(0.05),
                density: 4.0,
                ..CheckerboardDesc::default()
            };
            let glow = emissive(3.0, desc.texture(TextureDesc::Checkerboard(board)));
            mean(samples, desc.with_object(slanted(shape.clone()), glow))
        };
        lit(128, LightSampling::Both).agrees(&lit(1024, LightSampling::Bsdf), 0.04);
    }
}

/// Shapes without a transform that have a closed-form form factor.
#[test]
fn a_tube_around_the_point_gives_what_the_formula_says() {
    // Inside a tube without caps, half as high as wide above the floor: the sky seen through its upper end is dark.
    let lit = |samples, light_sampling| {
        let tube = CylinderDesc { from: DVec3::ZERO, to: v(0.0, 2.0, 0.0), radius: 1.5, capped: false };
        let desc = path(PathDesc { max_depth: 1, light_sampling, ..PathDesc::default() })
            .seen_down()
            .with(plane(), matte(grey(0.5)))
            .with(ShapeDesc::Cylinder(tube), emissive(PI, grey(1.0)));
        mean(samples, desc)
    };
    // A disk of radius r at height h has the form factor r² / (r² + h²).
    let factor = 1.0 - 2.25 / (2.25 + 4.0);
    lit(256, LightSampling::Both).is_grey(0.5 * PI * factor, 0.01);
    lit(256, LightSampling::Light).is_grey(0.5 * PI * factor, 0.05);
}
