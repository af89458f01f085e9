//! Meshes in scenes: alpha-tested cut-outs, materials and colours of parts, batches of rays.

use std::sync::atomic::AtomicBool;

use turner::integrator::Prepared;
use turner::math::{DVec3, Ray};
use turner::render::{PassOptions, Renderer};
use turner::schema::{PrepareOptions, Quality};
use turner_io::assets::MemoryAssets;
use turner_io::mesh::decode;
use turner_io::scene::{LoadOptions, load_text};

fn scene_with(text: &str, files: &[(&str, &[u8])], quality: Quality) -> Prepared {
    let mut assets = MemoryAssets::default();
    for (name, bytes) in files {
        assets.files.insert((*name).to_owned(), bytes.to_vec());
    }
    let loaded = load_text(text.to_owned(), "test.toml", &assets, &LoadOptions::default());
    let desc = loaded.unwrap_or_else(|e| panic!("{e}\n{text}")).desc;
    desc.prepare(&PrepareOptions { threads: 1, quality, ..Default::default() }).unwrap()
}

fn scene(text: &str) -> Prepared {
    scene_with(text, &[], Quality::Balanced)
}

fn picture(scene: &Prepared) -> Vec<[f32; 4]> {
    let mut renderer = Renderer::new(scene.clone()).unwrap();
    let cancel = AtomicBool::new(false);
    while !renderer.is_complete() {
        assert!(
            renderer.pass(u32::MAX, &PassOptions { threads: 2, cancel: &cancel, progress: None }).unwrap()
        );
    }
    renderer.film.develop(&scene.view.film, 1).linear
}

const VIEW: &str = r#"
[camera]
position = [0.3, 3, 6]
look_at = [0.1, 0, 0]
fov = 40
[film]
width = 160
height = 120
[[light]]
type = "point"
position = [1, 5, 2]
[[light]]
type = "ambient"
color = 0.2
[[object]]
type = "plane"
point = [0, -1.2, 0]
material = { k_reflect = 0.5 }
"#;

/// A square in the plane y = 0 from (x, z), as a mesh with (u, v).
fn square(x: f64, z: f64, side: f64, material: &str) -> String {
    let (r, n) = (x + side, z + side);
    format!(
        "[[object]]\ntype = \"mesh\"\npositions = [[{x}, 0, {z}], [{x}, 0, {n}], [{r}, 0, {n}], [{r}, 0, {z}]]\n\
         uvs = [[0, 0], [0, 1], [1, 1], [1, 0]]\ntriangles = [[0, 1, 2], [0, 2, 3]]\nmaterial = {{ {material} }}\n"
    )
}

fn assert_alike(a: &[[f32; 4]], b: &[[f32; 4]], may_differ: usize) {
    let alike = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
    let differ = a.iter().zip(b).filter(|(a, b)| !alike(a, b)).count();
    assert!(differ <= may_differ, "{differ} pixels differ");
}

#[test]
fn a_board_with_holes_is_its_squares() {
    let red = "color = \"red\", k_reflect = 0.2";
    let holes = "opacity = { type = \"checkerboard\", density = 2 }";
    let mut squares = VIEW.to_owned();
    for i in 0..8 {
        let (row, column) = (i / 2, 2 * (i % 2) + (i / 2) % 2);
        squares += &square(-1.0 + 0.5 * f64::from(column), -1.0 + 0.5 * f64::from(row), 0.5, red);
    }
    let expected = picture(&scene(&squares));
    let cut = picture(&scene(&format!("{VIEW}{}", square(-1.0, -1.0, 2.0, &format!("{red}, {holes}")))));
    // Pixels whose centre lies on an edge may fall to either side.
    assert_alike(&expected, &cut, 4);
    let full = picture(&scene(&format!("{VIEW}{}", square(-1.0, -1.0, 2.0, red))));
    assert!(full.iter().zip(&cut).filter(|(a, b)| a != b).count() > 1000);
    // The same for a shape that is not a mesh.
    let shape = format!(
        "{VIEW}[[object]]\ntype = \"rectangle\"\nedge_u = [2, 0, 0]\nedge_v = [0, 0, 2]\nmaterial = {{ {red}, {holes} }}\n"
    );
    assert_alike(&expected, &picture(&scene(&shape)), 4);
    // A constant opacity of 0.
    let none = picture(&scene(&format!("{VIEW}{}", square(-1.0, -1.0, 2.0, "opacity = 0.4"))));
    assert_eq!(none, picture(&scene(VIEW)));
    let all =
        picture(&scene(&format!("{VIEW}{}", square(-1.0, -1.0, 2.0, &format!("{red}, opacity = 0.6")))));
    assert_eq!(all, full);
}

#[test]
fn a_sphere_with_holes_shows_its_inside() {
    let ball = |more: &str| {
        let text = format!("{VIEW}[[object]]\ntype = \"sphere\"\nmaterial = {{ color = \"red\"{more} }}\n");
        picture(&scene(&text))
    };
    let (full, cut) =
        (ball(""), ball(", opacity = { type = \"checkerboard\", density = 3, mapping = \"solid\" }"));
    let differ = full.iter().zip(&cut).filter(|(a, b)| a != b).count();
    assert!(differ > 500, "{differ}");
}

