//! The light tree over many lights: the same light as with one table for all points, and as with BSDF sampling.

use std::sync::Arc;

use super::{Attenuation, LightDesc, PointDesc, Receiver, SphereLightDesc, SpotDesc};
use crate::description::SceneDesc;
use crate::integrator::{LightSampling, PathDesc, Prepared};
use crate::material::{MaterialDesc, MetalMaterial, PrincipledMaterial};
use crate::math::{DVec3, Ray};
use crate::scene::LightChoice;
use crate::schema::{MaterialId, MeshData, PrepareOptions};
use crate::shape::{DiskDesc, PlaneDesc, ShapeDesc};
use crate::testing::scenes::{cuboid, emissive, grey, matte, path, plane, rectangle, rgb, sphere, v};
use crate::testing::{CompareOptions, Random, Runs, compare, render_runs};
use crate::texture::{CheckerboardDesc, TextureDesc};

fn by(light_sampling: LightSampling) -> PathDesc {
    PathDesc { max_depth: 2, light_sampling, ..PathDesc::default() }
}

/// A position for a light in the hall.
fn position(random: &mut Random) -> DVec3 {
    v(12.0, 2.0, 8.0) * random.in_cube() + v(0.0, 3.5, 0.0)
}

/// The hall without lights: a floor, a wall, a ball and a leaf.
fn empty_hall(desc: PathDesc) -> SceneDesc {
    let gloss = PrincipledMaterial {
        base_color: rgb([0.9, 0.6, 0.2]),
        base_metalness: grey(1.0),
        specular_roughness: grey(0.4),
        ..PrincipledMaterial::default()
    };
    let leaf = PrincipledMaterial {
        base_color: grey(0.7),
        subsurface_weight: grey(0.6),
        thin_walled: true,
        specular_weight: grey(0.0),
        ..PrincipledMaterial::default()
    };
    let wall = PlaneDesc { point: v(0.0, 0.0, -6.0), normal: DVec3::Z };
    path(desc)
        .filmed([8, 8], 64)
        .seen_at(v(0.0, 3.0, 9.0), v(0.0, 0.5, 0.0), 60.0)
        .with(plane(), matte(grey(0.6)))
        .with(ShapeDesc::Plane(wall), matte(grey(0.6)))
        .with(sphere(v(1.5, 1.0, 0.0), 1.0), gloss)
        .with(rectangle(v(-2.0, 1.0, 0.0), v(2.0, 0.0, 0.5), v(0.0, 2.0, 0.0)), leaf)
}

/// Emissive materials: on both sides, on the front only, and textured.
fn emissive_materials(desc: &mut SceneDesc) -> [MaterialId; 3] {
    let front = PrincipledMaterial { double_sided: false, ..emissive(4.0, grey(1.0)) };
    let board = CheckerboardDesc {
        even: rgb([1.0, 0.2, 0.1]),
        odd: grey(0.05),
        density: 9.0,
        ..CheckerboardDesc::default()
    };
    let board = desc.texture(TextureDesc::Checkerboard(board));
    [emissive(3.0, rgb([1.0, 0.8, 0.5])), front, emissive(3.0, board)]
        .map(|m| desc.material(MaterialDesc::Principled(m)))
}

/// The i-th emissive shape, cycling through the types.
fn shape(desc: &mut SceneDesc, random: &mut Random, i: u32) -> ShapeDesc {
    let p = position(random);
    let (a, b) = (0.3 * random.direction(), 0.3 * random.direction());
    let corners = |all: &[DVec3]| all.iter().map(|p| p.as_vec3().to_array()).collect();
    match i % 5 {
        0 => sphere(p, 0.15),
        1 => rectangle(p, a, b),
        2 => ShapeDesc::Disk(DiskDesc { center: p, normal: a, radius: 0.2, ..DiskDesc::default() }),
        3 => desc.mesh(MeshData {
            positions: corners(&[p, p + a, p + b, p - b]),
            triangles: vec![[0, 1, 2], [0, 3, 1]],
            ..MeshData::default()
        }),
        _ => desc.points(corners(&[p, p + a]), vec![0.1, 0.05]),
    }
}

/// The i-th light, cycling through the types.
fn light(random: &mut Random, i: u32) -> LightDesc {
    let at = position(random);
    let attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };
    match i % 4 {
        0 => {
            LightDesc::Point(PointDesc { position: at, intensity: 0.05, attenuation, ..PointDesc::default() })
        }
        1 => LightDesc::Spot(SpotDesc {
            position: at,
            look_at: 3.0 * random.in_cube(),
            angle: 50.0,
            penumbra: 20.0,
            intensity: 0.2,
            attenuation,
            ..SpotDesc::default()
        }),
        2 => LightDesc::Sphere(SphereLightDesc {
            center: at,
            radius: 0.2,
            intensity: 0.05,
            samples: 1,
            attenuation,
            ..SphereLightDesc::default()
        }),
        // Some do not fall off with distance and stay outside the tree.
        _ => LightDesc::Point(PointDesc { position: at, intensity: 0.0005, ..PointDesc::default() }),
    }
}

/// Emissive shapes of all types in a hall with a floor, a wall and some balls, and additional lights.
fn hall(shapes: u32, lights: u32, desc: PathDesc) -> SceneDesc {
    let mut random = Random::new(11);
    let mut desc = empty_hall(desc);
    let materials = emissive_materials(&mut desc);
    for i in 0..shapes {
        let shape = shape(&mut desc, &mut random, i);
        desc = desc.with_shared(shape, materials[(i / 5 % 3) as usize]);
    }
    (0..lights).fold(desc, |desc, i| desc.lit(light(&mut random, i)))
}