#[test]
fn parts_of_an_obj_have_their_materials() {
    let obj = b"v -1 0 -1 1 0 0\nv -1 0 1 1 0 0\nv 1 0 1 1 0 0\nv 1 0 -1 1 0 0\nv 0 1 0 0 1 0\n\
        usemtl side\nf 1 2 5\nusemtl my front\nf 2 3 5\nusemtl side\nf 3 4 5\nf 4 1 5\n";
    let mesh = decode(obj, "a.obj").unwrap().mesh;
    assert_eq!(
        (mesh.material_names, mesh.face_materials),
        (vec!["side".into(), "my front".into()], vec![0, 1, 0, 0])
    );
    assert_eq!(mesh.colors[4], [0.0, 1.0, 0.0, 1.0]);
    let object = |more: &str| {
        let text = format!(
            "{VIEW}[material.green]\ncolor = \"lime\"\n[[object]]\ntype = \"mesh\"\nfile = \"a.obj\"\nmaterial = {{ color = \"blue\" }}\n{more}\n"
        );
        scene_with(&text, &[("a.obj", obj)], Quality::Balanced)
    };
    let color = |prepared: &Prepared, x: f64, z: f64| {
        let ray = Ray::new(DVec3::new(x, 5.0, z), DVec3::NEG_Y);
        let scene = &prepared.scene;
        let surface = scene.surface(&ray, &scene.intersect(&ray).unwrap());
        surface.material.index()
    };
    let plain = object("");
    assert_eq!(color(&plain, 0.0, 0.5), color(&plain, 0.5, 0.0));
    let parted = object("materials = { \"my front\" = \"green\" }");
    // Only green is named.
    assert_eq!(color(&parted, 0.0, 0.5), 0);
    assert_eq!(color(&parted, 0.5, 0.0), color(&plain, 0.5, 0.0));
    let listed = object("materials = [{ color = \"red\" }, \"green\"]");
    assert!(color(&listed, 0.0, 0.5) == 0 && color(&listed, 0.5, 0.0) != 0);
    let assets = {
        let mut assets = MemoryAssets::default();
        assets.files.insert("a.obj".to_owned(), obj.to_vec());
        assets
    };
    let text = "[[object]]\ntype = \"mesh\"\nfile = \"a.obj\"\nmaterials = { sid = { color = \"red\" } }\n"
        .to_owned();
    let error = load_text(text, "test.toml", &assets, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("sid") && error.contains("side"), "{error}");
}

#[test]
fn vertex_colours_of_a_ply_are_shown() {
    let ply = |kind: &str, one: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property {kind} red\nproperty {kind} green\nproperty {kind} blue\nproperty {kind} alpha\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0 {one} 0 0 {one}\n1 0 0 {one} 0 0 {one}\n0 1 0 {one} 0 0 0\n3 0 1 2\n"
        )
    };
    for (kind, one) in [("uchar", "255"), ("float", "1"), ("ushort", "65535")] {
        let mesh = decode(ply(kind, one).as_bytes(), "a.ply").unwrap().mesh;
        assert_eq!(mesh.colors, [[1.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]]);
    }
    let binary = {
        let mut bytes = ply("uchar", "255").replace("ascii", "binary_little_endian").into_bytes();
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        bytes.truncate(end);
        for (x, y) in [(0.0_f32, 0.0_f32), (1.0, 0.0), (0.0, 1.0)] {
            [x, y, 0.0].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
            bytes.extend([255, 188, 0, 51]);
        }
        bytes.push(3);
        (0..3_i32).for_each(|i| bytes.extend(i.to_le_bytes()));
        bytes
    };
    let mesh = decode(&binary, "a.ply").unwrap().mesh;
    let [r, g, b, a] = mesh.colors[0];
    assert!(r == 1.0 && (g - 0.503).abs() < 1e-3 && b == 0.0 && (a - 0.2).abs() < 1e-6);
    let text = "[integrator]\ntype = \"classic\"\n[[light]]\ntype = \"ambient\"\n[[object]]\ntype = \"mesh\"\nfile = \"a.ply\"\n\
                material = { color = { type = \"vertex-color\" }, opacity = { type = \"vertex-color\" } }\n";
    let scene = scene_with(text, &[("a.ply", ply("float", "1").as_bytes())], Quality::Balanced);
    let hits = |y: f64| scene.scene.intersect(&Ray::new(DVec3::new(0.1, y, 1.0), DVec3::NEG_Z)).is_some();
    assert!(hits(0.45) && !hits(0.55));
    assert!(picture(&scene).iter().any(|p| p[0] > 0.05 && p[1] == 0.0));
}

#[test]
fn many_rays_find_what_each_finds_and_quality_changes_nothing() {
    let mut text = VIEW.to_owned();
    for i in 0..4 {
        text += &square(
            -1.0 + 0.4 * f64::from(i),
            -1.0,
            1.3,
            if i == 1 { "opacity = { type = \"checkerboard\" }" } else { "" },
        );
        text += &format!("transform = {{ rotate = [{}, 20, 0], translate = [0, 0.1, 0] }}\n", 30 * i);
    }
    text += "[[object]]\ntype = \"sphere\"\nradius = 0.4\n";
    let scenes = [Quality::Fast, Quality::Balanced, Quality::High].map(|q| scene_with(&text, &[], q));
    let mut state = 1_u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let rays: Vec<Ray> = (0..3000)
        .map(|_| {
            let origin = 6.0 * DVec3::new(unit(), unit(), unit());
            Ray::new(origin, 2.0 * DVec3::new(unit(), unit(), unit()) - origin)
        })
        .collect();
    let mut found = 0;
    for scene in scenes.iter().map(|p| &p.scene) {
        let (mut batch, mut hits) = (turner::scene::RayBatch::default(), Vec::new());
        rays.iter().for_each(|ray| batch.push(ray));
        scene.intersect_batch(&mut batch, &mut hits);
        for (ray, hit) in rays.iter().zip(&hits) {
            let show = |hit: &Option<turner::scene::Hit>| format!("{hit:?}");
            assert_eq!(show(hit), show(&scene.intersect(ray)));
            assert_eq!(show(hit), show(&scenes[0].scene.intersect(ray)));
            found += usize::from(hit.is_some());
        }
    }
    assert!(found > 3000, "{found}");
}