/// The hall with the default light sampling.
fn usual(shapes: u32, lights: u32) -> SceneDesc {
    hall(shapes, lights, by(LightSampling::Both))
}

fn prepare(desc: &SceneDesc, how: LightChoice) -> Prepared {
    let mut scene = desc.prepare(&PrepareOptions::default()).unwrap();
    Arc::make_mut(&mut scene.scene).choose_lights(how);
    scene
}

fn runs(desc: &SceneDesc, how: LightChoice, samples: u32) -> Runs {
    let mut scene = prepare(desc, how);
    scene.view.film.samples = samples;
    let runs = render_runs(&scene, 8, 5, 2).unwrap();
    assert_eq!(runs.non_finite.count, 0);
    runs
}

#[track_caller]
fn agree(a: &Runs, b: &Runs, cap: f64) {
    let options = CompareOptions { tolerance: 4e-6, absolute: 1e-9, ..CompareOptions::default() };
    let found = compare(a, b, &options);
    assert!(found.ratio_error <= cap, "too noisy: {found:?}");
    assert!(found.p_value > 1e-5, "{found:?}");
}

#[test]
fn the_tree_agrees_with_the_table() {
    let desc = usual(600, 400);
    assert!(prepare(&desc, LightChoice::Auto).scene.emitters.tree_bytes() > 0);
    assert_eq!(prepare(&desc, LightChoice::Table).scene.emitters.tree_bytes(), 0);
    let tree = runs(&desc, LightChoice::Auto, 64);
    agree(&tree, &runs(&desc, LightChoice::Table, 512), 0.03);
}

#[test]
fn tree_sampling_agrees_with_bsdf_sampling() {
    let lit = |sampling, samples| runs(&hall(200, 0, by(sampling)), LightChoice::Auto, samples);
    let bsdf = lit(LightSampling::Bsdf, 1024);
    agree(&lit(LightSampling::Both, 64), &bsdf, 0.03);
    agree(&lit(LightSampling::Light, 128), &bsdf, 0.04);
}

#[test]
fn two_lights_are_in_the_tree_and_one_in_the_table() {
    let two = usual(2, 0);
    let (auto, tree) = (runs(&two, LightChoice::Auto, 4), runs(&two, LightChoice::Tree, 4));
    assert!(auto.pictures == tree.pictures);
    let one = usual(1, 0);
    let (auto, table) = (runs(&one, LightChoice::Auto, 4), runs(&one, LightChoice::Table, 4));
    assert!(auto.pictures == table.pictures);
    let some = usual(20, 5);
    agree(&runs(&some, LightChoice::Tree, 128), &runs(&some, LightChoice::Table, 128), 0.03);
}

/// Rough metal under small lights: with the tree, which knows the lobe, the light equals the table's and has less
/// noise.
#[test]
fn glossy_surfaces_choose_lights_by_their_lobe() {
    let metal = MetalMaterial { color: Some(grey(0.9)), roughness: grey(0.3), ..MetalMaterial::default() };
    let mut desc = path(PathDesc { max_depth: 3, ..by(LightSampling::Light) })
        .filmed([24, 16], 16)
        .seen_at(v(0.0, 3.0, 4.0), v(0.0, 0.0, -1.0), 40.0)
        .with(rectangle(DVec3::ZERO, v(8.0, 0.0, 0.0), v(0.0, 0.0, -8.0)), metal.principled());
    for x in [-2.5, -0.8, 0.9, 2.6] {
        desc = desc.with(sphere(v(x, 3.0, -6.0), 0.15), emissive(30.0, grey(1.0)));
    }
    let (tree, table) = (runs(&desc, LightChoice::Auto, 64), runs(&desc, LightChoice::Table, 64));
    agree(&tree, &table, 0.02);
    // Estimated error of the mean over the picture.
    let error = |runs: &Runs| (0..3).map(|band| runs.mean(band).error()).sum::<f64>();
    assert!(error(&tree) < 0.8 * error(&table), "{} {}", error(&tree), error(&table));
}

/// The pdf of a hit equals the pdf of the sample, including triangles, points and sides of boxes.
#[test]
fn pdf_of_hits_equals_pdf_of_samples() {
    let desc =
        usual(300, 0).with(cuboid(v(-3.0, 2.0, 1.0), v(-2.6, 2.2, 1.5)), emissive(3.0, rgb([1.0, 0.8, 0.5])));
    let scene = prepare(&desc, LightChoice::Auto).scene;
    let mut random = Random::new(3);
    let mut seen = 0;
    for _ in 0..20_000 {
        let p = v(6.0, 3.0, 6.0) * random.in_cube() + v(0.0, 3.0, 0.0);
        let at =
            if random.unit() < 0.5 { Receiver::from(p) } else { Receiver::facing(p, random.direction()) };
        let Some(s) = scene.emitters.sample(&scene, at, random.units()) else { continue };
        let ray = Ray::new(p, s.to_light.normalize());
        let Some(hit) = scene.intersect(&ray) else { continue };
        if (hit.shape.t - s.to_light.length()).abs() > 1e-6 {
            continue;
        }
        seen += 1;
        let pdf = scene.emitters.pdf_hit(&scene, at, &scene.surface(&ray, &hit));
        assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{pdf} and {}", s.pdf);
    }
    assert!(seen > 2000, "{seen}");
}
